// Convex bodies with round pieces, as summands of A - B for Newton's method on supports.
#pragma once
#include <algorithm>
#include <limits>
#include <utility>

#include "shapes/hull.h"
#include "shapes/support.h"
#include "tolerances.h"

namespace tandem {

/// An arc of a great or small circle of directions: (p + q t + s t^2) / (1 + t^2) is a unit vector for every t, the
/// tangent of half the angle.
struct Arc {
  Vec3 p, q, s;
  Vec3 at(double t) const { return (p + t * (q + t * s)) / (1 + t * t); }
};

/// The circle of unit directions n with n . axis = height, at distance `radius` from the axis; the axis is unit if
/// height is not 0.
struct Circle {
  Vec3 axis;
  double height = 0;
  double radius = 1;
};

/// The core of A, or of -B, in A's frame: a summand of A - B. It is the hull of a few pieces with smooth support
/// functions: vertices, circles of discs, an ellipsoid. The directions where the support passes from one piece to
/// another lie on a circle, and are supported by the edge, lateral line or face between the pieces.
class RoundBody {
 public:
  /// The point x of the shape's frame is at axes * x + centre.
  RoundBody(const ConvexView& v, const Mat3& axes, const Vec3& centre)
      : view_(&v), axes_(axes), centre_(centre), radius_(v.param[0]), half_(0.5 * v.param[1]) {
    if (v.kind == ShapeKind::cone) {
      const double slant = std::sqrt(v.param[0] * v.param[0] + v.param[1] * v.param[1]);
      sine_ = v.param[0] / slant, cosine_ = v.param[1] / slant;
    }
  }

  ShapeKind kind() const { return view_->kind; }
  const Mat3& axes() const { return axes_; }
  const Hull& hull() const { return *view_->hull; }  ///< of a convex body
  const ConvexView& view() const { return *view_; }
  Vec3 axis() const { return axes_.col(2); }
  double radius() const { return radius_; }

  bool has_circle() const { return kind() == ShapeKind::cylinder || kind() == ShapeKind::cone; }
  bool is_circle(int piece) const { return kind() == ShapeKind::cylinder || (kind() == ShapeKind::cone && piece == 0); }
  /// +1 or -1 for a circle: the direction of its disc along the axis.
  double facing(int piece) const { return kind() == ShapeKind::cylinder && piece == 0 ? 1.0 : -1.0; }
  /// A circle supports n if facing * (axis . n) >= -circle_lift().
  double circle_lift() const { return sine_; }
  Vec3 circle_centre(int piece) const { return centre_ + facing(piece) * half_ * axis(); }

  /// A piece that is farthest along n.
  int support_piece(const Vec3& n) const {
    const Vec3 m = axes_.transpose() * n;
    switch (kind()) {
      case ShapeKind::box:
        return (m[0] < 0 ? 1 : 0) | (m[1] < 0 ? 2 : 0) | (m[2] < 0 ? 4 : 0);
      case ShapeKind::capsule:
      case ShapeKind::cylinder:
        return m[2] < 0 ? 1 : 0;
      case ShapeKind::cone:
        return to_apex(m) ? 1 : 0;
      case ShapeKind::convex:
      case ShapeKind::triangle:
        return static_cast<int>(core_support_point(*view_, m, support_kernel()).vertex);
      case ShapeKind::sphere:
      case ShapeKind::ellipsoid:
      case ShapeKind::halfspace:
      case ShapeKind::plane:
      case ShapeKind::voxels:
      case ShapeKind::mesh:
        break;
    }
    return 0;
  }

  /// True if the body is symmetric under inversion; then centre() is its centre.
  bool symmetric() const { return kind() != ShapeKind::cone && view_->vertices.empty(); }
  const Vec3& centre() const { return centre_; }

  /// The point of support_piece(n).
  Vec3 support(const Vec3& n) const {
    if (kind() == ShapeKind::sphere) return centre_;
    const Vec3 m = axes_.transpose() * n;
    return centre_ + axes_ * (has_circle() ? circle_support(m) : core_support(*view_, m));
  }
  /// The support of a body with a circle, in its own frame: m is along its axes.
  Vec3 circle_support(const Vec3& m) const {
    if (kind() == ShapeKind::cone && to_apex(m)) return {0, 0, half_};
    const double k = onto_circle(radius_, std::sqrt(m[0] * m[0] + m[1] * m[1]));
    return {k * m[0], k * m[1], kind() == ShapeKind::cone || m[2] < 0 ? -half_ : half_};
  }

