#include "tandem/broadphase/box_array.h"

#include <algorithm>
#include <cmath>

namespace tandem {

float round_up(double x) {
  constexpr float largest = std::numeric_limits<float>::max();
  const float nearest = static_cast<float>(std::clamp(x, -double{largest}, double{largest}));
  return nearest >= x || nearest == largest ? nearest : std::nextafter(nearest, largest);
}

float round_down(double x) { return -round_up(-x); }

void BoxArray::resize(std::size_t n) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  for (std::size_t bound = 0; bound < 6; ++bound) {
    std::vector<float>& values = bounds_[bound];
    const float empty = bound < 3 ? inf : -inf;
    values.resize(n + padding);
    std::fill(values.begin() + static_cast<std::ptrdiff_t>(std::min(size_, n)), values.end(), empty);
  }
  size_ = n;
}

}  // namespace tandem
