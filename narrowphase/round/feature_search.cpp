#include "round/feature_search.h"

#include <limits>
#include <utility>

#include "round/hull_projection.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int rounds = 4;
constexpr int turns = 4;           ///< of features a round
constexpr double clearance = 0.1;  ///< of the smaller size
constexpr int newton_steps = 8;
using tolerance::newton_end;  ///< radians: the step after so small a one changes no digit

/// A core where it stands, in A's frame.
struct FeatureBody {
  const ConvexView& core;
  const Mat3* axes;  ///< null: those of the frame
  Vec3 centre;

  Vec3 turned_in(const Vec3& v) const { return axes != nullptr ? Vec3(axes->transpose() * v) : v; }
  Vec3 in(const Vec3& p) const { return axes != nullptr ? Vec3(axes->transpose() * (p - centre)) : p; }
  Vec3 out(const Vec3& q) const { return axes != nullptr ? Vec3(*axes * q + centre) : q; }
  Vec3 turned_out(const Vec3& v) const { return axes != nullptr ? Vec3(*axes * v) : v; }
  Vec3 axis(int k) const { return axes != nullptr ? Vec3(axes->col(k)) : Vec3(Vec3::Unit(k)); }

  /// How far it reaches along n beyond its centre.
  double reach(const Vec3& n) const {
    const Vec3 m = turned_in(n);
    const double half = 0.5 * core.param[1];
    switch (core.kind) {
      case ShapeKind::box:
        return core.param[0] * std::abs(m[0]) + core.param[1] * std::abs(m[1]) + core.param[2] * std::abs(m[2]);
      case ShapeKind::capsule:
        return half * std::abs(m[2]);
      case ShapeKind::cylinder:
        return core.param[0] * std::sqrt(m[0] * m[0] + m[1] * m[1]) + half * std::abs(m[2]);
      case ShapeKind::convex:
        return core_support(core, m).dot(m);
      case ShapeKind::cone:
        return std::max(half * m[2], core.param[0] * std::sqrt(m[0] * m[0] + m[1] * m[1]) - half * m[2]);
      case ShapeKind::sphere:
      case ShapeKind::ellipsoid:
      case ShapeKind::halfspace:
      case ShapeKind::plane:
      case ShapeKind::triangle:
      case ShapeKind::mesh:
        break;  // have no features (have_features)
    }
    return std::numeric_limits<double>::infinity();
  }
  Vec3 support(const Vec3& n) const { return out(core_support(core, turned_in(n))); }
};

/// The point of a body nearest to another.
struct Spot {
  Vec3 q;  ///< in the body's frame
  Surface surface;
  bool inside = false;                            ///< the point moved lies in the body, farther than rounding
  std::uint32_t vertex = 0, other = 0, face = 0;  ///< of a hull: as HullSpot has them
};

/// Moves p to the nearest point of the body. On a hull it is searched from where the last one was found, if any was.
Spot project(const FeatureBody& body, Vec3& p, double least, const Spot* last = nullptr) {
  Spot spot;
  spot.q = body.in(p);
  if (body.core.kind == ShapeKind::convex) {
    const Hull& hull = *body.core.hull;
    const std::uint32_t from =
        last != nullptr ? last->vertex : core_support_point(body.core, spot.q - hull.inside, support_kernel()).vertex;
    const HullSpot found = nearest_on_hull(hull, spot.q, from);
    spot = {found.q, found.surface, false, found.vertex, found.other, found.face};
  } else {
    const Projection moved = move_into(body.core, spot.q, least);
    spot.surface = moved.surface, spot.inside = moved.inside;
  }
  p = body.out(spot.q);
  return spot;
}

/// Of a core's surface, as far as it goes, and beyond: a point; a plane; a line, or what is `radius` from it; the
/// mantle of an endless cone; a circle.
struct Feature {
  Surface surface = Surface::none;
  Vec3 point;           ///< the corner; the foot on the plane; the middle of the line or circle; the apex
  Vec3 axis;            ///< of the plane, outwards; along the line; of the cone, towards its apex
  Vec3 u, v;            ///< the circle's plane
  double c = 1, s = 0;  ///< where on the circle, along u and v
  double radius = 0;
  double sine = 0, cosine = 1;  ///< of the normals to the cone with the plane square to its axis
  double low = 0, high = 0;     ///< the line's ends; on the cone, down from the apex
  std::uint32_t face = 0;       ///< of a hull
};

