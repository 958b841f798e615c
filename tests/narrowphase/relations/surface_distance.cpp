// Distances of points to shapes' surfaces, by formulas that share nothing with the solvers.
#include "surface_distance.h"

#include <algorithm>
#include <cmath>

#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::relations {
namespace {

using Vec2 = Eigen::Vector2d;

/// The signed distance from a box about the origin, negative inside.
template <class V>
double box(const V& p, const V& half) {
  const V q = p.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}

double segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const double part = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - part * (b - a)).norm();
}

double asked(const Shape& bare, const Vec3& p) {
  return NarrowPhase().solve(bare, {}, Shape(Sphere{0}), {Mat3::Identity(), p}, Request::distance).signed_distance;
}

// Without rounding and without the inside of a solid mesh; hulls and hierarchies need not be built again.
double asked(const PosedShape& posed, const Shape& made, const Vec3& p) {
  const Mesh* mesh = std::get_if<Mesh>(&posed.shape);
  const bool is_solid = mesh != nullptr && mesh->solid;
  if (posed.rounding == 0 && !is_solid) return asked(made, p);
  ShapeData bare = posed.shape;
  if (is_solid) std::get<Mesh>(bare).solid = false;
  return asked(make_shape(bare), p);
}

}  // namespace

double surface_distance(const PosedShape& shape, const Shape& made, const Vec3& world) {
  const Vec3 p = shape.pose.rotation.transpose() * (world - shape.pose.translation);
  const double ring = std::hypot(p.x(), p.y());
  struct Distance {
    const PosedShape& shape;
    const Shape& made;
    const Vec3& p;
    double ring;
    double operator()(const Sphere& s) const { return p.norm() - s.radius; }
    double operator()(const Box& s) const { return box<Vec3>(p, s.size / 2); }
    double operator()(const Capsule& s) const {
      return std::hypot(ring, std::max(std::abs(p.z()) - s.length / 2, 0.0)) - s.radius;
    }
    double operator()(const Cylinder& s) const { return box<Vec2>({ring, p.z()}, {s.radius, s.length / 2}); }
    double operator()(const Cone& s) const {
      const Vec2 q(ring, p.z()), rim(s.radius, -s.length / 2), apex(0, s.length / 2);
      return std::min(segment(q, rim, apex), segment(q, Vec2(0, -s.length / 2), rim));
    }
    double operator()(const Ellipsoid& s) const {
      if (shape.rounding > 0) return asked(shape, made, p);  // the formulas below hold near its surface
      const Vec3 q = p.cwiseQuotient(s.radii);
      const double k = q.norm(), gradient = q.cwiseQuotient(s.radii).norm();
      double far = gradient > 0 ? std::abs(k * (k - 1) / gradient) : s.radii.minCoeff();
      // Inside a flat ellipsoid the first order is useless: the distance along an axis is an upper bound.
      for (int i = 0; i < 3 && k < 1; ++i)
        far = std::min(far, s.radii[i] * std::sqrt(1 - (k * k - q[i] * q[i])) - std::abs(p[i]));
      return far;
    }
    double operator()(const HalfSpace& s) const { return (s.normal.dot(p) - s.offset) / s.normal.norm(); }
    double operator()(const Plane& s) const { return std::abs(s.normal.dot(p) - s.offset) / s.normal.norm(); }
    double operator()(const Convex&) const { return asked(shape, made, p); }
    double operator()(const Triangle&) const { return asked(shape, made, p); }
    // A point that touches a surface lies on it, whatever its depth.
    double operator()(const Mesh&) const { return std::max(0.0, asked(shape, made, p)); }
    double operator()(const Voxels&) const { return std::max(0.0, asked(shape, made, p)); }
  };
  return std::abs(std::visit(Distance{shape, made, p, ring}, shape.shape) - shape.rounding);
}

}  // namespace tandem::relations
