// The Minkowski difference A - B of two cores.
#pragma once
#include <algorithm>

#include "shapes/support.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// A point of the Minkowski difference A - B with the point of A it comes from. For polytopes the vertices of A and B
/// are numbered.
struct MinkowskiPoint {
  Vec3 w;
  Vec3 a;
  std::uint32_t vertex_a;
  std::uint32_t vertex_b;
};

struct MinkowskiDifference;
/// The point of the difference farthest along n, in A's frame.
using MinkowskiKernel = void (*)(const MinkowskiDifference& d, const Vec3& n, MinkowskiPoint& out);
MinkowskiKernel minkowski_kernel();

/// A - B of two cores in A's frame.
struct MinkowskiDifference {
  const ConvexView& a;
  const ConvexView& b;
  RelativePose pose;
  const WorkLimit* limit = nullptr;  ///< of long searches: WorkStopped is thrown
  MinkowskiKernel kernel = minkowski_kernel();

  MinkowskiPoint support(const Vec3& n) const {
    MinkowskiPoint p;
    kernel(*this, n, p);
    return p;
  }
  /// p - q for two points of polytopes: exact relative to the length of the edges it is made of, not to that of p and
  /// q.
  Vec3 edge(const MinkowskiPoint& p, const MinkowskiPoint& q) const {
    return (core_vertex(a, p.vertex_a) - core_vertex(a, q.vertex_a)) -
           pose.rotation * (core_vertex(b, p.vertex_b) - core_vertex(b, q.vertex_b));
  }
  bool polytopes() const { return is_polytope(a.kind) && is_polytope(b.kind); }
  /// The unit of absolute rounding errors of points near both origins.
  double scale() const { return a.size + b.size + pose.translation.norm(); }
};

/// The unit of absolute rounding errors where a hull may be far from its own origin.
inline double rounding_scale(const MinkowskiDifference& d) {
  const auto off_origin = [](const ConvexView& v) { return v.hull != nullptr ? v.hull->inside.norm() : 0.0; };
  return d.scale() + off_origin(d.a) + off_origin(d.b);
}

/// True if no ball is known in the difference that is as wide as a thin overlap; the sum of both shapes' inscribed
/// balls is in it.
inline bool may_be_thin(const MinkowskiDifference& d) {
  return core_inner_radius(d.a) + core_inner_radius(d.b) < tolerance::thin_overlap * d.scale();
}

/// The unit of relative tolerances.
inline double larger(const MinkowskiDifference& d) { return std::max(d.a.size, d.b.size); }

}  // namespace tandem
