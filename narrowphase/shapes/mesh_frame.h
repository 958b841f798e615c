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

/// The bounding box of a mesh and the unit of its hierarchy.
struct MeshFrame {
  MeshFrame() = default;
  explicit MeshFrame(const Extent& box);

  Vec3 centre = Vec3::Zero(), half = Vec3::Zero();  ///< of the bounding box
  double unit = 1;                                  ///< a power of two, at least the largest half
};

/// The largest distance, along an axis, of two border vertices of a surface that count as one; metres.
double seam_tolerance(const MeshFrame& frame);

}  // namespace tandem