  /// The piece's point farthest along n; for a circle with n along its axis all points are, and one is returned.
  Vec3 point(int piece, const Vec3& n) const {
    if (is_circle(piece)) {
      // In the disc's plane to rounding, whatever the angle.
      const double x = axes_.col(0).dot(n), y = axes_.col(1).dot(n), k = onto_circle(radius_, std::sqrt(x * x + y * y));
      return circle_centre(piece) + (k * x) * axes_.col(0) + (k * y) * axes_.col(1);
    }
    if (kind() == ShapeKind::ellipsoid) {
      const Vec3 r{view_->param[0], view_->param[1], view_->param[2]};
      const Vec3 q = r.cwiseProduct(axes_.transpose() * n);
      return centre_ + axes_ * (r.cwiseProduct(q) / q.norm());
    }
    return centre_ + axes_ * corner(piece);
  }

  /// The radii of curvature of the piece where its normal is n, along the orthonormal tangents u and v: uu, uv, vv.
  void add_curvature(int piece, const Vec3& n, const Vec3& u, const Vec3& v, double w[3]) const {
    if (is_circle(piece)) {
      const Vec3 t = axis().cross(n);
      const double rho2 = t.squaredNorm();
      if (!(rho2 > tolerance::curvature_in_range)) return;  // along the axis; beyond, the curvature would overflow
      const double k = radius_ / (rho2 * std::sqrt(rho2)), tu = t.dot(u), tv = t.dot(v);
      w[0] += k * tu * tu, w[1] += k * tu * tv, w[2] += k * tv * tv;
    } else if (kind() == ShapeKind::ellipsoid) {
      const Vec3 r{view_->param[0], view_->param[1], view_->param[2]};
      const Vec3 q = r.cwiseProduct(axes_.transpose() * n), a = r.cwiseProduct(axes_.transpose() * u),
                 b = r.cwiseProduct(axes_.transpose() * v);
      const double l2 = q.squaredNorm(), k = 1 / std::sqrt(l2), qa = q.dot(a) / l2, qb = q.dot(b);
      w[0] += k * (a.squaredNorm() - qa * q.dot(a)), w[1] += k * (a.dot(b) - qa * qb);
      w[2] += k * (b.squaredNorm() - qb * qb / l2);
    }
  }

  /// The circle beyond which, towards the axis, `other` takes over from `piece`.
  Circle circle(int piece, int other) const {
    switch (kind()) {
      case ShapeKind::capsule:
      case ShapeKind::cylinder:
        return {piece == 0 ? Vec3(-axis()) : axis()};
      case ShapeKind::cone:
        return piece == 0 ? Circle{axis(), sine_, cosine_} : Circle{-axis(), -sine_, cosine_};
      case ShapeKind::sphere:
      case ShapeKind::box:
      case ShapeKind::ellipsoid:
      case ShapeKind::halfspace:
      case ShapeKind::plane:
      case ShapeKind::convex:
      case ShapeKind::triangle:
      case ShapeKind::voxels:
      case ShapeKind::mesh:
        break;
    }
    return {unit(axes_ * (corner(other) - corner(piece)))};
  }

  /// The circles that contain all directions with more than one supporting point, except for discs and vertices of
  /// hulls.
  int kinks(Circle* circles) const {
    switch (kind()) {
      case ShapeKind::box:
        for (int k = 0; k < 3; ++k) circles[k] = {axes_.col(k)};
        return 3;
      case ShapeKind::capsule:
      case ShapeKind::cylinder:
      case ShapeKind::cone:
        circles[0] = {axis(), sine_, cosine_};
        return 1;
      case ShapeKind::triangle: {
        int count = 0;
        const std::size_t corners = view_->vertices.size(), sides = is_segment() ? 1 : corners;
        for (std::size_t i = 0; i < sides; ++i) {
          const Vec3 e = view_->vertices[(i + 1) % corners] - view_->vertices[i];
          const double length = e.norm();
          if (length > 0) circles[count++] = {axes_ * unit(e, length)};
        }
        return count;
      }
      case ShapeKind::ellipsoid: {
        // A needle is almost a segment.
        int longest = 0;
        for (int k = 1; k < 3; ++k)
          if (view_->param[static_cast<std::size_t>(k)] > view_->param[static_cast<std::size_t>(longest)]) longest = k;
        for (int k = 0; k < 3; ++k)
          if (k != longest &&
              !(view_->param[static_cast<std::size_t>(longest)] > 8 * view_->param[static_cast<std::size_t>(k)]))
            return 0;
        circles[0] = {axes_.col(longest)};
        return 1;
      }
      case ShapeKind::sphere:
      case ShapeKind::halfspace:
      case ShapeKind::plane:
      case ShapeKind::convex:
      case ShapeKind::voxels:
      case ShapeKind::mesh:
        break;
    }
    return 0;
  }

