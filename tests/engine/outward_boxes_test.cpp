// Boxes of shapes rounded outward to floats.
#include "pipeline/outward_boxes.h"

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "catch.h"
#include "tandem/broadphase/box_array.h"

using namespace tandem;

TEST_CASE("many bounds are rounded outward as one is, bit for bit") {
  constexpr double most = std::numeric_limits<float>::max(), least = std::numeric_limits<float>::denorm_min();
  std::vector<double> values = {0,     -0.0,    1,   -1,   0.1,       -0.1,       most,        -most,     2 * most,
                                1e300, -1e300,  1.5, -3,   least,     -least,     0.4 * least, 1e-300,    -1e-300,
                                1e38,  -3.3e38, 1e5, 1e-5, 1.0 / 3.0, 16777217.0, -16777217.0, 1 + 1e-15, -1 - 1e-15};
  std::mt19937_64 random(1);
  while (values.size() < 6000) {
    const double x = std::bit_cast<double>(random());
    if (std::abs(x) <= 1e300) values.push_back(values.size() % 2 == 0 ? x : static_cast<double>(random()) * 1e-15 - 5);
  }
  for (const double grow : {0.0, 0.25}) {
    std::size_t next = 0;
    while (next < values.size()) {
      BoundsRows rows;
      for (std::size_t k = 0; k < BoundsRows::bodies; ++k)
        for (int axis = 0; axis < 3; ++axis) {
          rows.lo[axis][k] = values[next++ % values.size()];
          rows.hi[axis][k] = values[(next + k) % values.size()];
        }
      FloatRows out;
      round_outward(rows, grow, out);
      for (std::size_t k = 0; k < BoundsRows::bodies; ++k)
        for (int axis = 0; axis < 3; ++axis) {
          const double lo = rows.lo[axis][k], hi = rows.hi[axis][k];
          CAPTURE(lo, hi, grow);
          REQUIRE(out.lo[axis][k] == round_down(lo - grow));
          REQUIRE(out.hi[axis][k] == round_up(hi + grow));
        }
    }
  }
}
