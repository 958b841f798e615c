#include "round/feature_search.h"

#include <limits>

#include "round/feature_points.h"
#include "round/hull_projection.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int rounds = 4;
constexpr int turns = 4;           ///< of features a round
constexpr double clearance = 0.1;  ///< of the smaller size

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
  if (fa.surface == Surface::flat) return face_to_body(a, fa, b, rounding, w);
  if (fb.surface == Surface::flat) return w.exchanged([&] { return face_to_body(b, fb, a, rounding, w); });
  return nearest_points(fa, fb, rounding, w);
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
