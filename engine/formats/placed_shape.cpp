// Queries of shapes whose pose is a rotation only approximately, as in records with few digits.
#include "formats/placed_shape.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "round/support_descent.h"
#include "scene/tolerances.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// The smallest rotation that takes z to a nearby unit axis.
Mat3 turn_from_z(const Vec3& axis) {
  const double s = std::sqrt(2 * (1 + axis[2]));
  return Quat(0.5 * s, -axis[1] / s, axis[0] / s, 0).toRotationMatrix();
}

/// The hull of points of a cylinder or cone with a remaining deformation, inside the shape.
class InnerHull {
 public:
  explicit InnerHull(const PlacedShape& placed) : of_(placed) {
    constexpr int around = 24;
    constexpr double turn = 2 * 3.14159265358979323846 / around;
    if (is_cone()) points_.push_back(rest() * Vec3(0, 0, half()));
    for (int i = 0; i < around; ++i) add_sides(i * turn);
  }

  Shape shape() const { return Shape(Convex{points_}); }

  /// The increase of the support along n, in world axes, caused by the deformation.
  double rest_adds(const Vec3& n) const {
    const Vec3 local = of_.pose.rotation.transpose() * n;
    return reach(rest().transpose() * local) - reach(local);
  }

  /// The amount by which the shape's support along n, in world axes, exceeds the hull's; the shape's points there are
  /// added to the hull, and those at the angle `beside` around the axis, in radians.
  double grow(const Vec3& n, double beside) {
    const Vec3 local = of_.pose.rotation.transpose() * n, m = rest().transpose() * local;
    double known = local.dot(points_[0]);
    for (const Vec3& p : points_) known = std::max(known, local.dot(p));
    const double beyond = std::max(reach(m) - known, 0.0);
    if (m[0] == 0 && m[1] == 0) return beyond;
    const double angle = std::atan2(m[1], m[0]);
    add_sides(angle);
    if (beside > 0) add_sides(angle - beside), add_sides(angle + beside);
    return beyond;
  }

 private:
  bool is_cone() const { return of_.shape.kind() == ShapeKind::cone; }
  double half() const { return 0.5 * of_.shape.length(); }
  const Mat3& rest() const { return *of_.rest; }

  /// The support of the deformed shape along m, in its own frame.
  double reach(const Vec3& m) const {
    const double side = of_.shape.radius() * std::hypot(m[0], m[1]);
    return is_cone() ? std::max(side - half() * m[2], half() * m[2]) : side + half() * std::abs(m[2]);
  }

  void add_sides(double angle) {
    const double x = of_.shape.radius() * std::cos(angle), y = of_.shape.radius() * std::sin(angle);
    points_.push_back(rest() * Vec3(x, y, -half()));
    if (!is_cone()) points_.push_back(rest() * Vec3(x, y, half()));
  }

  const PlacedShape& of_;
  std::vector<Vec3> points_;
};

/// The undeformed cylinder or cone that agrees to first order with the shape around its point farthest along n, a unit
/// vector in world axes: matched at the lateral surface where n is near a normal of it, else at the plane of the disc.
PlacedShape alike(const PlacedShape& placed, const Vec3& n) {
  if (!placed.rest) return placed;
  const Mat3& rest = *placed.rest;
  const bool cone = placed.shape.kind() == ShapeKind::cone;
  double radius = placed.shape.radius(), length = placed.shape.length();
  const double half = 0.5 * length, slant = std::hypot(radius, length);
  const double sine = cone ? radius / slant : 0.0, cosine = cone ? length / slant : 1.0;  // of the lateral normals
  const Vec3 local = placed.pose.rotation.transpose() * n, m = (rest.transpose() * local).normalized();
  const double rho = std::hypot(m[0], m[1]), level = cone || m[2] < 0 ? -half : half;
  const Vec3 out = rho > 0 ? Vec3(m[0] / rho, m[1] / rho, 0) : Vec3::UnitX(), circle_centre = level * rest.col(2);
  Vec3 axis, centre = Vec3::Zero();
  if (cone && m[2] > 0.5 * (sine - 1)) {
    const Vec3 apex = half * rest.col(2), side = circle_centre + radius * (rest * out) - apex;
    const Vec3 normal = rest.transpose().inverse() * Vec3(cosine * out[0], cosine * out[1], sine);
    axis = sine * normal.normalized() - cosine * side.normalized();
    radius = sine * side.norm(), length = cosine * side.norm();
    centre = apex - 0.5 * length * axis;
  } else {
    const Vec3 across = rest.col(0).cross(rest.col(1));
    axis = !cone && std::abs(m[2]) < 0.5 ? rest.col(2).normalized() : across.normalized();
    length *= axis.dot(rest.col(2));
    radius *= std::sqrt(across.norm());
  }
  const Vec3 along = local - local.dot(axis) * axis;
  Vec3 off = Vec3::Zero();  // of the point on the circle
  if (!cone || m[2] * cosine <= rho * sine) {
    off = circle_centre - centre - std::copysign(0.5 * length, level) * axis;
    if (rho > tolerance::along_axis) off += placed.shape.radius() * (rest * out) - radius * along.normalized();
  }
  const Mat3 turned = placed.pose.rotation * turn_from_z(axis);
  const Pose pose{turned, placed.pose.translation + placed.pose.rotation * (centre + off)};
  return {cone ? Shape(Cone{radius, length}) : Shape(Cylinder{radius, length}), pose, {}};
}