Feature hull_feature(const FeatureBody& body, const Spot& spot) {
  const ConvexView& core = body.core;
  Feature f;
  f.surface = spot.surface;
  if (f.surface == Surface::flat) {
    f.face = spot.face;
    f.axis = body.turned_out(core.hull->faces[spot.face].normal);
    f.point = body.out(spot.q);
  } else if (f.surface == Surface::straight) {
    const Vec3 v = core.vertices[spot.vertex], along = core.vertices[spot.other] - v;
    f.high = along.norm();
    f.axis = body.turned_out(unit(along));
    f.point = body.out(v);
  } else {
    f.point = body.out(spot.q);
  }
  return f;
}

/// The axis square to a box's face that q lies on, or along its edge.
int box_axis(const ConvexView& box, const Vec3& q, double least, bool on_face) {
  int k = 0;
  while (k < 2 && (std::abs(q[k]) < box.param[static_cast<std::size_t>(k)] - least) == on_face) ++k;
  return k;
}

/// A box's edge, a capsule's segment, or a cylinder's side, which is its axis and a radius.
void set_line(const FeatureBody& body, const Vec3& q, double least, Feature& f) {
  const ConvexView& core = body.core;
  if (core.kind == ShapeKind::box) {
    const int k = box_axis(core, q, least, false);
    f.axis = body.axis(k);
    f.high = core.param[static_cast<std::size_t>(k)];
    f.point = body.out(q) - q[k] * f.axis;
  } else {
    f.axis = body.axis(2);
    f.high = 0.5 * core.param[1];
    f.point = body.centre;
    if (core.kind == ShapeKind::cylinder) f.radius = core.param[0];
  }
  f.low = -f.high;
}

Feature feature(const FeatureBody& body, const Spot& spot, double least) {
  const ConvexView& core = body.core;
  if (core.kind == ShapeKind::convex) return hull_feature(body, spot);
  const Vec3& q = spot.q;
  const double half = 0.5 * core.param[1];
  Feature f;
  f.surface = spot.surface;
  switch (f.surface) {
    case Surface::flat: {
      const int k = core.kind == ShapeKind::box ? box_axis(core, q, least, true) : 2;
      f.axis = std::copysign(1.0, q[k]) * body.axis(k);
      f.point = body.out(q);
      break;
    }
    case Surface::straight:
      set_line(body, q, least, f);
      break;
    case Surface::side: {
      const double radius = core.param[0], length = core.param[1], slant = std::sqrt(radius * radius + length * length);
      f.axis = body.axis(2);
      f.point = body.centre + half * f.axis;
      f.sine = radius / slant, f.cosine = length / slant;
      f.high = slant;
      break;
    }
    case Surface::circle: {
      f.u = body.axis(0), f.v = body.axis(1);
      f.radius = core.param[0];
      f.point = body.centre + std::copysign(half, q[2]) * body.axis(2);
      const double rho = std::sqrt(q[0] * q[0] + q[1] * q[1]);
      f.c = q[0] / rho, f.s = q[1] / rho;
      break;
    }
    default:
      f.point = body.out(q);
  }
  return f;
}

/// Turns (c, s) by an angle below 1 and a bit.
void turn(double& c, double& s, double angle) {
  const double t = 0.5 * angle, k = 1 / (1 + t * t), x = (1 - t * t) * k, y = 2 * t * k;
  const double turned = x * c - y * s;
  s = x * s + y * c;
  c = turned;
}

/// Between two features: their nearest points, or those that are farthest in each other. Where one lies beyond the
/// feature's end, the end.
struct NearestPoints {
  Vec3 a, b;
  Vec3 n;  ///< unit, from a to b where they are apart; before it is known about that
};

bool within(const Feature& f, double t, double rounding) { return t >= f.low - rounding && t <= f.high + rounding; }

/// v of unit length; `otherwise` where it is too short to have a direction.
Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length2 = v.squaredNorm();
  return length2 > tolerance::shortest_squared ? Vec3(v / std::sqrt(length2)) : otherwise;
}

