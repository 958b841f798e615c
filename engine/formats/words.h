// Words and numbers of text files, with their line numbers.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "formats/text_file.h"

namespace tandem {

/// Removes a byte order mark, which some editors write before UTF-8.
std::string_view without_byte_order_mark(std::string_view text);

/// The words of a text, with their line numbers. With `comment`, the rest of a line after that character is skipped.
class Words {
 public:
  /// Both are kept by reference. `file` names the text in errors.
  Words(const std::string& file, std::string_view text, char comment = '\0')
      : file_(file), text_(text), comment_(comment) {}

  std::size_t line() const { return line_; }
  /// The number of bytes consumed.
  std::size_t position() const { return at_; }
  /// "FILE:LINE"
  std::string place() const { return file_ + ':' + std::to_string(line_); }
  /// Throws InputError "FILE:LINE: 'FOUND', allowed: ALLOWED"; an empty `found` means the end of the line or file.
  [[noreturn]] void fail(std::string_view found, std::string_view allowed) const;

  /// The next word of the text; empty at its end.
  std::string_view next();
  /// The next word of this line; empty at its end. A backslash at its end joins the next line to it.
  std::string_view next_of_line();
  /// Skips the rest of this line; false at the end of the text.
  bool next_line();

  /// Reads a word that must be present, and fails with its line number if it is something else.
  void expect(std::string_view wanted);
  double coordinate() { return coordinate(next()); }
  double coordinate(std::string_view word) const;  ///< finite, correctly rounded to a double
  std::int64_t whole() { return whole(next()); }
  std::int64_t whole(std::string_view word) const;

 private:
  void skip(bool lines);
  bool joins();
  std::string_view word();

  const std::string& file_;
  std::string_view text_;
  char comment_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

}  // namespace tandem
