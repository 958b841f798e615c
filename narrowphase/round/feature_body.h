// Bodies whose nearest features are searched: the point nearest to another, and the feature on which it lies.
#pragma once
#include <limits>

#include "round/feature_points.h"
#include "shapes/minkowski_difference.h"

namespace tandem {

/// A posed core, in A's frame.
struct FeatureBody {
  const ConvexView& core;
  const Mat3* axes;  ///< null: the frame's axes
  Vec3 centre;

  Vec3 local_direction(const Vec3& v) const { return axes != nullptr ? Vec3(axes->transpose() * v) : v; }
  Vec3 local_point(const Vec3& p) const { return axes != nullptr ? Vec3(axes->transpose() * (p - centre)) : p; }
  Vec3 frame_point(const Vec3& q) const { return axes != nullptr ? Vec3(*axes * q + centre) : q; }
  Vec3 frame_direction(const Vec3& v) const { return axes != nullptr ? Vec3(*axes * v) : v; }
  Vec3 axis(int k) const { return axes != nullptr ? Vec3(axes->col(k)) : Vec3(Vec3::Unit(k)); }

  /// The support along n relative to its centre.
  double reach(const Vec3& n) const {
    const Vec3 m = local_direction(n);
    const double half = 0.5 * core.param[1];
    switch (core.kind) {
      case ShapeKind::box:
        return core.param[0] * std::abs(m[0]) + core.param[1] * std::abs(m[1]) + core.param[2] * std::abs(m[2]);
      case ShapeKind::capsule:
        return half * std::abs(m[2]);
      case ShapeKind::cylinder:
        return core.param[0] * std::sqrt(m[0] * m[0] + m[1] * m[1]) + half * std::abs(m[2]);
      case ShapeKind::convex:
        return core_support(core, m).dot(m);
      case ShapeKind::cone:
        return std::max(half * m[2], core.param[0] * std::sqrt(m[0] * m[0] + m[1] * m[1]) - half * m[2]);
      case ShapeKind::sphere:
      case ShapeKind::ellipsoid:
      case ShapeKind::halfspace:
      case ShapeKind::plane:
      case ShapeKind::triangle:
      case ShapeKind::voxels:
      case ShapeKind::mesh:
        break;  // kinds without features (have_features)
    }
    return std::numeric_limits<double>::infinity();
  }
  Vec3 support(const Vec3& n) const { return frame_point(core_support(core, local_direction(n))); }
};

/// The point of a body nearest to another point.
struct NearestOnBody {
  Vec3 q;  ///< in the body's frame
  Surface surface;
  bool inside = false;                            ///< the given point lies in the body, deeper than rounding
  std::uint32_t vertex = 0, other = 0, face = 0;  ///< for a hull: as in NearestOnHull
};

/// Moves p to the nearest point of the body. On a hull the search starts at the last result, if any.
NearestOnBody project(const FeatureBody& body, Vec3& p, double least, const NearestOnBody* last = nullptr);

/// The feature on which that point lies.
Feature feature(const FeatureBody& body, const NearestOnBody& nearest, double least);

/// The nearest points of two features; w.n approximates the direction. False where it leaves them.
bool nearest_points(const FeatureBody& a, const Feature& fa, const FeatureBody& b, const Feature& fb, double rounding,
                    NearestPoints& w);

}  // namespace tandem
