// Pairs of a sliver and a shape set on its face.
#include "slivers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::relations {
namespace {

constexpr double narrowest = 12;  // decimal exponent of a sliver's height, of its length
constexpr double smallest = 8;    // the same of B's size

/// A triangle with its unit normal.
struct Sliver {
  std::array<Vec3, 3> corners;
  Vec3 normal;

  explicit Sliver(Random& r) {
    const Mat3 axes = r.rotation();
    const Vec3 from = r.vec(-0.3, 0.3), along = axes.col(0), across = axes.col(1);
    const double over = r.unit();
    corners = {from, from + along, from + over * along + small(r, narrowest) * across};
    normal = axes.col(2);
    if (r.once_in(2)) std::swap(corners[0], corners[1]);
    if (r.once_in(2)) std::swap(corners[1], corners[2]);
  }

  /// Near a corner or side in half of the cases.
  Vec3 point(Random& r) const {
    double weight[3];
    for (double& w : weight) w = r.in(1e-3, 1);
    if (r.once_in(2)) {
      const double less = small(r, 16);
      weight[r.below(3)] *= less;
    }
    const double sum = weight[0] + weight[1] + weight[2];
    return (weight[0] / sum) * corners[0] + (weight[1] / sum) * corners[1] + (weight[2] / sum) * corners[2];
  }
};

ShapeData shape_of(const Sliver& s, Random& r) {
  const std::vector<Vec3> corners(s.corners.begin(), s.corners.end());
  switch (r.below(4)) {
    case 0:
      return Triangle{s.corners};
    case 1:
      return Convex{corners};
    case 2: {
      Convex blade{corners};
      blade.vertices.push_back(corners[0] - small(r, narrowest) * s.normal);
      return blade;
    }
    default:
      return Mesh{corners, {{0, 1, 2}}};
  }
}

/// A rotation that turns z to `up`, random about it.
Mat3 rotation_about(const Vec3& up, Random& r) {
  Mat3 turn;
  turn.col(2) = up;
  turn.col(0) = up.cross(r.direction()).normalized();
  turn.col(1) = up.cross(turn.col(0));
  return turn;
}

/// Random; in one of three cases z is nearly the sliver's normal, or in its plane.
Mat3 rotation_on(const Sliver& s, Random& r) {
  if (!r.once_in(3)) return r.rotation();
  const Vec3 beside = s.normal.cross(r.direction()).normalized(), off = r.direction();
  const Vec3 exact = r.once_in(2) ? s.normal : beside;
  return rotation_about((exact + small(r, 2, 12) * off).normalized(), r);
}

/// The signed distance of B from the sliver.
double gap(double size, Random& r) {
  if (r.once_in(5)) return 0;
  const double length = r.once_in(2) ? small(r, 11, 18) : small(r, 1, 18);
  return r.once_in(4) ? length : -std::min(length, size);
}

/// The point of a shape lowest along n.
Vec3 lowest(const PosedShape& s, const Vec3& n) {
  const Shape floor(HalfSpace{n, 0});
  return NarrowPhase().solve(floor, {}, make_shape(s), s.pose, Request::distance).point_b;
}

void change(PosedPair& p, Random& r) {
  const Sliver sliver(r);
  p.a = {shape_of(sliver, r), Pose{}};
  if (p.b.kind() == ShapeKind::halfspace || p.b.kind() == ShapeKind::plane) return;
  const double size = small(r, smallest), drawn = reach(p.b);
  if (drawn > 0) scale(p.b.shape, size / drawn);
  p.b.rounding = 0;
  p.b.pose = {rotation_on(sliver, r), Vec3::Zero()};
  const double off = gap(size, r);
  const Vec3 to = sliver.point(r) + off * sliver.normal;
  p.b.pose.translation = to - lowest(p.b, sliver.normal);
}

}  // namespace

void set_on_sliver(PosedPair& pair, Random& r) {
  change_if_allowed(pair, [&](PosedPair& changed) { change(changed, r); });
}

}  // namespace tandem::relations
