// Compression and base64 of the report's data.
#pragma once
#include <string>
#include <string_view>

namespace tandem::bench {

/// The bytes as a zlib stream (RFC 1950), as a browser's DecompressionStream('deflate') reads it.
std::string deflated(std::string_view bytes);

/// The bytes in base64 (RFC 4648), with padding.
std::string base64(std::string_view bytes);

}  // namespace tandem::bench