/// The same of v or -v, not against n.
Vec3 unit_along(const Vec3& v, const Vec3& n) { return unit_or(v.dot(n) < 0 ? Vec3(-v) : v, n); }

/// The line of a cone's side where its normal is `out`.
Feature generator(const Feature& side, const Vec3& out) {
  Feature line = side;
  line.surface = Surface::straight;
  line.axis = (side.sine * out - side.axis) / side.cosine;
  return line;
}

/// From a corner to anything but a face.
bool corner_to_feature(const Vec3& corner, const Feature& f, double rounding, NearestPoints& w) {
  w.a = corner;
  const Vec3 from = corner - f.point;
  if (f.surface == Surface::corner) {
    w.b = f.point;
    w.n = unit_along(from, w.n);
    return true;
  }
  if (f.surface == Surface::circle) {
    const double x = from.dot(f.u), y = from.dot(f.v), rho = std::sqrt(x * x + y * y);
    if (!(rho > 0)) return false;
    w.b = f.point + (f.radius / rho) * (x * f.u + y * f.v);
    w.n = unit_along(corner - w.b, w.n);
    return true;
  }
  const double up = from.dot(f.axis);
  const Vec3 off = from - up * f.axis;
  if (f.surface == Surface::side) {
    const Vec3 out = f.cosine * unit_along(off, -w.n) + f.sine * f.axis;
    const Feature line = generator(f, out);
    const double down = from.dot(line.axis);
    w.b = f.point + down * line.axis;
    w.n = -out;
    return within(f, down, rounding);
  }
  w.n = unit_along(off, w.n);
  w.b = f.point + std::clamp(up, f.low, f.high) * f.axis - f.radius * w.n;
  return within(f, up, rounding);
}

/// Two lines; `n` is square to both.
bool line_to_line(const Feature& a, const Feature& b, const Vec3& n, double rounding, NearestPoints& w) {
  const Vec3 between = b.point - a.point, across = a.axis.cross(b.axis);
  const double det = across.squaredNorm();
  if (!(det > tolerance::crossing2)) return false;
  const double s = between.cross(b.axis).dot(across) / det, t = between.cross(a.axis).dot(across) / det;
  w.n = n;
  w.a = a.point + std::clamp(s, a.low, a.high) * a.axis + a.radius * n;
  w.b = b.point + std::clamp(t, b.low, b.high) * b.axis - b.radius * n;
  return within(a, s, rounding) && within(b, t, rounding);
}

/// Two lines, or lines of cones' sides: their common normal is on a circle about each axis, and points from a to b.
bool straight_to_straight(const Feature& a, const Feature& b, double rounding, NearestPoints& w) {
  const Vec3 across = a.axis.cross(b.axis);
  const double det = across.squaredNorm();
  if (!(det > tolerance::crossing2)) return false;
  if (a.surface == Surface::straight && b.surface == Surface::straight) {
    const Vec3 n = std::copysign(1 / std::sqrt(det), across.dot(w.n)) * across;
    return line_to_line(a, b, n, rounding, w);
  }
  const double d = a.axis.dot(b.axis), p = a.sine, q = -b.sine;
  const double x = (p - d * q) / det, y = (q - d * p) / det, rest = 1 - x * p - y * q;
  if (!(rest > 0)) {
    // One of them ends before: b's cone, if it is one.
    const bool in_b = b.surface == Surface::side;
    const Feature& side = in_b ? b : a;
    const Vec3 p = in_b ? w.b : w.a, from = p - side.point;
    const Vec3 down = from.dot(side.axis) < 0 ? unit(from) : Vec3(-side.axis);
    const double slope = down.dot(in_b ? w.n : Vec3(-w.n));
    w.a = w.b = side.point + (slope < 0 ? side.high : 0.0) * down;
    return false;
  }
  const Vec3 n = x * a.axis + y * b.axis + std::copysign(std::sqrt(rest / det), across.dot(w.n)) * across;
  const Feature in_a = a.surface == Surface::side ? generator(a, n) : a;
  const Feature in_b = b.surface == Surface::side ? generator(b, -n) : b;
  return line_to_line(in_a, in_b, n, rounding, w);
}