/// Descends from a normal near a minimum of the support of the difference of two bounded convex shapes to that minimum:
/// shapes that agree to first order there have theirs nearby, and the shapes that agree at that one have theirs nearer.
/// `signed_distance` is the separation along the normal reached; minus infinity if there is none.
PairAnswer descend(const PlacedShape& a, const PlacedShape& b, const Vec3& normal) {
  constexpr int most_rounds = 8;
  PairAnswer out;
  out.signed_distance = -std::numeric_limits<double>::infinity();
  Vec3 n = normal;
  for (int round = 0; round < most_rounds; ++round) {
    const PlacedShape like_a = alike(a, n), like_b = alike(b, -n);
    const ConvexView view_a = view(like_a.shape), view_b = view(like_b.shape);
    const MinkowskiDifference difference{view_a, view_b, relative(like_a.pose, like_b.pose)};
    const Support s =
        minimize(RoundPair(difference), like_a.pose.rotation.transpose() * n, -std::numeric_limits<double>::infinity());
    const Vec3 to = (like_a.pose.rotation * s.n).normalized();
    const double turned = (to - n).norm();
    n = to;
    if (turned > tolerance::normal_turned || !s.optimal) continue;
    const double radius_a = core_radius(view_a), radius_b = core_radius(view_b);
    out.signed_distance = -s.h - radius_a - radius_b;
    out.normal = n;
    out.point_a = like_a.pose * Vec3(s.point[0] + radius_a * s.n);
    out.point_b = like_a.pose * Vec3(-s.point[1] - radius_b * s.n);
    break;
  }
  return out;
}

/// The point of a bounded convex shape farthest along n, in world axes.
Vec3 farthest(const PlacedShape& placed, const Vec3& n) {
  const ConvexView shape = view(placed.shape);
  const Vec3 local = placed.pose.rotation.transpose() * n;
  const Vec3 p = placed.rest ? Vec3(*placed.rest * core_support(shape, placed.rest->transpose() * local))
                             : core_support(shape, local);
  return placed.pose * p + core_radius(shape) * n.normalized();
}

/// The lateral normal of A, a cylinder or cone, along which A and B are most separated. Where the two are almost
/// rotationally symmetric, the deformation alone decides: the derivative along the circle of normals determines it
/// best.
Vec3 best_side(const PlacedShape& a, const PlacedShape& b) {
  constexpr int samples = 96;
  constexpr double turn = 2 * 3.14159265358979323846 / samples;
  const double sine =
      a.shape.kind() == ShapeKind::cone ? a.shape.radius() / std::hypot(a.shape.radius(), a.shape.length()) : 0.0;
  const double cosine = std::sqrt(1 - sine * sine);
  const Mat3 to_world = a.pose.rotation * a.rest->transpose().inverse();
  struct Side {
    Vec3 n;
    double apart, slope;
  };
  const auto at = [&](double angle) {
    const double x = cosine * std::cos(angle), y = cosine * std::sin(angle);
    const Vec3 n = to_world * Vec3(x, y, sine), next = to_world * Vec3(-y, x, 0);
    const double length = n.norm();
    const Vec3 p = farthest(b, -n) - farthest(a, n);
    return Side{n / length, n.dot(p) / length, next.dot(p) - n.dot(p) * n.dot(next) / (length * length)};
  };
  double angle = 0, most = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < samples; ++i)
    if (const double apart = at(i * turn).apart; apart > most) most = apart, angle = i * turn;
  double low = angle - turn, high = angle + turn;
  if (at(low).slope > 0 && at(high).slope < 0) {
    for (int i = 0; i < 60; ++i) {
      angle = 0.5 * (low + high);
      (at(angle).slope > 0 ? low : high) = angle;
    }
  }
  return at(angle).n;
}

