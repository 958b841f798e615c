// Support functions of cores, and the relative pose of a pair.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "shapes/convex_view.h"
#include "shapes/hull.h"
#include "shapes/kind_rows.h"
#include "shapes/support_kernel.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {

/// The radius of a shape about its core. Every bounded convex shape is a core with a radius about each of its points: a
/// sphere's core is a point, a capsule's a segment, all others are their own core with radius 0. Solvers work on cores,
/// so the radius never needs iterations.
inline double core_radius(const ConvexView& v) {
  constexpr KindSet swept = kinds_where([](const KindRow& row) { return row.swept; });
  return swept.has(v.kind) ? v.param[0] : 0.0;
}

/// True if the core of a shape of this kind has only flat faces, straight edges and vertices, or is a point.
constexpr bool is_polytope(ShapeKind kind) {
  constexpr KindSet flat = kinds_where([](const KindRow& row) { return row.core == CoreSurface::flat; });
  return flat.has(kind);
}

/// A point of a core and, for polytopes, its vertex number: equal numbers mean equal points.
struct SupportPoint {
  Vec3 p;
  std::uint32_t vertex;
};

/// The vertex of a polytope's core with a number that `core_support` returned, in the shape's frame.
inline Vec3 core_vertex(const ConvexView& v, std::uint32_t vertex) {
  switch (v.kind) {
    case ShapeKind::box:
      return {vertex & 1u ? -v.param[0] : v.param[0], vertex & 2u ? -v.param[1] : v.param[1],
              vertex & 4u ? -v.param[2] : v.param[2]};
    case ShapeKind::capsule:
      return {0, 0, vertex != 0 ? -0.5 * v.param[1] : 0.5 * v.param[1]};
    case ShapeKind::convex:
    case ShapeKind::triangle:
      return v.vertices[vertex];
    case ShapeKind::sphere:
    case ShapeKind::cylinder:
    case ShapeKind::cone:
    case ShapeKind::ellipsoid:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  return Vec3::Zero();
}

/// The factor that takes a vector of length `rho` in the plane of a disc to its circle. Along its axis all points of a
/// disc are equally far, so for tiny `rho`, whose vector has no accurate direction, the centre stands for it.
inline double onto_circle(double radius, double rho) { return rho > tolerance::shortest_squared ? radius / rho : 0.0; }

/// A point of the core farthest along d (no shorter than 1e-100), in the shape's frame.
inline SupportPoint core_support_point(const ConvexView& v, const Vec3& d, SupportKernel kernel) {
  const auto negative = [&](int k) { return std::signbit(d[k]) ? 1u : 0u; };
  switch (v.kind) {
    case ShapeKind::box: {
      return {{std::copysign(v.param[0], d[0]), std::copysign(v.param[1], d[1]), std::copysign(v.param[2], d[2])},
              negative(0) | negative(1) << 1 | negative(2) << 2};
    }
    case ShapeKind::capsule:
      return {{0, 0, std::copysign(0.5 * v.param[1], d[2])}, negative(2)};
    case ShapeKind::cylinder: {
      const double s = onto_circle(v.param[0], std::sqrt(d[0] * d[0] + d[1] * d[1]));
      return {{d[0] * s, d[1] * s, std::copysign(0.5 * v.param[1], d[2])}, 0};
    }
    case ShapeKind::cone: {
      const double rho = std::sqrt(d[0] * d[0] + d[1] * d[1]);
      if (d[2] * v.param[1] > rho * v.param[0]) return {{0, 0, 0.5 * v.param[1]}, 0};
      const double s = onto_circle(v.param[0], rho);
      return {{d[0] * s, d[1] * s, -0.5 * v.param[1]}, 0};
    }
    case ShapeKind::ellipsoid: {
      const Vec3 r{v.param[0], v.param[1], v.param[2]};
      const Vec3 q = r.cwiseProduct(d);
      const double length = q.norm();
      return {length > 0 ? Vec3(r.cwiseProduct(q) / length) : Vec3(r[0], 0, 0), 0};
    }
    case ShapeKind::convex:
    case ShapeKind::triangle: {
      if (v.vertices.size() > 4) {
        const std::uint32_t best = kernel(v.hull->support, v.vertices.data(), d.data());
        return {v.vertices[best], best};
      }
      std::uint32_t best = 0;
      double most = v.vertices[0].dot(d);
      for (std::uint32_t i = 1; i < v.vertices.size(); ++i) {
        const double along = v.vertices[i].dot(d);
        if (along > most) most = along, best = i;
      }
      return {v.vertices[best], best};
    }
    case ShapeKind::sphere:
    case ShapeKind::halfspace:  // has no farthest point
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:       // its triangles and its hull have
      break;
  }
  return {Vec3::Zero(), 0};
}
inline Vec3 core_support(const ConvexView& v, const Vec3& d) { return core_support_point(v, d, support_kernel()).p; }

/// The centre of the shape's core, in its frame: inside it for every kind.
inline Vec3 core_centre(const ConvexView& v) {
  if (v.hull != nullptr) return v.hull->inside;
  if (v.vertices.empty()) return Vec3::Zero();
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : v.vertices) sum += p;
  return sum / static_cast<double>(v.vertices.size());
}

/// The radius of a ball about that point inside the core; 0 if none is known.
inline double core_inner_radius(const ConvexView& v) {
  const double radius = v.param[0], half = 0.5 * v.param[1];
  switch (v.kind) {
    case ShapeKind::box:
    case ShapeKind::ellipsoid:
      return std::min({v.param[0], v.param[1], v.param[2]});
    case ShapeKind::cylinder:
      return std::min(radius, half);
    case ShapeKind::cone:
      return half * radius / std::hypot(radius, 2 * half);
    case ShapeKind::sphere:
    case ShapeKind::capsule:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::convex:
    case ShapeKind::triangle:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  return v.hull != nullptr ? v.hull->inner_radius : 0;
}

/// Some unit vector perpendicular to v (v not zero).
inline Vec3 any_perpendicular(const Vec3& v) {
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(v[i]) < std::abs(v[least])) least = i;
  return unit(v.cross(Vec3::Unit(least)));
}

/// The pose of B in A's frame. Translations are subtracted before rotating, so that pairs far from the origin are as
/// exact as near ones.
struct RelativePose {
  Mat3 rotation;
  Vec3 translation;
};
inline RelativePose relative(const Pose& a, const Pose& b) {
  RelativePose r;
  const Vec3 d = b.translation - a.translation;
  for (int i = 0; i < 3; ++i) {
    r.translation[i] = a.rotation.col(i).dot(d);
    for (int j = 0; j < 3; ++j) r.rotation(i, j) = a.rotation.col(i).dot(b.rotation.col(j));
  }
  return r;
}

/// A solver's answer, in A's frame. gap = upper - lower bound of the signed distance, 0 if exact to rounding.
struct LocalAnswer {
  double signed_distance = 0;
  Vec3 point_a = Vec3::Zero();
  Vec3 point_b = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< from A to B
  double gap = 0;
};

/// The answer for shapes whose cores are farther apart than `beyond` and their radii together, by `cores` along n: the
/// points are not set. The distance exceeds `beyond` in spite of the rounding of radii, so no one takes the points.
inline LocalAnswer farther_than(double beyond, double cores, double radius_a, double radius_b, const Vec3& n) {
  LocalAnswer apart;
  apart.signed_distance = std::max(cores - radius_a - radius_b, std::nextafter(beyond, infinity));
  apart.normal = n;
  return apart;
}

}  // namespace tandem
