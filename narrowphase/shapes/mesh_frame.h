// The bounding box of a mesh, and the unit of its hierarchy.
#pragma once
#include <limits>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// A box that grows with the points added to it.
struct Extent {
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 hi = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& p) { lo = lo.cwiseMin(p), hi = hi.cwiseMax(p); }
  void add(const Extent& o) { lo = lo.cwiseMin(o.lo), hi = hi.cwiseMax(o.hi); }
};

/// The centre and unit of a mesh's hierarchy, as in MeshModel.
struct MeshFrame {
  Vec3 centre, half;
  double unit = 1;
  explicit MeshFrame(const Extent& box);
  MeshFrame(const Vec3& its_centre, const Vec3& its_half, double its_unit)
      : centre(its_centre), half(its_half), unit(its_unit) {}
};

/// The largest distance, along an axis, of two border vertices of a surface that count as one; metres.
double seam_tolerance(const MeshFrame& frame);

}  // namespace tandem
