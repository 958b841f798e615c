#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace tandem {

/// As a .gz file has it.
std::string gzipped(std::string_view bytes);
/// Whether it begins as such a file does.
bool is_gzipped(std::string_view bytes);
/// What such a file holds. Throws InputError for one that is damaged, or of more than `most` bytes.
std::string gunzipped(std::string_view bytes, std::size_t most);

}  // namespace tandem
