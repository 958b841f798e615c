#pragma once
#include <string>
#include <string_view>

namespace tandem::bench {

/// zlib stream (RFC 1950), as a browser's DecompressionStream('deflate') reads it.
std::string deflated(std::string_view bytes);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace tandem::bench
