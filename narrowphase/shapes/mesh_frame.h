// Where a mesh lies, how large it is, and in which unit its hierarchy is.
#pragma once
#include <limits>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// A box that grows with the points it holds.
struct Extent {
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 hi = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& p) { lo = lo.cwiseMin(p), hi = hi.cwiseMax(p); }
  void add(const Extent& o) { lo = lo.cwiseMin(o.lo), hi = hi.cwiseMax(o.hi); }
};

/// Where a mesh's hierarchy is, and in which unit: as in MeshModel.
struct MeshFrame {
  Vec3 centre, half;
  double unit = 1;
  explicit MeshFrame(const Extent& box);
  MeshFrame(const Vec3& its_centre, const Vec3& its_half, double its_unit)
      : centre(its_centre), half(its_half), unit(its_unit) {}
};

/// How far apart, along an axis, the corners of a surface's borders may be that are one; metres.
double seam_tolerance(const MeshFrame& frame);

}  // namespace tandem