/// solve() for two bounded bodies of which at least one is deformed, A at the origin: bounds the distance from both
/// sides, by hulls inside the bodies and by minima of undeformed bodies that agree to first order.
class LooseDistance {
 public:
  LooseDistance(const NarrowPhase& narrow_phase, const PlacedShape& a, const PlacedShape& b, const PairAnswer& first)
      : narrow_phase_(narrow_phase),
        a_(a),
        b_(b),
        convex_(a.shape.is_convex() && b.shape.is_convex()),
        size_(std::max(a.shape.size(), b.shape.size())),
        best_(first) {
    if (a.rest) hull_a_.emplace(a);
    if (b.rest) hull_b_.emplace(b);
    best_.signed_distance -=
        (hull_a_ ? hull_a_->rest_adds(best_.normal) : 0.0) + (hull_b_ ? hull_b_->rest_adds(-best_.normal) : 0.0);
  }

  PairAnswer find() {
    constexpr int most_rounds = 40;
    const double rounding = tolerance::bounds_meet * size_;
    improve(best_.normal);
    if (convex_ && best_.signed_distance <= 0) {
      if (a_.rest) consider_side(best_side(a_, b_));
      if (b_.rest) consider_side(-best_side(b_, a_));
    }
    double beside = tolerance::first_beside;
    for (int round = 0; round < most_rounds && above_ - best_.signed_distance > rounding; ++round) {
      close_in(beside);
      beside = beside > tolerance::nearest_beside ? 0.1 * beside : 0;
    }
    if (above_ - best_.signed_distance > rounding) best_.error_bound += above_ - best_.signed_distance;
    best_.collide = best_.signed_distance <= 0;
    best_.status = best_.error_bound > tolerance::accepted_error * size_ ? Status::inexact : Status::ok;
    return best_;
  }

 private:
  void consider(const PairAnswer& found) {
    if (found.signed_distance > best_.signed_distance) best_ = found;
  }
  void improve(const Vec3& n) {
    if (!convex_) return;
    const PairAnswer found = descend(a_, b_, n);
    if (found.signed_distance > 0) above_ = found.signed_distance;  // separated bodies have a single minimum
    // Beside the minimum by less than the rounding of the distance, the normal may be off by far more than rounding:
    // prefer the new one.
    if (found.signed_distance >= best_.signed_distance - 4 * epsilon * size_) best_ = found;
  }
  void consider_side(const Vec3& n) {
    PairAnswer side;
    side.normal = n;
    side.point_a = farthest(a_, n);
    side.signed_distance = n.dot(farthest(b_, -n) - side.point_a);
    side.point_b = side.point_a + side.signed_distance * n;
    consider(side);
    improve(n);
  }
  double grow(const Vec3& n, double beside) {
    return (hull_a_ ? hull_a_->grow(n, beside) : 0.0) + (hull_b_ ? hull_b_->grow(-n, beside) : 0.0);
  }
  /// The distance of the hulls, which then grow where they were nearest.
  void close_in(double beside) {
    const Shape in_a = hull_a_ ? hull_a_->shape() : a_.shape, in_b = hull_b_ ? hull_b_->shape() : b_.shape;
    PairAnswer found = narrow_phase_.solve(in_a, a_.pose, in_b, b_.pose, Request::distance);
    above_ = std::min(above_, found.signed_distance);
    const Vec3 n = found.normal;
    found.signed_distance -= grow(n, beside);  // before the hulls grow further
    grow(best_.normal, beside);
    found.point_b = found.point_a + found.signed_distance * n;
    consider(found);
    improve(n);
  }

  const NarrowPhase& narrow_phase_;
  const PlacedShape &a_, &b_;
  bool convex_;
  double size_;
  std::optional<InnerHull> hull_a_, hull_b_;
  PairAnswer best_;                                         ///< the separation along best_.normal, a lower bound
  double above_ = std::numeric_limits<double>::infinity();  ///< the distance of the hulls, an upper bound
};

/// solve() for two bodies of which at least one is deformed, A at the origin.
PairAnswer solve_loose(const NarrowPhase& narrow_phase, const PlacedShape& a, const PlacedShape& b, Request request,
                       std::vector<Contact>* contacts) {
  PairAnswer best = narrow_phase.solve(a.shape, a.pose, b.shape, b.pose, Request::distance);
  const auto solve_alike = [&] {
    const PlacedShape like_a = alike(a, best.normal), like_b = alike(b, -best.normal);
    return narrow_phase.solve(like_a.shape, like_a.pose, like_b.shape, like_b.pose, request, contacts);
  };
  if (!a.shape.is_bounded() || !b.shape.is_bounded()) return solve_alike();
  best = LooseDistance(narrow_phase, a, b, best).find();
  if (request == Request::contacts) (void)solve_alike();
  return best;
}