/// From a circle to a line, or to a cone's side.
bool circle_to_line(Feature circle, const Feature& line, double rounding, NearestPoints& w) {
  const bool side = line.surface == Surface::side;
  const Vec3 from = circle.point - line.point;
  const double r = circle.radius, ue = circle.u.dot(line.axis), ve = circle.v.dot(line.axis), up = from.dot(line.axis);
  const double a = from.dot(circle.u) - up * ue, b = from.dot(circle.v) - up * ve;
  const double uu = 1 - ue * ue, uv = -ue * ve, vv = 1 - ve * ve, off2 = from.squaredNorm() - up * up;
  double &c = circle.c, &s = circle.s;
  bool found = false;
  for (int step = 0; step < newton_steps && !found; ++step) {
    // Half the squared distance from the line, by the angle.
    const double x = a + r * (c * uu + s * uv), y = b + r * (c * uv + s * vv);
    double first = r * (c * y - s * x), second = r * (r * (s * s * uu - 2 * s * c * uv + c * c * vv) - c * x - s * y);
    if (side) {
      const double rho2 = off2 + 2 * r * (c * a + s * b) + r * r * (c * c * uu + 2 * c * s * uv + s * s * vv);
      if (!(rho2 > 0)) return false;
      const double k = line.cosine / std::sqrt(rho2);
      second = k * (second - first * first / rho2) - line.sine * r * (c * ue + s * ve);
      first = k * first + line.sine * r * (c * ve - s * ue);
    }
    if (!(second > 0)) return false;
    const double angle = std::clamp(-first / second, -0.7, 0.7);
    turn(c, s, angle);
    found = std::abs(angle) < newton_end;
  }
  w.a = circle.point + r * (c * circle.u + s * circle.v);
  const Vec3 on = w.a - line.point;
  Feature straight = line;
  Vec3 out = on - on.dot(line.axis) * line.axis;
  if (side) {
    out = line.cosine * unit(out) + line.sine * line.axis;
    straight = generator(line, out);
  } else {
    // Square to both: where they nearly touch, their difference is noise.
    const Vec3 across = line.axis.cross(c * circle.v - s * circle.u);
    out = unit_along(across.squaredNorm() > tolerance::square_lines2 ? across : out, -w.n);
  }
  const double t = on.dot(straight.axis);
  w.b = straight.point + std::clamp(t, straight.low, straight.high) * straight.axis + (side ? 0 : line.radius) * out;
  w.n = -out;
  return found && within(straight, t, rounding);
}

bool circle_to_circle(Feature a, Feature b, NearestPoints& w) {
  const Vec3 between = a.point - b.point;
  bool found = false;
  for (int step = 0; step < newton_steps && !found; ++step) {
    const Vec3 out_a = a.c * a.u + a.s * a.v, out_b = b.c * b.u + b.s * b.v;
    const Vec3 along_a = a.c * a.v - a.s * a.u, along_b = b.c * b.v - b.s * b.u;
    const Vec3 d = between + a.radius * out_a - b.radius * out_b;
    // Of half the squared distance, over both radii.
    const double ga = along_a.dot(d), gb = -along_b.dot(d);
    const double aa = a.radius - out_a.dot(d), bb = b.radius + out_b.dot(d), ab = -along_a.dot(along_b);
    const double det = aa * bb - a.radius * b.radius * ab * ab;
    if (!(det > 0 && aa > 0)) return false;
    const double turn_a = std::clamp(-(bb * ga - b.radius * ab * gb) / det, -0.7, 0.7);
    const double turn_b = std::clamp(-(aa * gb - a.radius * ab * ga) / det, -0.7, 0.7);
    turn(a.c, a.s, turn_a);
    turn(b.c, b.s, turn_b);
    found = std::abs(turn_a) < newton_end && std::abs(turn_b) < newton_end;
  }
  w.a = a.point + a.radius * (a.c * a.u + a.s * a.v), w.b = b.point + b.radius * (b.c * b.u + b.s * b.v);
  const Vec3 across = (a.c * a.v - a.s * a.u).cross(b.c * b.v - b.s * b.u);
  w.n = unit_along(across.squaredNorm() > tolerance::square_lines2 ? across : Vec3(w.b - w.a), w.n);
  return found;
}

