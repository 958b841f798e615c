// Distances of points to simple shapes, and of two segments, by formulas.
#include "closed_forms/closed_forms.h"

#include <algorithm>
#include <iterator>

#include "tolerances.h"

namespace tandem {
namespace {

PointDistance to_ball(const Vec3& centre, const Vec3& p, double radius) {
  const Vec3 d = p - centre;
  const double length = d.norm();
  const Vec3 n = length > 0 ? unit(d, length) : Vec3::UnitX();
  return {length - radius, centre + radius * n, n};
}

PointDistance to_box(const Vec3& half, const Vec3& p) {
  const Vec3 clamped = p.cwiseMax(-half).cwiseMin(half);
  const Vec3 d = p - clamped;
  const double length = d.norm();
  if (length > 0) return {length, clamped, unit(d, length)};
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (half[i] - std::abs(p[i]) < half[axis] - std::abs(p[axis])) axis = i;
  PointDistance r{std::abs(p[axis]) - half[axis], p, Vec3::Zero()};
  r.normal[axis] = std::copysign(1.0, p[axis]);
  r.nearest[axis] = r.normal[axis] * half[axis];
  return r;
}

/// The distance in the half profile of a solid of revolution about z: x is the distance from the axis.
struct Profile {
  double signed_distance, x, z, nx, nz;
};

PointDistance revolve(const Vec3& p, double rho, const Profile& f) {
  const Vec3 out = rho > 0 ? unit(Vec3(p[0], p[1], 0), rho) : Vec3::UnitX();
  const double cx = out[0], cy = out[1];
  return {f.signed_distance, {f.x * cx, f.x * cy, f.z}, {f.nx * cx, f.nx * cy, f.nz}};
}

PointDistance to_cylinder(double radius, double half, const Vec3& p) {
  const double rho = std::sqrt(p[0] * p[0] + p[1] * p[1]);
  const double out = rho - radius, up = std::abs(p[2]) - half, side = std::copysign(1.0, p[2]);
  if (out <= 0 && up <= 0) {
    if (up >= out) return revolve(p, rho, {up, rho, side * half, 0, side});
    return revolve(p, rho, {out, radius, p[2], 1, 0});
  }
  if (out <= 0) return revolve(p, rho, {up, rho, side * half, 0, side});
  if (up <= 0) return revolve(p, rho, {out, radius, p[2], 1, 0});
  const double d = std::sqrt(out * out + up * up);
  return revolve(p, rho, {d, radius, side * half, out / d, side * up / d});
}

PointDistance to_cone(double radius, double length, const Vec3& p) {
  const double rho = std::sqrt(p[0] * p[0] + p[1] * p[1]), h = 0.5 * length;
  const double slant = std::sqrt(radius * radius + length * length);
  const double nx = length / slant, nz = radius / slant;  // outward normal of the lateral surface
  const double below = -h - p[2];
  const double off = nx * rho + nz * (p[2] - h);  // height above the lateral surface
  if (below <= 0 && off <= 0) {
    if (below >= off) return revolve(p, rho, {below, rho, -h, 0, -1});
    return revolve(p, rho, {off, rho - off * nx, p[2] - off * nz, nx, nz});
  }
  // Outside: the base, its circle, the lateral surface or the apex is nearest.
  if (below >= 0 && rho <= radius) return revolve(p, rho, {below, rho, -h, 0, -1});
  const double t = nz * rho - nx * (p[2] - h);  // distance down the lateral surface from the apex, in [0, slant] on it
  // Beside the base and not above it the circle is nearest, wherever rounding puts t; off may be below 0 there.
  const bool at_circle = below >= 0 || t >= slant;
  if (at_circle || t <= 0) {
    const double x = at_circle ? radius : 0, z = at_circle ? -h : h;
    const double dx = rho - x, dz = p[2] - z, d = std::sqrt(dx * dx + dz * dz);
    // The direction to an edge lies between the normals of its two faces, whatever the rounding of so small a
    // difference.
    if (!(d > 0) || (nz * dx < nx * dz) == at_circle) return revolve(p, rho, {d, x, z, nx, nz});
    if (dx < 0) return revolve(p, rho, {d, x, z, 0, -1});
    return revolve(p, rho, {d, x, z, dx / d, dz / d});
  }
  return revolve(p, rho, {off, rho - off * nx, p[2] - off * nz, nx, nz});
}

/// The vector to p from the nearest point of the segment: perpendicular to it, or from an end.
struct PointToSegment {
  Vec3 from, d;
};
PointToSegment point_to_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 ab = b - a;
  // From both ends: a small distance from the nearer one would be lost in the length.
  const double from_a = (p - a).dot(ab), from_b = (b - p).dot(ab), length2 = ab.squaredNorm();
  if (!(from_a > 0)) return {a, p - a};
  if (!(from_b > 0)) return {b, p - b};
  const bool first = from_a <= from_b;
  const Vec3& end = first ? a : b;
  const Vec3 along = (first ? from_a : -from_b) / length2 * ab;
  // From that end, not from the point on the segment, which is rounded where coordinates are large relative to d.
  Vec3 d = (p - end) - along;
  // Removes what rounding left along the segment; for a point on it that was nearly all of d, and the removal inexact.
  for (int i = 0; i < 2; ++i) d -= (d.dot(ab) / length2) * ab;
  return {end + along, d};
}

/// The vector to p from the nearest point of a triangle's sides. Near a corner a side and the corner are equally near,
/// to rounding, while their directions differ by up to the square root of epsilon: the direction that separates p from
/// the whole triangle farthest is right.
PointToSegment nearest_edge(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const PointToSegment sides[3] = {point_to_segment(a, b, p), point_to_segment(b, c, p), point_to_segment(c, a, p)};
  const double distances[3] = {sides[0].d.norm(), sides[1].d.norm(), sides[2].d.norm()};
  // How far all corners lie behind the plane through p across the direction.
  const auto separation = [&](std::size_t k) {
    const Vec3& d = sides[k].d;
    return distances[k] > 0 ? std::min({d.dot(p - a), d.dot(p - b), d.dot(p - c)}) / distances[k] : 0.0;
  };
  const auto* const least = std::min_element(std::begin(distances), std::end(distances));
  const double reach = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  const double as_near = *least + tolerance::tie * *least + epsilon * reach;
  auto best = static_cast<std::size_t>(least - distances);
  for (std::size_t k = 0; k < 3; ++k)
    if (k != best && distances[k] <= as_near && separation(k) > separation(best)) best = k;
  return sides[best];
}

PointDistance to_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 pa = a - p, pb = b - p, pc = c - p;
  const Vec3 ab = b - a, ac = c - a, bc = c - b;
  const double ab2 = ab.squaredNorm(), ac2 = ac.squaredNorm(), bc2 = bc.squaredNorm();
  const double longest = std::max({ab2, ac2, bc2});
  const Vec3& side = longest == bc2 ? bc : longest == ac2 ? ac : ab;
  Vec3 n = longest == bc2 ? Vec3(ab.cross(ac)) : longest == ac2 ? Vec3(ab.cross(bc)) : Vec3(ac.cross(bc));
  // The normal of a sliver is off by rounding over its height; along the longest side, where corners are far apart,
  // that would show in heights above the plane, so it is made perpendicular to that side.
  if (longest > 0) n -= (n.dot(side) / longest) * side;
  const double length = n.norm();
  const bool area = length > tolerance::no_area * longest;
  PointDistance above{};
  if (area) {
    const Vec3 unit = n / length;
    // Relative to the nearest corner, so that a small height keeps its digits.
    const double a2 = pa.squaredNorm(), b2 = pb.squaredNorm(), c2 = pc.squaredNorm();
    const double height = -unit.dot(a2 <= b2 ? (a2 <= c2 ? pa : pc) : (b2 <= c2 ? pb : pc));
    above = {std::abs(height), p - height * unit, height >= 0 ? unit : Vec3(-unit)};
    // By the edges, since from far away the distances to two corners are the same number.
    if (n.dot(pa.cross(ab)) >= 0 && n.dot(pb.cross(bc)) >= 0 && n.dot(ac.cross(pc)) >= 0) return above;
  }
  const PointToSegment nearest = nearest_edge(a, b, c, p);
  const double distance = nearest.d.norm();
  const Vec3 normal = distance > 0  ? unit(nearest.d, distance)
                      : length > 0  ? unit(n, length)
                      : longest > 0 ? any_perpendicular(side)
                                    : Vec3::UnitX();
  PointDistance best{distance, nearest.from, normal};
  // Within rounding of the circle the direction between points that nearly touch is noise, while the plane's normal is
  // not.
  if (area && (best.nearest - above.nearest).squaredNorm() <= tolerance::lost2 * longest) {
    best.signed_distance = above.signed_distance;
    best.normal = above.normal;
  }
  return best;
}

}  // namespace