/// The hull of transformed points: the corners of a box, or a convex's vertices.
Shape hull_of(std::vector<Vec3> vertices, const Mat3& rest) {
  for (Vec3& v : vertices) v = rest * v;
  return Shape(Convex{std::move(vertices)});
}

std::vector<Vec3> corners_of(const Vec3& half) {
  std::vector<Vec3> out;
  for (unsigned i = 0; i < 8; ++i)
    out.push_back(half.cwiseProduct(Vec3(i & 1u ? 1 : -1, i & 2u ? 1 : -1, i & 4u ? 1 : -1)));
  return out;
}

Shape triangles_of(const Shape& shape, const Mat3& rest) {
  Mesh mesh{{shape.vertices().begin(), shape.vertices().end()},
            {shape.triangles().begin(), shape.triangles().end()},
            shape.is_solid()};
  for (Vec3& v : mesh.vertices) v = rest * v;
  if (shape.kind() == ShapeKind::mesh) return Shape(std::move(mesh));
  return Triangle{{mesh.vertices[0], mesh.vertices[1], mesh.vertices[2]}};
}

/// Replaces a deformed ellipsoid by one of other radii and axes.
void take_rest(const Vec3& radii, const Mat3& rest, PlacedShape& out) {
  const Eigen::JacobiSVD<Mat3, Eigen::NoQRPreconditioner> svd(rest * radii.asDiagonal(), Eigen::ComputeFullU);
  Mat3 axes = svd.matrixU();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  out.pose.rotation *= axes;
  out.shape = Ellipsoid{svd.singularValues()};
}

}  // namespace

PlacedShape place(const Shape& shape, const Pose& pose) {
  PlacedShape out{shape, orthonormalized(pose), {}};
  if (out.pose.rotation == pose.rotation) return out;
  const Mat3 rest = out.pose.rotation.transpose() * pose.rotation;
  switch (shape.kind()) {
    case ShapeKind::sphere:
      break;
    case ShapeKind::box:
      out.shape = hull_of(corners_of(shape.half_size()), rest);
      break;
    case ShapeKind::capsule: {
      const Vec3 along = rest.col(2);
      out.pose.rotation *= turn_from_z(along.normalized());
      out.shape = Capsule{shape.radius(), shape.length() * along.norm()};
      break;
    }
    case ShapeKind::ellipsoid:
      take_rest(shape.radii(), rest, out);
      break;
    case ShapeKind::convex:
      out.shape = hull_of({shape.vertices().begin(), shape.vertices().end()}, rest);
      break;
    case ShapeKind::triangle:
    case ShapeKind::mesh:
      out.shape = triangles_of(shape, rest);
      break;
    case ShapeKind::halfspace:
      out.shape = HalfSpace{rest.transpose().inverse() * shape.normal(), shape.offset()};
      break;
    case ShapeKind::plane:
      out.shape = Plane{rest.transpose().inverse() * shape.normal(), shape.offset()};
      break;
    case ShapeKind::voxels:
      throw std::invalid_argument("voxels: the rotation is not orthonormal to rounding, as it must be for them");
    case ShapeKind::cylinder:
    case ShapeKind::cone:
      if (shape.rounding() > 0)
        throw std::invalid_argument("rounding of a " + std::string(name(shape.kind())) +
                                    ": the rotation is not orthonormal to rounding, as it must be for one");
      out.rest = rest;
      break;
  }
  if (shape.rounding() > 0 && out.shape.rounding() == 0) out.shape = out.shape.rounded(shape.rounding());
  return out;
}

PairAnswer solve(const NarrowPhase& narrow_phase, const PlacedShape& a, const PlacedShape& b, Request request,
                 std::vector<Contact>* contacts) {
  if (!a.rest && !b.rest) return narrow_phase.solve(a.shape, a.pose, b.shape, b.pose, request, contacts);
  // Far from the origin a small translation would be lost to rounding.
  const Vec3 origin = a.pose.translation;
  PlacedShape near_a = a, near_b = b;
  near_a.pose.translation -= origin, near_b.pose.translation -= origin;
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  PairAnswer answer = solve_loose(narrow_phase, near_a, near_b, request, contacts);
  answer.point_a += origin, answer.point_b += origin;
  if (contacts != nullptr)
    for (std::size_t i = first; i < contacts->size(); ++i) (*contacts)[i].point += origin;
  return answer;
}

