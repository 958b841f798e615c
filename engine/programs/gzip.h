// Compression of files whose names end in .gz.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace tandem {

/// The bytes in gzip format (RFC 1952).
std::string gzipped(std::string_view bytes);
/// True if the bytes begin like a gzip file.
bool is_gzipped(std::string_view bytes);
/// The contents of a gzip file. Throws InputError if it is damaged, or has more than `most` bytes.
std::string gunzipped(std::string_view bytes, std::size_t most);

}  // namespace tandem
