// Error messages about input: one line, valid UTF-8, bounded length.
#include "formats/input_error.h"

#include <algorithm>

#include "formats/input_limits.h"

namespace tandem {
namespace {

unsigned byte_at(std::string_view text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

bool continues(unsigned byte) { return (byte & 0xc0u) == 0x80u; }

/// The number of bytes of the UTF-8 character at the beginning of the text; 0 if there is none (Unicode, table 3-7).
std::size_t character_bytes(std::string_view text) {
  const unsigned first = byte_at(text, 0);
  if (first < 0x80) return 1;
  const std::size_t size = first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
  if (size == 0 || text.size() < size) return 0;
  const unsigned second = byte_at(text, 1);
  const unsigned least = first == 0xe0 ? 0xa0u : first == 0xf0 ? 0x90u : 0x80u;  // rules out overlong encodings
  // Rules out surrogates and values beyond the last.
  const unsigned most = first == 0xed ? 0x9fu : first == 0xf4 ? 0x8fu : 0xbfu;
  if (second < least || second > most) return 0;
  for (std::size_t i = 2; i < size; ++i)
    if (!continues(byte_at(text, i))) return 0;
  return size;
}

/// True for the line and paragraph separators and U+0080 to U+009F, which contain a line end.
bool ends_line(std::string_view character) {
  return (character[0] == '\xc2' && byte_at(character, 1) < 0xa0) || character == "\u2028" || character == "\u2029";
}

std::string joined(const std::string& where, const std::string& found, const std::string& allowed) {
  const std::string rest = found + (allowed.empty() ? "" : (found.empty() ? "allowed: " : ", allowed: ") + allowed);
  if (where.empty()) return shortened(rest, limits::message_bytes);
  // The found and the allowed value are short, so most of the line is left for the place.
  const std::size_t least = limits::message_bytes / 3;
  const std::string end = ": " + shortened(rest, limits::message_bytes - least);
  return shortened(where, limits::message_bytes - end.size()) + end;
}

}  // namespace

std::string on_one_line(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t size = character_bytes(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(1, size));
    if (size == 0)
      out += '?';
    else if (size == 1 && (byte_at(text, 0) < 0x20 || text[0] == '\x7f'))
      out += ' ';
    else if (size > 1 && ends_line(character))
      out += ' ';
    else
      out += character;
    text.remove_prefix(character.size());
  }
  return out;
}

std::string_view first_characters(std::string_view text, std::size_t most) {
  std::size_t end = std::min(most, text.size());
  while (end > 0 && end < text.size() && continues(byte_at(text, end))) --end;
  return text.substr(0, end);
}

std::string shortened(std::string_view text, std::size_t most) {
  if (text.size() <= most) return std::string(text);
  constexpr std::string_view gap = "...";
  const std::size_t kept = most - gap.size();
  std::size_t back = text.size() - kept / 2;
  while (back < text.size() && continues(byte_at(text, back))) ++back;
  return std::string(first_characters(text, kept - kept / 2)).append(gap).append(text.substr(back));
}

std::string quotation(std::string_view found) { return shortened(on_one_line(found), limits::quoted_bytes); }

InputError::InputError(std::string_view where, std::string_view found, std::string_view allowed)
    : std::invalid_argument(joined(on_one_line(where), on_one_line(found), std::string(allowed))),
      where_(where),
      found_(found),
      allowed_(allowed) {}

InputError InputError::within(std::string_view outer) const {
  const std::string where = where_.empty() ? std::string(outer) : std::string(outer) + ": " + where_;
  return {where, found_, allowed_};
}

}  // namespace tandem
