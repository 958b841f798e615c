// Splits the text of mesh files into words and numbers.
#include "formats/words.h"

#include <charconv>
#include <cmath>
#include <cstdlib>

namespace tandem {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f'; }

/// Removes a plus sign, which std::from_chars does not accept.
std::string_view digits_of(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

}  // namespace

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view mark = "\xef\xbb\xbf";
  if (text.starts_with(mark)) text.remove_prefix(mark.size());
  return text;
}

void Words::fail(std::string_view found, std::string_view allowed) const {
  if (found.empty()) found = at_ == text_.size() ? "end of file" : "end of line";
  throw InputError(place(), '\'' + quotation(found) + '\'', allowed);
}

std::string_view Words::next() {
  skip(true);
  return word();
}

std::string_view Words::next_of_line() {
  skip(false);
  while (at_ < text_.size() && text_[at_] == '\\' && joins()) skip(false);
  return word();
}

bool Words::next_line() {
  while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  if (at_ == text_.size()) return false;
  ++at_;
  ++line_;
  return at_ < text_.size();
}

void Words::skip(bool lines) {
  for (; at_ < text_.size(); ++at_) {
    if (comment_ != '\0' && text_[at_] == comment_)
      while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    if (at_ == text_.size() || !is_space(text_[at_])) return;
    if (text_[at_] != '\n') continue;
    if (!lines) return;
    ++line_;
  }
}

bool Words::joins() {
  std::size_t end = at_ + 1;
  if (end < text_.size() && text_[end] == '\r') ++end;
  if (end >= text_.size() || text_[end] != '\n') return false;
  at_ = end + 1;
  ++line_;
  return true;
}

std::string_view Words::word() {
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_space(text_[at_]) && (comment_ == '\0' || text_[at_] != comment_)) ++at_;
  return text_.substr(begin, at_ - begin);
}

void Words::expect(std::string_view wanted) {
  const std::string_view found = next();
  if (found != wanted) fail(found, wanted);
}

double Words::coordinate(std::string_view word) const {
  const std::string_view digits = digits_of(word);
  double x = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), x);
  // A number too small for a double is read as zero.
  const bool tiny =
      error == std::errc::result_out_of_range && std::abs(std::strtod(std::string(digits).c_str(), nullptr)) < 1;
  if (tiny) return 0;
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(x)) fail(word, "a finite number");
  return x;
}

std::int64_t Words::whole(std::string_view word) const {
  const std::string_view digits = digits_of(word);
  std::int64_t x = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), x);
  if (error != std::errc() || end != digits.data() + digits.size()) fail(word, "a whole number");
  return x;
}

}  // namespace tandem