PointDistance point_distance(const ConvexView& s, const Vec3& p) {
  switch (s.kind) {
    case ShapeKind::box:
      return to_box({s.param[0], s.param[1], s.param[2]}, p);
    case ShapeKind::capsule: {
      const double h = 0.5 * s.param[1];
      const Vec3 on_axis{0, 0, std::clamp(p[2], -h, h)};
      return to_ball(on_axis, p, s.param[0]);
    }
    case ShapeKind::cylinder:
      return to_cylinder(s.param[0], 0.5 * s.param[1], p);
    case ShapeKind::cone:
      return to_cone(s.param[0], s.param[1], p);
    case ShapeKind::halfspace: {
      const Vec3 n{s.param[0], s.param[1], s.param[2]};
      const double above = n.dot(p) - s.param[3];
      return {above, p - above * n, n};
    }
    case ShapeKind::triangle: {
      // A triangle without area may have fewer vertices in its hull.
      const std::size_t last = s.vertices.size() - 1;
      return to_triangle(s.vertices[0], s.vertices[std::min<std::size_t>(1, last)],
                         s.vertices[std::min<std::size_t>(2, last)], p);
    }
    case ShapeKind::sphere:
    case ShapeKind::ellipsoid:
    case ShapeKind::convex:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
    case ShapeKind::plane:
      break;  // a sphere; other kinds have no closed form and are not passed
  }
  return to_ball(Vec3::Zero(), p, s.param[0]);
}

