// Exact integers and dyadic numbers, for the predicates.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace tandem {

__extension__ using Uint128 = unsigned __int128;

/// An integer of 64 * Limbs bits, in two's complement. A product has the limbs of both factors and is always exact;
/// sums and differences are exact if they fit.
template <std::size_t Limbs>
class WideInt {
 public:
  WideInt() = default;
  /// Adds or subtracts magnitude * 2^shift; the sum must fit.
  void add(Uint128 magnitude, unsigned shift, bool negative) {
    const std::size_t first = shift / 64;
    const unsigned bits = shift % 64;
    const auto low = static_cast<std::uint64_t>(magnitude), high = static_cast<std::uint64_t>(magnitude >> 64);
    const std::array<std::uint64_t, 3> part{low << bits, bits ? high << bits | low >> (64 - bits) : high,
                                            bits ? high >> (64 - bits) : 0};
    // -x is ~x + 1, and the complement extends to the left.
    const std::uint64_t flip = negative ? ~std::uint64_t{0} : 0;
    std::uint64_t carry = negative;
    for (std::size_t i = first; i < Limbs; ++i) {
      const Uint128 s = Uint128{limb_[i]} + ((i - first < 3 ? part[i - first] : 0) ^ flip) + carry;
      limb_[i] = static_cast<std::uint64_t>(s);
      carry = static_cast<std::uint64_t>(s >> 64);
    }
  }

  int sign() const {
    if (limb_[Limbs - 1] >> 63) return -1;
    std::uint64_t any = 0;
    for (const std::uint64_t x : limb_) any |= x;
    return any != 0;
  }

  friend WideInt operator+(const WideInt& x, const WideInt& y) {
    WideInt r;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < Limbs; ++i) {
      const Uint128 s = Uint128{x.limb_[i]} + y.limb_[i] + carry;
      r.limb_[i] = static_cast<std::uint64_t>(s);
      carry = static_cast<std::uint64_t>(s >> 64);
    }
    return r;
  }
  friend WideInt operator-(const WideInt& x, const WideInt& y) {
    WideInt r;
    r.limb_ = x.limb_;
    r.subtract(y, 0);
    return r;
  }
  template <std::size_t More>
  friend WideInt<Limbs + More> operator*(const WideInt& x, const WideInt<More>& y) {
    WideInt<Limbs + More> r;
    for (std::size_t i = 0; i < Limbs; ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; j < More; ++j) {
        const Uint128 s = Uint128{x.limb_[i]} * y.limb(j) + r.limb(i + j) + carry;
        r.limb(i + j) = static_cast<std::uint64_t>(s);
        carry = static_cast<std::uint64_t>(s >> 64);
      }
      r.limb(i + More) = carry;
    }
    // Read as unsigned, a negative factor is too large by 2^bits.
    if (x.limb_[Limbs - 1] >> 63) r.subtract(y, Limbs);
    if (y.limb(More - 1) >> 63) r.subtract(x, More);
    return r;
  }

  std::uint64_t& limb(std::size_t i) { return limb_[i]; }
  std::uint64_t limb(std::size_t i) const { return limb_[i]; }

  /// this - x * 2^(64 * from), modulo 2^(64 * Limbs).
  template <std::size_t Other>
  void subtract(const WideInt<Other>& x, std::size_t from) {
    std::uint64_t borrow = 0;
    for (std::size_t i = from; i < Limbs && i - from < Other; ++i) {
      const Uint128 s = Uint128{limb_[i]} - x.limb(i - from) - borrow;
      limb_[i] = static_cast<std::uint64_t>(s);
      borrow = static_cast<std::uint64_t>(s >> 64) & 1;
    }
    for (std::size_t i = from + Other; borrow && i < Limbs; ++i) borrow = limb_[i]-- == 0;
  }

 private:
  std::array<std::uint64_t, Limbs> limb_{};
};

/// An integer of any length.
class UnboundedInt {
 public:
  UnboundedInt() = default;
  void add(Uint128 magnitude, unsigned shift, bool negative) {
    const Value x = Value(magnitude) << shift;
    negative ? value_ -= x : value_ += x;
  }
  int sign() const { return value_.sign(); }
  friend UnboundedInt operator+(const UnboundedInt& x, const UnboundedInt& y) {
    return UnboundedInt(x.value_ + y.value_);
  }
  friend UnboundedInt operator-(const UnboundedInt& x, const UnboundedInt& y) {
    return UnboundedInt(x.value_ - y.value_);
  }
  friend UnboundedInt operator*(const UnboundedInt& x, const UnboundedInt& y) {
    return UnboundedInt(x.value_ * y.value_);
  }

 private:
  using Value = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
  explicit UnboundedInt(Value value) : value_(std::move(value)) {}
  Value value_ = 0;
};

/// A double, exactly: mantissa * 2^exponent with an odd mantissa, or 0.
struct Dyadic {
  std::uint64_t mantissa = 0;
  int exponent = 0;
  bool negative = false;

  Dyadic() = default;
  explicit Dyadic(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto field = static_cast<int>(bits >> 52 & 0x7ff);
    mantissa = (bits & 0xfffffffffffffull) | (field ? 1ull << 52 : 0);
    if (mantissa == 0) return;
    const int zeros = std::countr_zero(mantissa);
    mantissa >>= zeros;
    exponent = std::max(field, 1) - 1075 + zeros;
    negative = bits >> 63;
  }
  /// The exponent of the leading bit, plus one.
  int top() const { return exponent + static_cast<int>(std::bit_width(mantissa)); }
};

}  // namespace tandem