/// From a face to what of the other body is farthest back along its normal.
bool face_to_body(const FeatureBody& body, const Feature& flat, const FeatureBody& other, double rounding,
                  NearestPoints& w) {
  w.n = flat.axis;
  w.b = other.support(-w.n);
  w.a = w.b - (w.b - flat.point).dot(w.n) * w.n;
  const Vec3 q = body.in(w.a);
  if (body.core.kind == ShapeKind::convex) {
    const Vec3 end = end_on_face(*body.core.hull, flat.face, body.in(flat.point), q, rounding);
    w.a = body.out(end);
    return end == q;
  }
  Vec3 moved = q;
  move_into(body.core, moved, 0);
  w.a = body.out(moved);
  return (moved - q).squaredNorm() <= rounding * rounding;
}

/// The nearest points of two features; w.n tells about where to. False where it leaves them.
bool nearest_points(const FeatureBody& a, const Feature& fa, const FeatureBody& b, const Feature& fb, double rounding,
                    NearestPoints& w) {
  const auto swapped = [&w](auto&& find) {
    std::swap(w.a, w.b);
    w.n = -w.n;
    const bool found = find();
    std::swap(w.a, w.b);
    w.n = -w.n;
    return found;
  };
  if (fa.surface == Surface::flat) return face_to_body(a, fa, b, rounding, w);
  if (fb.surface == Surface::flat) return swapped([&] { return face_to_body(b, fb, a, rounding, w); });
  if (fa.surface == Surface::corner) return corner_to_feature(fa.point, fb, rounding, w);
  if (fb.surface == Surface::corner) return swapped([&] { return corner_to_feature(fb.point, fa, rounding, w); });
  if (fa.surface == Surface::circle)
    return fb.surface == Surface::circle ? circle_to_circle(fa, fb, w) : circle_to_line(fa, fb, rounding, w);
  if (fb.surface == Surface::circle) return swapped([&] { return circle_to_line(fb, fa, rounding, w); });
  return straight_to_straight(fa, fb, rounding, w);
}

bool is_hull(const ConvexView& v) { return v.kind == ShapeKind::convex; }

/// The search for the features that meet: nearest points of both bodies held apart, and from the features that they lie
/// on the nearest points and the normal of these.
class FeatureSearch {
 public:
  FeatureSearch(const MinkowskiDifference& d, double below)
      : d_(d),
        below_(below),
        rounding_(16 * epsilon * rounding_scale(d)),
        a_{d.a, nullptr, Vec3::Zero()},
        b_{d.b, &d.pose.rotation, d.pose.translation} {}

  /// `common`: as of search_features.
  Support run(bool* common);

 private:
  void begin();
  bool separated_by_projection(bool& common);
  bool bring_near(int round, bool near, const Vec3& shift);
  bool meet(const Vec3& shift);
  bool accept(const NearestPoints& points);

  double reach(const Vec3& n) const { return a_.reach(n) + b_.reach(-n) - n.dot(d_.pose.translation); }
  void to_a(NearestPoints& points) { points.a = points.b, spot_a_ = project(a_, points.a, rounding_, &spot_a_); }
  void to_b(NearestPoints& points) { points.b = points.a, spot_b_ = project(b_, points.b, rounding_, &spot_b_); }
  bool lost() const { return spot_a_.surface == Surface::none || spot_b_.surface == Surface::none; }

  const MinkowskiDifference& d_;
  const double below_, rounding_;
  const FeatureBody a_;
  FeatureBody b_;
  Spot spot_a_, spot_b_;
  NearestPoints w_;
  bool apart_ = false;
  Support found_;
};

Support FeatureSearch::run(bool* common) {
  begin();
  if (common != nullptr && (*common = spot_a_.inside || spot_b_.inside)) return found_;
  const double clear = clearance * std::min(d_.a.size, d_.b.size);
  for (int round = 0; round < rounds; ++round) {
    const double h = reach(w_.n);
    if (round == 0 || h < found_.h) found_.n = w_.n, found_.h = h;
    if (h < below_) return found_;
    if (round == 0 && common != nullptr && apart_ && separated_by_projection(*common)) return found_;
    const Vec3 shift = std::max(0.0, h + clear) * w_.n;
    if (!bring_near(round, h > -clear, shift) || meet(shift)) return found_;
  }
  return found_;
}