namespace {

/// Two segments, r + s u and t v with s and t in [-1, 1], relative to the centre of the second.
class SegmentPair {
 public:
  SegmentPair(const Vec3& r, const Vec3& u, const Vec3& v) : r_(r), u_(u), v_(v) {}

  /// Finds the parameters s and t of the nearest points.
  void find_nearest();
  /// The vector from the point at s to the one at t; despite rounding perpendicular to a segment inside it, and not
  /// leaning to its inside at an end.
  Vec3 gap() const;
  /// The distance and the unit normal from the first to the second; `gap` as above.
  void measure(const Vec3& gap, SegmentDistance& d) const;

  double s = 0, t = 0;

 private:
  double best_s(double at) const { return std::clamp((at * uv_ - ru_) * by_uu_, -1.0, 1.0); }
  double best_t(double at) const { return std::clamp((at * uv_ + rv_) * by_vv_, -1.0, 1.0); }
  void try_sides();
  bool take_middle();
  double leaning(double at_s, double at_t) const;
  /// Of a difference of points of both, metres.
  double rounding() const { return 4 * epsilon * std::sqrt(r_.squaredNorm() + uu_ + vv_); }
  bool above_rounding(double distance) const;
  Vec3 across() const;

  const Vec3 &r_, &u_, &v_;
  const double uu_ = u_.squaredNorm(), vv_ = v_.squaredNorm(), uv_ = u_.dot(v_);
  const double ru_ = r_.dot(u_), rv_ = r_.dot(v_);
  const double by_uu_ = uu_ > 0 ? 1 / uu_ : 0.0, by_vv_ = vv_ > 0 ? 1 / vv_ : 0.0;
  const Vec3 cross_ = u_.cross(v_);
  const double det_ = cross_.squaredNorm();  // uu vv - uv^2 without cancellation
  const bool crossing_ = (det_ > (tolerance::parallel_lines2 * uu_ * vv_)) && (det_ > 0);
  bool interior_ = false;  // both parameters are those of the lines' common perpendicular
};

void SegmentPair::find_nearest() {
  if (crossing_) {
    // Both parameters from cross products: exact to rounding even for nearly parallel segments.
    const Vec3 x = v_.cross(cross_), y = u_.cross(cross_);
    s = -r_.dot(x) / u_.dot(x);
    t = r_.dot(y) / v_.dot(y);
    interior_ = std::abs(s) <= 1 && std::abs(t) <= 1;
    // For nearly parallel segments the rounding error of either parameter is long; it affects the gap only if the other
    // parameter does not match. One that matches beyond an end by more than rounding is no parameter of the
    // perpendicular.
    if (interior_) {
      const double match = (s * uv_ + rv_) * by_vv_;
      t = std::clamp(match, -1.0, 1.0);
      interior_ = match == t || std::abs(match - t) * std::sqrt(vv_) <= rounding();
    }
  }
  if (!interior_ && !take_middle()) try_sides();
}

/// The minimum lies on the boundary of the parameter square: the best of its four sides. Of those equal to rounding the
/// one whose ends are nearest because their segments end there, by the derivatives, which have more digits.
void SegmentPair::try_sides() {
  const double same = rounding();
  double least = infinity;
  for (int side = 0; side < 4; ++side) {
    const double end = side % 2 == 0 ? 1.0 : -1.0;
    const double cs = side < 2 ? end : best_s(end), ct = side < 2 ? best_t(end) : end;
    const double length = (r_ + cs * u_ - ct * v_).norm();
    if (length < least - same || (length <= least + same && leaning(cs, ct) < leaning(s, t)))
      least = length, s = cs, t = ct;
  }
}

/// How far the gap reaches back along the segments from those ends of theirs, metres: 0 if the ends are nearest.
double SegmentPair::leaning(double at_s, double at_t) const {
  const bool end_of_u = std::abs(at_s) == 1, end_of_v = std::abs(at_t) == 1;
  Vec3 gap = r_ + at_s * u_ - at_t * v_;
  // Along a segment inside it there is rounding alone.
  if (!end_of_v) gap -= (gap.dot(v_) * by_vv_) * v_;
  if (!end_of_u) gap -= (gap.dot(u_) * by_uu_) * u_;
  const double of_u = end_of_u ? at_s * gap.dot(u_) * std::sqrt(by_uu_) : 0.0,
               of_v = end_of_v ? -at_t * gap.dot(v_) * std::sqrt(by_vv_) : 0.0;
  return std::max({of_u, of_v, 0.0});
}

/// For parallel segments, takes the middle of the interval where they run side by side, if there is one.
bool SegmentPair::take_middle() {
  if (crossing_ || !(uu_ > 0 && vv_ > 0)) return false;
  const double length = std::sqrt(uu_), reach = std::sqrt(vv_), offset = -ru_ / length;
  const double lo = std::max(-length, offset - reach), hi = std::min(length, offset + reach);
  if (!(lo < hi)) return false;
  s = 0.5 * (lo + hi) / length;
  t = best_t(s);
  return true;
}

Vec3 SegmentPair::gap() const {
  Vec3 gap = t * v_ - s * u_ - r_;
  const auto make_perpendicular_to_u = [&] {
    const double along = gap.dot(u_);
    if (std::abs(s) < 1 || along * s < 0) gap -= (along * by_uu_) * u_;
  };
  // Of parallel ones the longer last: they are so but for rounding, and over its length an error has the most effect.
  const bool u_last = uu_ > vv_;
  if (!u_last) make_perpendicular_to_u();
  const double along = gap.dot(v_);
  if (std::abs(t) < 1 || along * t > 0) gap -= (along * by_vv_) * v_;
  if (u_last) make_perpendicular_to_u();
  return gap;
}

/// True if a distance is larger than the rounding error of a difference.
bool SegmentPair::above_rounding(double distance) const {
  return distance * distance > tolerance::lost_of_three2 * (r_.squaredNorm() + uu_ + vv_);
}

/// The unit normal of both segments. For nearly parallel ones the cross product is short and inexact: it is made
/// perpendicular to the longer one, where an error would have the most effect.
Vec3 SegmentPair::across() const {
  const Vec3 &longer = uu_ >= vv_ ? u_ : v_, n = cross_ / std::sqrt(det_);
  return (n - (n.dot(longer) / std::max(uu_, vv_)) * longer).normalized();
}

void SegmentPair::measure(const Vec3& gap, SegmentDistance& d) const {
  d.distance = gap.norm();
  if (interior_) {
    // Both points are interior: the common perpendicular, defined also where the segments cross.
    const Vec3 n = across();
    const double along = n.dot(-r_);
    d.distance = std::abs(along);
    d.normal = along >= 0 ? n : Vec3(-n);
  } else if (above_rounding(d.distance)) {
    d.normal = unit(gap, d.distance);
  } else if (crossing_) {
    // The segments intersect: the normal of their common plane is right, while the direction of the gap is noise.
    d.normal = across();
    if (d.normal.dot(r_) > 0) d.normal = -d.normal;
  } else {
    d.normal = uu_ > 0 ? any_perpendicular(u_) : vv_ > 0 ? any_perpendicular(v_) : Vec3::UnitX();
  }
}

}  // namespace

SegmentDistance segment_distance(const Vec3& centre_a, const Vec3& half_a, const Vec3& centre_b, const Vec3& half_b) {
  const Vec3 r = centre_a - centre_b;
  SegmentPair pair(r, half_a, half_b);
  pair.find_nearest();
  SegmentDistance d;
  d.point_a = centre_a + pair.s * half_a;
  d.point_b = centre_b + pair.t * half_b;
  pair.measure(pair.gap(), d);
  return d;
}

}  // namespace tandem
