// The distance of a point from the surface of a convex shape, from outside and inside.
#include "closed_forms/surface_distance.h"

#include <algorithm>
#include <cmath>

#include "closed_forms/closed_forms.h"
#include "shapes/highest_faces.h"
#include "shapes/hull.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {
namespace {

Vec3 radii_of(const ConvexView& v) { return {v.param[0], v.param[1], v.param[2]}; }

}  // namespace

// The nearest point x of the ellipsoid has p - x = t a^-2 x, so x_i = a_i^2 p_i / (t + a_i^2); t is the one root above
// -min a_i^2 of a convex falling function, to which Newton's method climbs from where one term alone is 1 (Eberly,
// Distance from a point to an ellipse, an ellipsoid or a hyperellipsoid, 2013). `s` is t + min a_i^2, which is small
// where p lies near the plane of the two longer axes. On it and deep within there is no root: s is 0, and x has what is
// missing along the shortest axis, to either side.
Vec3 ellipsoid_normal(const Vec3& a, const Vec3& p) {
  constexpr int most_steps = 64;
  int shortest = 0;
  const double least = a.minCoeff(&shortest);
  const Vec3 ap = a.cwiseProduct(p), more = ((a.array() - least) * (a.array() + least)).matrix();
  const auto over = [&](const Vec3& v, double s) {  // the quotient, 0 for v = 0 even if the denominator is 0
    Vec3 out;
    for (int i = 0; i < 3; ++i) out[i] = v[i] == 0 ? 0 : v[i] / (s + more[i]);
    return out;
  };
  double s = std::max(0.0, (ap.cwiseAbs() - more).maxCoeff());
  for (int i = 0; i < most_steps; ++i) {
    const Vec3 ratio = over(ap, s);
    const double f = ratio.squaredNorm() - 1, slope = -2 * ratio.dot(over(ratio, s)), next = s - f / slope;
    if (!(f > 0 && next > s)) break;
    s = next;
  }
  Vec3 n = over(p, s);
  if (s == 0) n[shortest] = std::sqrt(std::max(0.0, 1 - over(ap, s).squaredNorm())) / least;
  return unit(n);
}

