// Numbers of binary files in either byte order.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace tandem {

/// A number of a binary file, an integer or an IEEE float or double, with the most or the least significant byte first.
template <typename T>
T number_from(const char* bytes, bool big_endian) {
  using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t,
                                  std::conditional_t<sizeof(T) == 4, std::uint32_t,
                                                     std::conditional_t<sizeof(T) == 2, std::uint16_t, std::uint8_t>>>;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    bits = bits << 8 | static_cast<unsigned char>(bytes[big_endian ? i : sizeof(T) - 1 - i]);
  return std::bit_cast<T>(static_cast<Bits>(bits));
}

template <typename T>
T little_endian(const char* bytes) {
  return number_from<T>(bytes, false);
}

}  // namespace tandem
