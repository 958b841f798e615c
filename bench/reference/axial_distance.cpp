// Bounds of the depth of two round shapes that nearly share an axis.
#include <array>
#include <functional>
#include <optional>
#include <queue>
#include <utility>

#include "minkowski.h"

namespace tandem::reference {
namespace {

struct AxialShape {
  Shape shape;  ///< about its own z axis
  int axis;     ///< which of the posed shape's axes that is; -1: any
};

std::optional<AxialShape> axial(const Shape& s) {
  if (s.kind() == ShapeKind::sphere) return AxialShape{s, -1};
  if (s.kind() == ShapeKind::capsule || s.kind() == ShapeKind::cylinder || s.kind() == ShapeKind::cone)
    return AxialShape{s, 2};
  if (s.kind() != ShapeKind::ellipsoid) return std::nullopt;
  const Vec3 r = s.radii();
  for (const int k : {2, 1, 0})
    if (const double across = r[(k + 1) % 3]; across == r[(k + 2) % 3])
      return AxialShape{Shape(Ellipsoid{{across, across, r[k]}}), k};
  return std::nullopt;
}

/// A bound on how far a point of the posed shape lies from the same point rotated onto `axis`, by a rotation without
/// rounding.
Real misfit(const PosedCore& core, int axis, const Vec& to) {
  Real off = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) off = max(off, abs(dot(core.axis(i), core.axis(j)) - (i == j ? 1 : 0)));
  const Real tilt = axis < 0 ? Real(0) : norm(core.axis(axis) - to);
  return Real(core.shape().size()) * (tilt + 4 * off);
}

/// The depth of the origin in the plane figure that the supports in the x-z plane span, by an inner polygon.
Interval plane_depth(const Difference& difference, Real tolerance) {
  struct Edge {
    Real offset;
    Vec from, to, normal;
    bool operator>(const Edge& o) const { return offset > o.offset; }
  };
  constexpr int most_edges = 20000;
  std::priority_queue<Edge, std::vector<Edge>, std::greater<>> queue;
  const auto add = [&](const Vec& from, const Vec& to) {
    const Vec n{to.z - from.z, 0, from.x - to.x};  // to the right of from -> to: outside of a counterclockwise loop
    const Real length = norm(n);
    if (length > 0) queue.push({dot(n / length, from), from, to, n / length});
  };
  const Vec first[4] = {difference.support({1, 0, 0}), difference.support({0, 0, 1}), difference.support({-1, 0, 0}),
                        difference.support({0, 0, -1})};
  for (std::size_t i = 0; i < 4; ++i) add(first[i], first[(i + 1) % 4]);
  Interval r;
  r.lower = -2 * difference.scale();
  for (int i = 0; i < most_edges && !queue.empty(); ++i) {
    const Edge e = queue.top();
    const Vec w = difference.support(e.normal);
    const Real depth = dot(e.normal, w);
    if (-depth > r.lower) r.lower = -depth, r.normal = e.normal;
    r.upper = -e.offset;
    if (!(r.upper - r.lower > tolerance)) break;
    queue.pop();
    add(e.from, w);
    add(w, e.to);
  }
  const Real close = -r.lower + Real(1e-9) * difference.scale();
  r.unique = abs(r.normal.x) < Real(1e-3);  // else every rotation of it is as good
  for (; !queue.empty() && queue.top().offset <= close; queue.pop())
    if (norm(queue.top().normal - r.normal) > Real(1e-3)) r.unique = false;
  return r;
}

}  // namespace

std::optional<Interval> axial_bounds(const Difference& difference, Real tolerance) {
  const auto a = axial(difference.a.shape()), b = axial(difference.b.shape());
  if (!a || !b) return std::nullopt;
  const PosedCore& leading = a->axis >= 0 || b->axis < 0 ? difference.a : difference.b;
  const int leading_axis = a->axis >= 0 ? a->axis : b->axis;
  const Vec between = difference.b.translation() - difference.a.translation();
  Vec e = leading_axis >= 0 ? leading.axis(leading_axis) : between;
  if (!(norm(e) > 0)) e = {0, 0, 1};
  e = e / norm(e);
  const auto flipped = [&](const PosedCore& core, int axis) { return axis >= 0 && dot(core.axis(axis), e) < 0; };
  const bool flip_a = flipped(difference.a, a->axis), flip_b = flipped(difference.b, b->axis);
  const double along = static_cast<double>(dot(e, between));
  const Real misplaced = misfit(difference.a, a->axis, flip_a ? -e : e) +
                         misfit(difference.b, b->axis, flip_b ? -e : e) + norm(between - Real(along) * e);
  if (misplaced > Real(1e-3) * difference.scale()) return std::nullopt;

  const Mat3 over = Vec3(1, -1, -1).asDiagonal();
  const PosedCore core_a(a->shape, {flip_a ? over : Mat3::Identity(), Vec3::Zero()}, Vec3::Zero());
  const PosedCore core_b(b->shape, {flip_b ? over : Mat3::Identity(), Vec3(0, 0, along)}, Vec3::Zero());
  Interval r = plane_depth({core_a, core_b}, tolerance);
  r.lower = r.lower - misplaced;
  r.upper = r.upper + misplaced;
  r.normal = r.normal.x * perpendicular(e) + r.normal.z * e;
  return r;
}

}  // namespace tandem::reference