  /// True for a hull or triangle whose vertices are collinear.
  bool is_segment() const { return view_->vertices.size() == 2; }

  /// True if on the circles of these bodies the support is middle() . n + level(), constant all around.
  bool is_level() const { return kind() == ShapeKind::capsule || has_circle() || is_segment(); }
  /// A point of the axis of a body that is rotationally symmetric.
  Vec3 middle() const { return is_segment() ? Vec3(centre_ + axes_ * corner(0)) : centre_; }
  double level() const {
    return kind() == ShapeKind::cylinder ? radius_ : kind() == ShapeKind::cone ? half_ * sine_ : 0.0;
  }

  /// The ratio of an ellipsoid's longest to its shortest axis; 1 for others.
  double aspect() const {
    if (kind() != ShapeKind::ellipsoid) return 1;
    const auto [least, most] = std::minmax({view_->param[0], view_->param[1], view_->param[2]});
    return most / least;
  }

  /// The radius of a ball rolling inside an ellipsoid, as far as directions on the circle can tell: the support there
  /// is that of a smaller body plus this radius. At least its least radius of curvature. 0 for other kinds.
  double rolling_ball(const Circle& c) const {
    if (kind() != ShapeKind::ellipsoid) return 0;
    const Vec3 r{view_->param[0], view_->param[1], view_->param[2]};
    if (c.height != 0) return r.minCoeff() * r.minCoeff() / r.maxCoeff();
    // Projected along the axis it is an ellipse with these squared half axes.
    const Vec3 u = any_perpendicular(c.axis), v = c.axis.cross(u);
    const Vec3 a = r.cwiseProduct(axes_.transpose() * u), b = r.cwiseProduct(axes_.transpose() * v);
    const double mean = 0.5 * (a.squaredNorm() + b.squaredNorm()), half = 0.5 * (a.squaredNorm() - b.squaredNorm());
    const double spread = std::sqrt(half * half + a.dot(b) * a.dot(b));
    return std::max(0.0, mean - spread) / std::sqrt(mean + spread);
  }

  /// The first t in (0, end) where a piece not among the `count` active ones takes over from one of them.
  template <class Report>
  void first_crossing(const Arc& arc, double end, const int* active, int count, Report&& report) const {
    if (kind() == ShapeKind::ellipsoid || kind() == ShapeKind::sphere) return;
    const auto cross = [&](int from, int other, const Vec3& axis, double height) {
      const double a = arc.p.dot(axis) - height, b = arc.q.dot(axis), c = arc.s.dot(axis) - height;
      if (const double t = first_positive(a, b, c, end); t <= end) report(t, from, other);
    };
    if (kind() == ShapeKind::capsule || kind() == ShapeKind::cylinder || kind() == ShapeKind::cone) {
      if (count > 1) return;
      const Circle k = circle(active[0], 1 - active[0]);
      return cross(active[0], 1 - active[0], k.axis, k.height);
    }
    const auto is_active = [&](int i) {
      for (int k = 0; k < count; ++k)
        if (active[k] == i) return true;
      return false;
    };
    if (kind() == ShapeKind::box) {
      for (int bit = 1; bit < 8; bit *= 2) {
        bool along = false;
        for (int k = 1; k < count; ++k) along = along || ((active[0] ^ active[k]) & bit) != 0;
        const int k = bit >> 1;
        if (!along) cross(active[0], active[0] ^ bit, (active[0] & bit) != 0 ? axes_.col(k) : Vec3(-axes_.col(k)), 0);
      }
      return;
    }
    // Vertices of a hull: in its frame.
    const Arc local{axes_.transpose() * arc.p, axes_.transpose() * arc.q, axes_.transpose() * arc.s};
    const auto cross_corner = [&](int from, int other) {
      if (is_active(other)) return;
      const Vec3 e = corner(other) - corner(from);
      const double a = local.p.dot(e), b = local.q.dot(e), c = local.s.dot(e);
      if (const double t = first_positive(a, b, c, end); t <= end) report(t, from, other);
    };
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(active[k]);
      if (view_->hull == nullptr || view_->vertices.size() <= 4) {
        for (int j = 0; j < static_cast<int>(view_->vertices.size()); ++j) cross_corner(active[k], j);
      } else {
        for (std::uint32_t j = view_->hull->neighbour_first[i]; j < view_->hull->neighbour_first[i + 1]; ++j)
          cross_corner(active[k], static_cast<int>(view_->hull->neighbours[j]));
      }
    }
  }

