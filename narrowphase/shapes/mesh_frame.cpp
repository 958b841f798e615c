// The bounding box of a mesh, and the unit of its hierarchy.
#include "shapes/mesh_frame.h"

#include <cmath>

#include "tolerances.h"

namespace tandem {
namespace {

// Relative to the largest coordinate: the largest distance of two border vertices that count as one.
constexpr double seam_ulps = 16;

}  // namespace

MeshFrame::MeshFrame(const Extent& box) : centre(box.lo + (box.hi - box.lo) / 2) {
  half = (box.hi - centre).cwiseMax(centre - box.lo);
  if (const double most = half.maxCoeff(); most > 0) {
    // Exactly, not by a rounded logarithm: a scaled mesh has a scaled unit.
    int exponent = 0;
    const bool is_power = std::frexp(most, &exponent) == 0.5;
    unit = std::ldexp(1.0, is_power ? exponent : exponent + 1);
  }
}

double seam_tolerance(const MeshFrame& frame) {
  return seam_ulps * epsilon * (frame.centre.cwiseAbs() + frame.half).maxCoeff();
}

}  // namespace tandem