namespace {

/// An undeformed shape with the nearest rotation, enlarged so that it contains the deformed one.
PlacedShape outside(const PlacedShape& placed) {
  if (!placed.rest) return placed;
  // No point is moved by more than that, and scaling a shape about a ball that it contains extends it by as much as it
  // does the ball.
  const double moved = (*placed.rest - Mat3::Identity()).norm() * placed.shape.size();
  const double scale = 1 + 1.01 * moved / core_inner_radius(view(placed.shape));
  const double radius = scale * placed.shape.radius(), length = scale * placed.shape.length();
  const bool cone = placed.shape.kind() == ShapeKind::cone;
  return {cone ? Shape(Cone{radius, length}) : Shape(Cylinder{radius, length}), placed.pose, {}};
}

/// Two moving bodies, A at pose + time * velocity.
struct Meeting {
  const NarrowPhase& narrow_phase;
  const PlacedShape& a;
  Vec3 velocity_a;
  const PlacedShape& b;
  Vec3 velocity_b;

  std::optional<double> of_outsides(double until) const {
    const PlacedShape out_a = outside(a), out_b = outside(b);
    return narrow_phase.time_of_impact(out_a.shape, out_a.pose, velocity_a, out_b.shape, out_b.pose, velocity_b, until);
  }

  /// For convex shapes: conservative advancement (Mirtich 1996) from a time up to which they do not touch.
  std::optional<double> advance(double from, double until) const {
    constexpr int most_advances = 200;
    const double rounding =
        tolerance::touch * ((a.shape.is_bounded() ? a.shape.size() : 0) + (b.shape.is_bounded() ? b.shape.size() : 0));
    double time = from;
    for (int i = 0; i < most_advances; ++i) {
      PlacedShape at_a = a, at_b = b;
      at_a.pose.translation += time * velocity_a, at_b.pose.translation += time * velocity_b;
      const PairAnswer now = solve(narrow_phase, at_a, at_b, Request::distance);
      if (now.signed_distance <= rounding) return time;
      const double closing = now.normal.dot(velocity_a - velocity_b);
      if (!(closing > 0)) return std::nullopt;
      const double next = time + now.signed_distance / closing;
      if (!(next <= until * (1 + tolerance::end_of_motion))) return std::nullopt;
      if (next <= time) return time;
      time = std::min(next, until);
    }
    return time;
  }
};

}  // namespace

std::optional<double> time_of_impact(const NarrowPhase& narrow_phase, const PlacedShape& a, const Vec3& velocity_a,
                                     const PlacedShape& b, const Vec3& velocity_b, double tmax) {
  const Meeting whole{narrow_phase, a, velocity_a, b, velocity_b};
  const std::optional<double> early = whole.of_outsides(tmax);
  if (!early || (!a.rest && !b.rest)) return early;
  if (solve(narrow_phase, a, b, Request::collide).collide) return 0.0;
  if (a.shape.is_convex() && b.shape.is_convex()) return whole.advance(*early, tmax);
  // Triangle by triangle, in the order of the earliest possible impact.
  const bool mesh_a = !a.shape.is_convex();
  const PlacedShape& mesh = mesh_a ? a : b;
  struct Candidate {
    double early;
    PlacedShape triangle;
  };
  const auto meeting = [&](const PlacedShape& triangle) {
    return Meeting{narrow_phase, mesh_a ? triangle : a, velocity_a, mesh_a ? b : triangle, velocity_b};
  };
  std::vector<Candidate> candidates;
  const auto consider = [&](PlacedShape piece) {
    if (const auto time = meeting(piece).of_outsides(tmax)) candidates.push_back({*time, std::move(piece)});
  };
  const auto vertices = mesh.shape.vertices();
  for (const auto& [i, j, k] : mesh.shape.triangles())
    consider({Triangle{{vertices[i], vertices[j], vertices[k]}}, mesh.pose, {}});
  for (const auto& [corner, level] : mesh.shape.cells()) {  // of voxels
    const double size = mesh.shape.cell_size(), edge = std::ldexp(size, level);
    const Vec3 centre = mesh.shape.origin() + size * Vec3(corner[0], corner[1], corner[2]) + Vec3::Constant(edge / 2);
    const Pose at{mesh.pose.rotation, mesh.pose * centre};
    consider({Shape(Box{Vec3::Constant(edge)}).rounded(mesh.shape.rounding()), at, {}});
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& x, const Candidate& y) { return x.early < y.early; });
  std::optional<double> first;
  for (const Candidate& c : candidates) {
    if (c.early >= first.value_or(std::numeric_limits<double>::infinity())) break;
    if (const auto time = meeting(c.triangle).advance(c.early, first.value_or(tmax))) first = time;
  }
  return first;
}

}  // namespace tandem
