// Random numbers that are the same on every machine.
#include "scene/random.h"

#include <cmath>

namespace tandem {

std::uint64_t Random::bits() {
  state_ += 0x9e3779b97f4a7c15u;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double Random::uniform(double lo, double hi) {
  const double unit = static_cast<double>(bits() >> 11) / static_cast<double>(std::uint64_t{1} << 53);
  return lo + (hi - lo) * unit;
}

// A try fails with probability 0.21; after 64 of them (1e-43) the centre is returned.
Random::DiscPoint Random::disc_point() {
  for (int attempt = 0; attempt < 64; ++attempt) {
    const double x = uniform(-1, 1);
    const double y = uniform(-1, 1);
    const double squared = x * x + y * y;
    if (squared < 1) return {x, y, squared};
  }
  return {0, 0, 0};
}

// Marsaglia (1972): two points of the unit disc make a uniform point of the 3-sphere, without trigonometry. Only the
// direction of the second counts; the centre gets an arbitrary one.
Mat3 Random::rotation() {
  const DiscPoint p = disc_point();
  DiscPoint q = disc_point();
  if (q.squared_radius == 0) q = {1, 0, 1};
  const double scale = std::sqrt((1 - p.squared_radius) / q.squared_radius);
  return Quat(p.x, p.y, q.x * scale, q.y * scale).normalized().toRotationMatrix();
}

}  // namespace tandem
