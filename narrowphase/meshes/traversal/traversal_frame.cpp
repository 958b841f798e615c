#include "meshes/traversal/traversal_frame.h"

#include <cmath>

#include "tolerances.h"

namespace tandem {

TraversalFrame::TraversalFrame(const MeshModel& a, const MeshModel& b, const TriangleTest& frame) {
  const double scale = b.unit / a.unit;
  const Mat3 inv = frame.map().inverse();
  const Vec3 between = (frame.map() * b.centre + (frame.shift() - a.centre)) / a.unit;
  const Vec3 half_a = a.half / a.unit, half_b = frame.map().cwiseAbs() * b.half / a.unit;
  gap = (between.cwiseAbs() - half_a - half_b).maxCoeff() - tolerance::whole_boxes;
  if (!(gap <= 0)) return;
  // Coordinates of A are rounded once, those of B go through three products and sums of rounded factors: 6 units in
  // the last place of the largest term, 2^-24 each. Comparing them takes a few more.
  const Vec3 size = half_a + half_b + between.cwiseAbs();
  const Vec3 pad = tolerance::box_of_floats * size + Vec3::Constant(4 * frame.delta() / a.unit + tolerance::no_extent);
  const Vec3 along_b = 3 * (inv.cwiseAbs() * pad);
  for (int i = 0; i < 3; ++i) {
    shift[i] = static_cast<float>(between[i]);
    pad_a[i] = static_cast<float>(pad[i]);
    pad_b[i] = static_cast<float>(along_b[i]);
    for (int j = 0; j < 3; ++j) {
      map[i][j] = static_cast<float>(frame.map()(i, j) * scale);
      inverse[i][j] = static_cast<float>(inv(i, j));
    }
  }
  ratio = static_cast<float>(scale);
  // Nothing is compared in these: 1, 6 and 2 units.
  const Vec3 rounded = 1.3 * std::exp2(-24) * (half_a + 6 * half_b + 2 * between.cwiseAbs());
  off = static_cast<float>((rounded + Vec3::Constant(4 * frame.delta() / a.unit + tolerance::no_extent)).maxCoeff());
}

}  // namespace tandem