  /// The points that are farthest along n within `tolerance`: vertices of a face, ends of a line, at most `capacity`;
  /// returns how many. A disc perpendicular to n is its centre, and `disc` its radius.
  int face(const Vec3& n, double tolerance, Vec3* points, int capacity, double& disc) const {
    disc = 0;
    const int first = support_piece(n);
    if (is_circle(first)) {
      const double rho = n.cross(axis()).norm();
      if (rho * radius_ <= tolerance) {
        disc = radius_;
        points[0] = circle_centre(first);
        return 1;
      }
    }
    points[0] = point(first, n);
    if (kind() == ShapeKind::ellipsoid || kind() == ShapeKind::sphere) return 1;
    int count = 1;
    const auto consider = [&](int i, double along) {
      if (i != first && along >= -tolerance) points[count++] = point(i, n);
    };
    if (kind() == ShapeKind::convex || kind() == ShapeKind::triangle) {
      const Vec3 m = axes_.transpose() * n, top = corner(first);
      const int corners = static_cast<int>(view_->vertices.size());
      for (int i = 0; i < corners && count < capacity; ++i) consider(i, m.dot(corner(i) - top));
      return count;
    }
    const int pieces = kind() == ShapeKind::box ? 8 : 2;
    for (int i = 0; i < pieces && count < capacity; ++i) consider(i, n.dot(point(i, n) - points[0]));
    return count;
  }

 private:
  /// The first t in [0, end] from which a + b t + c t^2 is positive, to rounding; beyond `end` if there is none. An arc
  /// past a small circle, as that of a flat cone's lateral surface, may enter and leave it.
  static double first_positive(double a, double b, double c, double end) {
    const double square = b * b - 4 * a * c;
    const bool passes = a < 0 && b > 0 && b + 2 * end * c < 0 && square > 0;
    if (!passes && !(a + end * (b + end * c) > 0)) return std::numeric_limits<double>::infinity();
    if (a >= 0) return 0;
    const double root = b + std::sqrt(std::max(0.0, square));
    return root > 0 ? std::min(end, -2 * a / root) : end;
  }

  /// True if a cone's apex is farther along m, in its frame, than its circle. Flat cones need the ratio, not the
  /// cosine.
  bool to_apex(const Vec3& m) const {
    return m[2] > 0 && m[2] * m[2] * cosine_ * cosine_ > (m[0] * m[0] + m[1] * m[1]) * sine_ * sine_;
  }

  Vec3 corner(int i) const {
    switch (kind()) {
      case ShapeKind::box:
        return {i & 1 ? -view_->param[0] : view_->param[0], i & 2 ? -view_->param[1] : view_->param[1],
                i & 4 ? -view_->param[2] : view_->param[2]};
      case ShapeKind::capsule:
        return {0, 0, i == 0 ? half_ : -half_};
      case ShapeKind::cone:
        return {0, 0, half_};
      case ShapeKind::convex:
      case ShapeKind::triangle:
        return view_->vertices[static_cast<std::size_t>(i)];
      case ShapeKind::sphere:
      case ShapeKind::cylinder:
      case ShapeKind::ellipsoid:
      case ShapeKind::halfspace:
      case ShapeKind::plane:
      case ShapeKind::voxels:
      case ShapeKind::mesh:
        break;
    }
    return Vec3::Zero();
  }

  const ConvexView* view_;
  Mat3 axes_;
  Vec3 centre_;
  double radius_, half_;
  double sine_ = 0, cosine_ = 1;  ///< for a cone: height and radius of the circle of its lateral normals
};

}  // namespace tandem
