// Boxes in floats, rounded outwards, as one array for each bound.
#include "tandem/broadphase/box_array.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "storage/memory.h"

namespace tandem {
namespace {

constexpr float unbounded = std::numeric_limits<float>::infinity();

}  // namespace

float round_up(double x) {
  constexpr double largest = std::numeric_limits<float>::max();
  const double finite = std::clamp(x, -largest, largest);
  const auto nearest = static_cast<float>(finite);
  // Steps to the next float where rounding went down, by its bits: half of all numbers take each case, which no branch
  // predictor foresees, and std::nextafter is a call into the C library. A zero that was rounded down is not negative.
  const auto bits = std::bit_cast<std::int32_t>(nearest);
  return std::bit_cast<float>(bits + (nearest < finite ? 1 : 0) * ((bits >> 31) | 1));
}

float round_down(double x) { return -round_up(-x); }

std::size_t BoxArray::memory() const {
  std::size_t bytes = 0;
  for (const auto& values : bounds_) bytes += bytes_of(values);
  return bytes;
}

// Here and not in the header: a host's -ffast-math would take infinity for a value that does not occur.
void BoxArray::set_empty(std::size_t i) {
  set(i, {{unbounded, unbounded, unbounded}, {-unbounded, -unbounded, -unbounded}});
}

void BoxArray::resize(std::size_t n) {
  for (std::size_t bound = 0; bound < 6; ++bound) {
    std::vector<float>& values = bounds_[bound];
    const float empty = bound < 3 ? unbounded : -unbounded;
    values.resize(n + padding);
    std::fill(values.begin() + static_cast<std::ptrdiff_t>(std::min(size_, n)), values.end(), empty);
  }
  size_ = n;
}

}  // namespace tandem
