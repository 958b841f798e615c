// Texts for error messages about input.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "tandem/formats/input_error.h"

namespace tandem {

/// The text on one line and as valid UTF-8: a space for each control character, a question mark for each byte that
/// belongs to no character.
std::string on_one_line(std::string_view text);

/// The text if it has at most `most` bytes, else its beginning and its end with "..." between. Cuts only between
/// characters.
std::string shortened(std::string_view text, std::size_t most);

/// The longest prefix of whole characters with at most `most` bytes.
std::string_view first_characters(std::string_view text, std::size_t most);

/// A value as an error message quotes it: one line of at most limits::quoted_bytes.
std::string quotation(std::string_view found);

}  // namespace tandem
