// The certified signed distance of two convex shapes.
#include "reference.h"

#include <limits>
#include <stdexcept>

#include "minkowski.h"

namespace tandem::reference {
namespace {

constexpr std::size_t most_vertices = 700;

struct Plane {
  Vec normal;  ///< unit, world
  Real offset;
};

/// The half-space's plane in the real numbers: R^-T transforms its normal to the world.
Plane posed_plane(const Shape& shape, const Pose& pose, const Vec3& origin) {
  const Vec x(Vec3(pose.rotation.col(0))), y(Vec3(pose.rotation.col(1))), z(Vec3(pose.rotation.col(2)));
  const Vec yz = cross(y, z), n(shape.normal());
  const Real det = dot(x, yz);
  const Vec m = (n.x * yz + n.y * cross(z, x) + n.z * cross(x, y)) / det;
  const Real length = norm(m);
  return {m / length, (Real(shape.offset()) + dot(m, Vec(pose.translation) - Vec(origin))) / length};
}

/// The signed height of the shape above the plane.
Real above(const Plane& plane, const PosedCore& core) {
  return dot(plane.normal, core.support(-plane.normal)) - core.radius() - plane.offset;
}

/// One tangential Newton step of the depth over the directions, from its values at and around `n`; halved until it
/// improves. Returns the gain.
Real newton_step(const Difference& difference, Vec& n, Real& depth) {
  const auto depth_at = [&](const Vec& direction) {
    const Vec unit = direction / norm(direction);
    return dot(unit, difference.support(unit));
  };
  const Vec u = perpendicular(n);
  const Vec v = cross(n, u);
  const Real h = 1e-9;
  const Real pu = depth_at(n + h * u), mu = depth_at(n - h * u), pv = depth_at(n + h * v), mv = depth_at(n - h * v);
  const Real puv = depth_at(n + h * u + h * v), muv = depth_at(n - h * u - h * v);
  const Real gu = (pu - mu) / (2 * h), gv = (pv - mv) / (2 * h);
  const Real huu = (pu + mu - 2 * depth) / (h * h), hvv = (pv + mv - 2 * depth) / (h * h);
  const Real huv = (puv + muv - pu - mu - pv - mv + 2 * depth) / (2 * h * h);
  const Real det = huu * hvv - huv * huv;
  Vec step;
  if (det > 0 && huu > 0)
    step = ((huv * gv - hvv * gu) / det) * u + ((huv * gu - huu * gv) / det) * v;
  else if (gu * gu + gv * gv > 0)
    step = (Real(-0.1) / difference.scale()) * (gu * u + gv * v);
  for (int i = 0; i < 40; ++i) {
    Vec moved = n + step;
    moved = moved / norm(moved);
    const Real there = dot(moved, difference.support(moved));
    if (there < depth) {
      const Real gain = depth - there;
      n = moved, depth = there;
      return gain;
    }
    step = Real(0.25) * step;
  }
  return 0;
}

Interval cores_distance(const Difference& difference, Real tolerance) {
  Interval outside = outside_distance(difference, tolerance);
  if (outside.lower > 0) {
    // At a touching corner or edge, any normal of its normal cone comes as close.
    outside.unique = outside.lower > Real(1e-9) * difference.scale();
    return outside;
  }
  const auto axial = axial_bounds(difference, tolerance);
  if (axial) {
    Interval r = *axial;
    r.lower = -dot(r.normal, difference.support(r.normal));
    if (r.upper - r.lower < Real(1e-14) * difference.scale()) return r;
  }
  Interval inside = inside_distance(difference, tolerance, most_vertices);
  if (inside.upper > 0) inside.upper = max(inside.lower, outside.upper);  // the origin was not reached
  if (inside.upper - inside.lower > tolerance) {
    Real depth = -inside.lower;
    for (int i = 0; i < 30; ++i)
      if (!(newton_step(difference, inside.normal, depth) > tolerance)) break;
    inside.lower = max(inside.lower, -depth);
    if (axial) {
      inside.upper = min(inside.upper, axial->upper);
      const Real along = -dot(axial->normal, difference.support(axial->normal));
      if (along > inside.lower) inside.lower = along, inside.normal = axial->normal;
    }
  }
  if (outside.lower > inside.lower) inside.lower = outside.lower, inside.normal = outside.normal;
  return inside;
}

}  // namespace

double separation(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& direction) {
  Vec unit(direction);
  unit = unit / norm(unit);
  if (!a.is_bounded() || !b.is_bounded()) {
    const Truth t = signed_distance(a, pose_a, b, pose_b);
    return norm(unit - Vec(t.normal)) <= Real(2e-15) ? t.signed_distance : -std::numeric_limits<double>::infinity();
  }
  const Vec3& origin = pose_a.translation;
  const PosedCore core_a(a, pose_a, origin), core_b(b, pose_b, origin);
  const Difference difference{core_a, core_b};
  return static_cast<double>(-dot(unit, difference.support(unit)) - core_a.radius() - core_b.radius());
}

Truth signed_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  if (a.kind() == ShapeKind::plane || b.kind() == ShapeKind::plane) {
    // A plane is replaced by the one of its two half-spaces beyond which less of the other body reaches.
    const auto side = [](const Shape& s, double sense) -> Shape {
      return s.kind() == ShapeKind::plane ? HalfSpace{sense * s.normal(), sense * s.offset()} : s;
    };
    const Truth above = signed_distance(side(a, 1), pose_a, side(b, 1), pose_b),
                below = signed_distance(side(a, -1), pose_a, side(b, -1), pose_b);
    return below.signed_distance > above.signed_distance ? below : above;
  }
  if (!a.is_convex() || !b.is_convex() || (!a.is_bounded() && !b.is_bounded()))
    throw std::invalid_argument("reference: the shapes must be convex and one of them bounded");
  Interval d;
  Real radii = 0;
  if (!a.is_bounded() || !b.is_bounded()) {
    const bool first = !a.is_bounded();
    const Vec3& origin = (first ? pose_b : pose_a).translation;
    const Plane plane = first ? posed_plane(a, pose_a, origin) : posed_plane(b, pose_b, origin);
    d.lower = d.upper = above(plane, first ? PosedCore(b, pose_b, origin) : PosedCore(a, pose_a, origin));
    d.normal = first ? plane.normal : -plane.normal;
  } else {
    const Vec3& origin = pose_a.translation;
    const PosedCore core_a(a, pose_a, origin), core_b(b, pose_b, origin);
    const Difference difference{core_a, core_b};
    d = cores_distance(difference, Real(1e-20) * difference.scale());
    radii = core_a.radius() + core_b.radius();
  }
  Truth t;
  t.signed_distance = static_cast<double>(d.lower - radii);
  t.error = static_cast<double>(d.upper - d.lower + abs(d.lower - radii - Real(t.signed_distance)));
  t.normal = d.normal.rounded();
  t.normal_unique = d.unique;
  return t;
}

}  // namespace tandem::reference
