// Random shapes and pairs.
#pragma once
#include <cmath>

#include "random.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::test {

using reference::Random;

inline constexpr ShapeKind bounded_convex[] = {ShapeKind::sphere,   ShapeKind::box,     ShapeKind::capsule,
                                               ShapeKind::cylinder, ShapeKind::cone,    ShapeKind::ellipsoid,
                                               ShapeKind::convex,   ShapeKind::triangle};

/// A ball, box, capsule, cylinder, cone or truncated pyramid in turn, which touches each side of the box about it, and
/// half the edges of that box.
inline std::pair<Shape, Vec3> resting_shape(int i, Random& r) {
  const double x = r.in(0.05, 0.4), y = r.in(0.05, 0.4), z = r.in(0.05, 0.4);
  switch (i % 6) {
    case 0:
      return {Sphere{x}, Vec3::Constant(x)};
    case 1:
      return {Box{2 * Vec3(x, y, z)}, Vec3(x, y, z)};
    case 2:
      return {Capsule{x, 2 * z}, Vec3(x, x, x + z)};
    case 3:
      return {Cylinder{x, 2 * z}, Vec3(x, x, z)};
    case 4:
      return {Cone{x, 2 * z}, Vec3(x, x, z)};
    default:
      break;
  }
  Convex pyramid;
  for (const double sx : {-x, x})
    for (const double sy : {-y, y})
      pyramid.vertices.insert(pyramid.vertices.end(), {{sx, sy, -z}, {sx / 2, sy / 2, z}});
  return {Shape(pyramid), Vec3(x, y, z)};
}

/// The cells of a cube of eight but for one, at whose corner (1, 1, 1) three faces meet.
inline const std::vector<std::array<std::int32_t, 3>> corner_cells{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                                                                   {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};

/// A shape of the kind, about 1 in size.
inline Shape random_shape(ShapeKind kind, Random& r) {
  switch (kind) {
    case ShapeKind::sphere:
      return Shape(Sphere{r.in(0.2, 0.8)});
    case ShapeKind::box:
      return Shape(Box{r.vec(0.3, 1.5)});
    case ShapeKind::capsule: {
      const double radius = r.in(0.1, 0.5);
      return Shape(Capsule{radius, r.in(0.1, 1.5)});
    }
    case ShapeKind::cylinder: {
      const double radius = r.in(0.2, 0.8);
      return Shape(Cylinder{radius, r.in(0.2, 1.5)});
    }
    case ShapeKind::cone: {
      const double radius = r.in(0.2, 0.8);
      return Shape(Cone{radius, r.in(0.2, 1.5)});
    }
    case ShapeKind::ellipsoid:
      return Shape(Ellipsoid{r.vec(0.2, 0.9)});
    case ShapeKind::halfspace: {
      const Vec3 n = r.direction();
      return Shape(HalfSpace{n, r.in(-0.5, 0.5)});
    }
    case ShapeKind::plane: {
      const Vec3 n = r.direction();
      return Shape(Plane{n, r.in(-0.5, 0.5)});
    }
    case ShapeKind::convex: {
      Convex c;
      const int n = 4 + static_cast<int>(r.in(0, 28));
      for (int i = 0; i < n; ++i) c.vertices.push_back(0.7 * r.direction());
      return Shape(c);
    }
    case ShapeKind::triangle: {
      const Vec3 p = r.vec(-0.8, 0.8), q = r.vec(-0.8, 0.8);
      return Shape(Triangle{{p, q, r.vec(-0.8, 0.8)}});
    }
    case ShapeKind::voxels: {
      Voxels v;
      v.cell_size = r.in(0.15, 0.3);
      v.origin = r.vec(-0.05, 0.05);
      v.cells.push_back({{0, 0, 0}, 0});
      for (int i = 0; i < 60; ++i) {
        const auto place = [&] { return static_cast<std::int32_t>(std::floor(r.in(-2.5, 2.5))); };
        v.cells.push_back({{place(), place(), place()}, 0});
      }
      v.cells.push_back({{-2, 0, 0}, 1});
      v.cells.push_back({{0, 2, 0}, 1});
      return Shape(v);
    }
    default: {
      Mesh m;
      m.vertices = {{-0.5, -0.5, -0.5}, {0.7, -0.4, -0.3}, {0, 0.6, -0.4}, {0, 0, 0.6}};
      m.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
      return Shape(std::move(m));
    }
  }
}

inline Pose random_pose(Random& r, double reach) {
  Pose p;
  p.rotation = r.rotation();
  p.translation = r.vec(-reach, reach);
  return p;
}

}  // namespace tandem::test
