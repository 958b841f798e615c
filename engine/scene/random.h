// Random numbers that are the same on every machine.
#pragma once
#include <cstdint>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// SplitMix64 (Steele, Lea, Flood 2014) with its own conversions, since the standard's distributions differ between
/// standard libraries. Only + - * / and sqrt, so the same seed gives the same bits on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits();
  double uniform(double lo, double hi);  ///< in [lo, hi)
  Mat3 rotation();                       ///< uniform over all rotations

 private:
  struct DiscPoint {
    double x, y, squared_radius;
  };
  DiscPoint disc_point();

  std::uint64_t state_;
};

}  // namespace tandem
