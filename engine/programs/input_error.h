#pragma once
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace tandem {

/// The text on one line and as valid UTF-8: a space for each control character, a question mark for each byte that
/// belongs to no character.
std::string on_one_line(std::string_view text);

/// The text if it has at most `most` bytes, else its beginning and its end with "..." between. Cuts between characters.
std::string shortened(std::string_view text, std::size_t most);

/// As many of the text's characters as have at most `most` bytes.
std::string_view first_characters(std::string_view text, std::size_t most);

/// What a refusal quotes of the value found: one line of at most limits::quoted_bytes.
std::string quotation(std::string_view found);

/// Input that cannot be used: what() is one line of at most limits::message_bytes that tells where, the value found and
/// what is allowed.
class InputError : public std::invalid_argument {
 public:
  /// "WHERE: FOUND, allowed: ALLOWED", without the parts that are empty. Of a long `where` the middle is left out.
  /// `found` is a short text: of a value in the input what quotation() says.
  InputError(std::string_view where, std::string_view found, std::string_view allowed = {});
  /// The same, found in a larger whole: "OUTER: WHERE: ...".
  InputError within(std::string_view outer) const;

 private:
  std::string where_, found_, allowed_;
};

}  // namespace tandem
