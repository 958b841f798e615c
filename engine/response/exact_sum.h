// An exact sum of doubles, rounded only when it is read, so that it does not depend on their order (Kulisch 1971).
#pragma once
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

namespace tandem {

/// The exact sum of doubles >= 0, up to 2^31 of them.
class ExactSum {
 public:
  void add(double x) {
    if (!std::isfinite(x)) {
      ++not_finite();
      return;
    }
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const std::uint64_t exponent = bits >> 52;
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52) - 1);
    const std::uint64_t digits = exponent == 0 ? fraction : fraction | std::uint64_t{1} << 52;
    // Position of the lowest digit, counted from that of the smallest double.
    const std::uint64_t place = exponent == 0 ? 0 : exponent - 1;
    const std::uint64_t at = place / bits_a_word, shift = place % bits_a_word;
    words_[at] += digits << shift & low;
    words_[at + 1] += digits >> (bits_a_word - shift) & low;
    words_[at + 2] += shift == 0 ? 0 : digits >> (2 * bits_a_word - shift);
  }
  void add(const ExactSum& other) {
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] += other.words_[i];
  }
  /// The sum to the last bit or the one before; infinite if a number was not finite.
  double value() const {
    if (words_.back() != 0) return std::numeric_limits<double>::infinity();
    std::uint64_t carry = 0;
    double sum = 0;
    for (std::size_t i = 0; i + 1 < words_.size(); ++i) {
      const std::uint64_t word = words_[i] + carry;
      carry = word >> bits_a_word;
      sum += std::ldexp(static_cast<double>(word & low), static_cast<int>(bits_a_word * i) - 1074);
    }
    return sum;
  }
  /// The words, which can be added up over ranks that each have a share of the numbers.
  std::span<std::uint64_t> words() { return words_; }

 private:
  static constexpr std::uint64_t bits_a_word = 32;
  static constexpr std::uint64_t low = 0xffffffffu;
  std::uint64_t& not_finite() { return words_.back(); }

  // Digits of 32 bits, with room for carries; the last element counts numbers that are not finite.
  std::array<std::uint64_t, 69> words_{};
};

}  // namespace tandem
