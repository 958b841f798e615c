// Random numbers that are the same on every machine.
#pragma once
#include <cmath>
#include <cstdint>

#include "tandem/narrowphase/pose.h"

namespace tandem::reference {

/// Random numbers that are the same on every machine: splitmix64 (Steele, Lea, Flood 2014), and no library function but
/// the square root.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }  ///< [0, 1)
  double in(double lo, double hi) { return lo + (hi - lo) * unit(); }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }
  bool once_in(int n) { return below(n) == 0; }
  double sign() { return once_in(2) ? -1.0 : 1.0; }
  Vec3 vec(double lo, double hi) {
    const double x = in(lo, hi), y = in(lo, hi);
    return {x, y, in(lo, hi)};
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 v = vec(-1, 1);
      const double n = v.squaredNorm();
      if (n > 0.01 && n < 1) return v / std::sqrt(n);
    }
  }
  /// A random direction times a length in [lo, hi).
  Vec3 vec_of_length(double lo, double hi) {
    const double length = in(lo, hi);
    return length * direction();
  }
  Quat quaternion() {
    for (;;) {
      const double w = in(-1, 1), x = in(-1, 1), y = in(-1, 1);
      const Quat q(w, x, y, in(-1, 1));
      const double n = q.squaredNorm();
      if (n > 0.01 && n < 1) return Quat(q.coeffs() / std::sqrt(n));
    }
  }
  Mat3 rotation() { return quaternion().toRotationMatrix(); }
  /// A number in 2^lo..2^hi with a uniform exponent, uniform within an octave.
  double power_of_two(int lo, int hi) {
    const double mantissa = 1 + unit();
    return std::ldexp(mantissa, lo + below(hi - lo));
  }

 private:
  std::uint64_t state_;
};

}  // namespace tandem::reference