/// The point of A nearest to B's centre, the point of B nearest to that, and the direction between.
void FeatureSearch::begin() {
  const Vec3 centre_b = b_.out(core_centre(d_.b));
  w_.a = centre_b;
  const Vec3 between = w_.a - core_centre(d_.a);
  spot_a_ = project(a_, w_.a, rounding_);
  w_.b = w_.a;
  spot_b_ = project(b_, w_.b, rounding_);
  apart_ = !lost();
  w_.n = apart_ ? w_.b - w_.a : spot_a_.surface != Surface::none ? centre_b - w_.a : between;
  w_.n = unit_or(w_.n, found_.n);
}

/// One projection more separates nearly all that are well apart. True: the answer is there.
bool FeatureSearch::separated_by_projection(bool& common) {
  Vec3 p = w_.b;
  common = project(a_, p, rounding_).inside;
  if (common) return true;
  const Vec3 n = unit_or(w_.b - p, w_.n);
  const double closer = reach(n);
  if (!(closer < below_)) return false;
  found_.n = n, found_.h = closer;
  return true;
}

/// Nearest points of the bodies while B stands off by `shift`, and the normal between them. False: one is inside.
bool FeatureSearch::bring_near(int round, bool near, const Vec3& shift) {
  b_.centre = d_.pose.translation + shift;
  w_.b += shift;
  to_a(w_);
  // A hull's features are small: guesses had better be closer.
  if ((is_hull(d_.a) || is_hull(d_.b)) && (round > 0 || near)) to_b(w_), to_a(w_);
  if (spot_a_.surface == Surface::corner) to_b(w_);
  if (lost()) return false;
  w_.n = unit_or(w_.b - w_.a, w_.n);
  b_.centre = d_.pose.translation;
  w_.b -= shift;
  return true;
}

/// The nearest points of the features that the points lie on; where a feature ends before, to and fro from its end.
bool FeatureSearch::meet(const Vec3& shift) {
  const bool from_a = d_.a.kind == ShapeKind::box || (is_hull(d_.a) && !is_hull(d_.b));
  NearestPoints points = w_;
  for (int turn = 0; turn < turns; ++turn) {
    points.n = w_.n;
    const bool between =
        nearest_points(a_, feature(a_, spot_a_, rounding_), b_, feature(b_, spot_b_, rounding_), rounding_, points);
    if (turn == 0) w_.b = points.b;
    const double length = points.n.norm();
    if (between && length > 0.5 && length < 2) {
      points.n /= length;
      return accept(points);
    }
    b_.centre += shift;
    points.b += shift;
    if (from_a) {
      to_b(points), to_a(points);
    } else {
      to_a(points), to_b(points);
    }
    b_.centre = d_.pose.translation;
    points.b -= shift;
    if (lost()) return false;
  }
  return false;
}

/// Are these the nearest points of the bodies? They are if the bodies reach no farther along the normal.
bool FeatureSearch::accept(const NearestPoints& points) {
  const double reached = reach(points.n);
  const Vec3 off = points.a - points.b - reached * points.n;
  if (!(off.squaredNorm() <= rounding_ * rounding_)) return false;
  found_.n = points.n, found_.h = reached;
  found_.point[0] = points.a, found_.point[1] = -points.b;
  found_.optimal = true;
  return true;
}

}  // namespace

bool have_features(const ConvexView& a, const ConvexView& b) {
  const auto has = [](const ConvexView& v) {
    return v.kind == ShapeKind::box || v.kind == ShapeKind::capsule || v.kind == ShapeKind::cylinder ||
           v.kind == ShapeKind::cone || (v.kind == ShapeKind::convex && has_rings(*v.hull));
  };
  return has(a) && has(b);
}

Support search_features(const MinkowskiDifference& d, double below, bool* common) {
  return FeatureSearch(d, below).run(common);
}

}  // namespace tandem