namespace {

SurfaceDistance from_ellipsoid(const Vec3& a, const Vec3& p, double slack) {
  const Vec3 n = ellipsoid_normal(a, p);
  const double distance = n.dot(p) - a.cwiseProduct(n).norm();
  return {distance < -slack && p.cwiseQuotient(a).squaredNorm() < 1, n, distance};
}

SurfaceDistance from_hull(const Hull& hull, const Vec3& p, double slack) {
  double most = -infinity;
  const Hull::Face* nearest = nullptr;
  const auto compare = [&](std::size_t i) {
    const Hull::Face& face = hull.faces[i];
    if (const double above = face.normal.dot(p) - face.offset; above > most) most = above, nearest = &face;
  };
  if (hull.face_table.faces > 0) {
    for_each_face(faces_over(hull, p), compare);
  } else {
    for (std::size_t i = 0; i < hull.faces.size(); ++i) compare(i);
  }
  return {most < -slack, nearest->normal, most};
}

double exit_of_box(const Vec3& half, const Vec3& p, const Vec3& d) {
  double length = infinity;
  for (int i = 0; i < 3; ++i)
    if (d[i] != 0) length = std::min(length, (half[i] - std::copysign(1.0, d[i]) * p[i]) / std::abs(d[i]));
  return length;
}

/// The larger root of a s^2 + 2 b s + c = 0, a > 0 and c <= 0, with b^2 - a c = det; none where a is 0.
double last_root(double a, double b, double c, double det) {
  if (!(a > 0)) return infinity;
  const double root = std::sqrt(std::max(0.0, det));
  return b > 0 ? -c / (b + root) : (root - b) / a;
}

double exit_of_disc(double radius, const Vec3& p, const Vec3& d) {
  const double a = d[0] * d[0] + d[1] * d[1], b = p[0] * d[0] + p[1] * d[1];
  const double c = p[0] * p[0] + p[1] * p[1] - radius * radius;
  return last_root(a, b, c, b * b - a * c);
}

double exit_of_cylinder(double radius, double half, const Vec3& p, const Vec3& d) {
  double length = exit_of_disc(radius, p, d);
  if (d[2] != 0) length = std::min(length, (half - std::copysign(1.0, d[2]) * p[2]) / std::abs(d[2]));
  return length;
}

// For the double cone about the apex: from inside the lower half, the line leaves at the first root ahead, where it
// meets this half, or the base, before the upper half.
double exit_of_cone(double radius, double length, const Vec3& p, const Vec3& d) {
  const double h = 0.5 * length, slope = radius / length, down = h - p[2], fall = -d[2];
  double out = d[2] < 0 ? (h + p[2]) / -d[2] : infinity;
  const double a = d[0] * d[0] + d[1] * d[1] - slope * slope * fall * fall;
  const double b = p[0] * d[0] + p[1] * d[1] - slope * slope * down * fall;
  const double c = std::min(0.0, p[0] * p[0] + p[1] * p[1] - slope * slope * down * down);
  // b^2 - a c by Lagrange's identity: near the apex both products are large and nearly equal.
  const Vec3 cross = Vec3(p[0], p[1], down).cross(Vec3(d[0], d[1], fall));
  const double det = slope * slope * (cross[0] * cross[0] + cross[1] * cross[1]) - cross[2] * cross[2];
  if (a > 0) {
    out = std::min(out, last_root(a, b, c, det));
  } else if (a < 0) {
    // Steeper than the lateral surface: both roots have the same sign; for upward lines they are ahead, with the apex
    // before the second.
    if (fall < 0) out = std::min(out, c / (-b - std::sqrt(std::max(0.0, det))));
  } else if (b > 0) {
    out = std::min(out, -c / (2 * b));
  }
  return std::max(0.0, out);
}

/// A line from a point of a capsule leaves it through the side, or through the ball at that end beyond which it leaves
/// the cylinder.
double exit_of_capsule(double radius, double half, const Vec3& p, const Vec3& d) {
  const double side = exit_of_disc(radius, p, d), z = p[2] + side * d[2];
  if (std::abs(z) <= half) return side;
  const Vec3 q = p - Vec3(0, 0, std::copysign(half, z));
  const double along = q.dot(d), across2 = (q - along * d).squaredNorm();
  return std::max(0.0, std::sqrt(std::max(0.0, radius * radius - across2)) - along);
}

double exit_of_hull(const Hull& hull, const Vec3& p, const Vec3& d) {
  double length = infinity;
  for (const Hull::Face& face : hull.faces)
    if (const double speed = face.normal.dot(d); speed > 0)
      length = std::min(length, (face.offset - face.normal.dot(p)) / speed);
  return length;
}

}  // namespace

std::optional<SurfaceDistance> surface_distance(const ConvexView& shape, const Vec3& p, double slack) {
  switch (shape.kind) {
    case ShapeKind::box:
    case ShapeKind::capsule:
    case ShapeKind::cylinder:
    case ShapeKind::cone: {
      const PointDistance d = point_distance(shape, p);
      return SurfaceDistance{d.signed_distance < -slack, d.normal, d.signed_distance};
    }
    case ShapeKind::ellipsoid:
      return from_ellipsoid(radii_of(shape), p, slack);
    case ShapeKind::sphere:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::convex:
    case ShapeKind::triangle:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  if (shape.hull == nullptr || shape.hull->dimension != 3 || shape.hull->faces.size() > most_faces_in_turn) return {};
  return from_hull(*shape.hull, p, slack);
}

double exit_length(const ConvexView& shape, const Vec3& p, const Vec3& d) {
  switch (shape.kind) {
    case ShapeKind::box:
      return exit_of_box(radii_of(shape), p, d);
    case ShapeKind::sphere:
      return exit_of_capsule(shape.param[0], 0, p, d);
    case ShapeKind::capsule:
      return exit_of_capsule(shape.param[0], 0.5 * shape.param[1], p, d);
    case ShapeKind::cylinder:
      return exit_of_cylinder(shape.param[0], 0.5 * shape.param[1], p, d);
    case ShapeKind::cone:
      return exit_of_cone(shape.param[0], shape.param[1], p, d);
    case ShapeKind::ellipsoid: {
      const Vec3 a = radii_of(shape), q = p.cwiseQuotient(a), e = d.cwiseQuotient(a);
      const double ee = e.squaredNorm(), qe = q.dot(e), c = std::min(0.0, q.squaredNorm() - 1);
      return std::max(0.0, last_root(ee, qe, c, qe * qe - ee * c));
    }
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::convex:
    case ShapeKind::triangle:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  if (shape.hull == nullptr || shape.hull->dimension != 3) return 0;  // it has no interior
  return exit_of_hull(*shape.hull, p, d);
}

}  // namespace tandem
