// Makes test pairs by kind and class of relative pose.
#include "pair_classes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "random.h"
#include "reference.h"
#include "shapes/shape_insides.h"

namespace tandem::reference {
namespace {

struct Row {
  std::string_view name;
  std::array<ShapeRecipe, 2> recipes;
};

// In the order of PairKind.
constexpr std::array<Row, pair_kinds> rows = {{
    {"sphere-sphere", {{{ShapeKind::sphere}, {ShapeKind::sphere}}}},
    {"sphere-box", {{{ShapeKind::sphere}, {ShapeKind::box}}}},
    {"sphere-capsule", {{{ShapeKind::sphere}, {ShapeKind::capsule}}}},
    {"capsule-capsule", {{{ShapeKind::capsule}, {ShapeKind::capsule}}}},
    {"box-box", {{{ShapeKind::box}, {ShapeKind::box}}}},
    {"capsule-box", {{{ShapeKind::capsule}, {ShapeKind::box}}}},
    {"halfspace-box", {{{ShapeKind::halfspace}, {ShapeKind::box}}}},
    {"cylinder-cylinder", {{{ShapeKind::cylinder}, {ShapeKind::cylinder}}}},
    {"box-cylinder", {{{ShapeKind::box}, {ShapeKind::cylinder}}}},
    {"cone-cone", {{{ShapeKind::cone}, {ShapeKind::cone}}}},
    {"box-cone", {{{ShapeKind::box}, {ShapeKind::cone}}}},
    {"cylinder-cone", {{{ShapeKind::cylinder}, {ShapeKind::cone}}}},
    {"ellipsoid-ellipsoid", {{{ShapeKind::ellipsoid}, {ShapeKind::ellipsoid}}}},
    {"box-ellipsoid", {{{ShapeKind::box}, {ShapeKind::ellipsoid}}}},
    {"hull32-hull32", {{{ShapeKind::convex, 32}, {ShapeKind::convex, 32}}}},
    {"hull256-hull256", {{{ShapeKind::convex, 256}, {ShapeKind::convex, 256}}}},
    {"hull32-box", {{{ShapeKind::convex, 32}, {ShapeKind::box}}}},
    {"hull32-cylinder", {{{ShapeKind::convex, 32}, {ShapeKind::cylinder}}}},
    {"triangle-box", {{{ShapeKind::triangle}, {ShapeKind::box}}}},
    {"triangle-triangle", {{{ShapeKind::triangle}, {ShapeKind::triangle}}}},
}};

/// The scaling of a shape along its axes; round shapes take the first for their radius and the last for their length.
struct Stretch {
  double x = 1, y = 1, z = 1;
};

Shape make_shape(const ShapeRecipe& recipe, Random& r, const Stretch& s) {
  switch (recipe.kind) {
    case ShapeKind::sphere:
      return Shape(Sphere{r.in(0.2, 0.8) * s.x});
    case ShapeKind::box: {
      const Vec3 size = r.vec(0.4, 1.5);
      return Shape(Box{{size.x() * s.x, size.y() * s.y, size.z() * s.z}});
    }
    case ShapeKind::capsule: {
      const double radius = r.in(0.1, 0.5) * s.x;
      return Shape(Capsule{radius, r.in(0.1, 1.5) * s.z});
    }
    case ShapeKind::cylinder: {
      const double radius = r.in(0.2, 0.8) * s.x;
      return Shape(Cylinder{radius, r.in(0.3, 1.5) * s.z});
    }
    case ShapeKind::cone: {
      const double radius = r.in(0.2, 0.8) * s.x;
      return Shape(Cone{radius, r.in(0.3, 1.5) * s.z});
    }
    case ShapeKind::ellipsoid: {
      const Vec3 radii = r.vec(0.2, 0.9);
      return Shape(Ellipsoid{{radii.x() * s.x, radii.y() * s.y, radii.z() * s.z}});
    }
    case ShapeKind::halfspace: {
      const Vec3 n = r.direction();
      return Shape(HalfSpace{n, r.in(-0.5, 0.5)});
    }
    case ShapeKind::convex: {
      Convex hull;
      const int points = recipe.points > 0 ? recipe.points : 4 + r.below(29);
      const Vec3 radii = r.vec(0.5, 0.9);
      for (int i = 0; i < points; ++i) {
        const Vec3 d = r.direction();
        hull.vertices.push_back({d.x() * radii.x() * s.x, d.y() * radii.y() * s.y, d.z() * radii.z() * s.z});
      }
      return Shape(hull);
    }
    default: {
      const auto corner = [&] {
        const Vec3 p = r.vec(-0.8, 0.8);
        return Vec3{p.x() * s.x, p.y() * s.y, p.z() * s.z};
      };
      const Vec3 p = corner(), q = corner();
      return Shape(Triangle{{p, q, corner()}});
    }
  }
}

double extent(const Shape& s) { return s.is_bounded() ? s.size() : 0.0; }

double smaller_size(const PosedPair& p) {
  const double a = extent(p.a), b = extent(p.b);
  const double least = std::min(a > 0 ? a : b, b > 0 ? b : a);
  return least > 0 ? least : 1.0;
}

/// An interior point, in the shape's frame.
Vec3 middle(const Shape& s) {
  switch (s.kind()) {
    case ShapeKind::halfspace:
      return (s.offset() - 0.2) * s.normal();
    case ShapeKind::cone:
      return {0, 0, -0.25 * s.length()};
    case ShapeKind::convex:
    case ShapeKind::triangle:
      return hull_of(s).inside;
    default:
      return Vec3::Zero();
  }
}

/// Moves B from far along `away` towards A until the distance is `gap` > 0, so that generic features meet, not corners.
void approach(PosedPair& p, Vec3 away, double gap) {
  if (!p.a.is_bounded() || !p.b.is_bounded()) {
    const Vec3 up =
        p.a.is_bounded() ? Vec3(-(p.pose_b.rotation * p.b.normal())) : Vec3(p.pose_a.rotation * p.a.normal());
    if (away.dot(up) < 0) away = -away;
    if (away.dot(up) < 0.3) away = up;
  }
  const Vec3 start = p.pose_b.translation;
  double s = 2 * (size(p) + (start - p.pose_a.translation).norm());
  for (int i = 0; i < 40; ++i) {
    p.pose_b.translation = start + s * away;
    const Truth t = signed_distance(p.a, p.pose_a, p.b, p.pose_b);
    const double left = t.signed_distance - gap, rate = t.normal.dot(away);
    // Moves straight to the gap once the feature is known, except along a grazing line.
    if (left <= 1e-3 * gap || rate < 1e-3 || i == 39) {
      p.pose_b.translation -= left * t.normal;
      return;
    }
    s -= left / rate;
  }
}

/// Moves B along the direction of approach until the signed distance is `gap`.
void place(PosedPair& p, const Vec3& away, double gap) {
  const double clear = std::max(gap, 1e-3 * smaller_size(p));
  approach(p, away, clear);
  if (gap >= clear) return;
  const Truth t = signed_distance(p.a, p.pose_a, p.b, p.pose_b);
  p.pose_b.translation -= (t.signed_distance - gap) * t.normal;
}

// Random draws are separate statements, or in braces, since the order of evaluating operands is up to the compiler.

double near_gap(Random& r, double unit) {
  const double sign = r.sign();
  return sign * std::min(r.power_of_two(-40, -9), 1e-3) * unit;
}
double shallow_gap(Random& r, double unit) { return -std::min(r.power_of_two(-20, -6), 1e-2) * unit; }

void place_as(PairClass pair_class, PosedPair& p, Random& r, const Vec3& away) {
  const double unit = smaller_size(p);
  switch (pair_class) {
    case PairClass::separated:
      return place(p, away, 0.1 * unit);
    case PairClass::near:
      return place(p, away, near_gap(r, unit));
    case PairClass::shallow:
      return place(p, away, shallow_gap(r, unit));
    default:
      p.pose_b.translation = p.pose_a * middle(p.a) - p.pose_b.rotation * middle(p.b);
      if (!r.once_in(8)) {
        const Vec3 direction = r.direction();
        p.pose_b.translation += r.in(0, 0.08) * unit * direction;
      }
  }
}

Mat3 quarter_turn(Random& r) {
  Mat3 m = Mat3::Identity();
  for (int turns = r.below(4); turns > 0; --turns) m = (Mat3() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished() * m;
  for (int turns = r.below(3); turns > 0; --turns) m = (Mat3() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished() * m;
  return m;
}

Mat3 turn_about(int axis, Random& r) {
  double c, s, n;
  do {
    c = r.in(-1, 1), s = r.in(-1, 1);
    n = std::sqrt(c * c + s * s);
  } while (n < 0.1 || n > 1);
  c /= n, s /= n;
  Mat3 m = Mat3::Identity();
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  m(i, i) = c, m(j, j) = c, m(i, j) = -s, m(j, i) = s;
  return m;
}

Mat3 slight_turn(Random& r) {
  const double half_angle = r.power_of_two(-41, -13);
  const Vec3 axis = half_angle * r.direction();
  return Quat(1, axis.x(), axis.y(), axis.z()).normalized().toRotationMatrix();
}

/// A direction along an axis of A, so that parallel faces meet.
Vec3 face_direction(const PosedPair& p, Random& r) {
  const double sign = r.sign();
  return sign * p.pose_a.rotation.col(r.below(3));
}

PairClass any_class(Random& r) { return all_pair_classes[static_cast<std::size_t>(r.below(4))]; }

/// Two shapes by recipe, scaled, not yet placed.
struct ShapePair {
  const ShapeRecipe &ra, &rb;
  Random& r;

  PosedPair operator()(const Stretch& sa, const Stretch& sb) const {
    Shape a = make_shape(ra, r, sa);
    Shape b = make_shape(rb, r, sb);
    return {a, {}, b, {}};
  }
};

/// The hard pairs 0 to 3, 10 and 11: faces and axes that are parallel, exactly to rounding or nearly.
PosedPair parallel_pair(const ShapePair& pair, std::uint64_t which, Random& r) {
  PosedPair p = pair({}, {});
  switch (which) {
    case 0: {  // axes along the world's
      p.pose_b.translation = 0.2 * r.vec(-1, 1);
      place_as(any_class(r), p, r, face_direction(p, r));
      return p;
    }
    case 1: {  // the same rotation
      p.pose_a.rotation = p.pose_b.rotation = r.rotation();
      p.pose_b.translation = 0.2 * r.vec(-1, 1);
      place_as(any_class(r), p, r, face_direction(p, r));
      return p;
    }
    case 2: {  // one common axis
      p.pose_a.rotation = r.once_in(2) ? r.rotation() : Mat3::Identity();
      p.pose_b.rotation = p.pose_a.rotation * turn_about(r.below(3), r);
      place_as(any_class(r), p, r, face_direction(p, r));
      return p;
    }
    case 3: {  // the same pose, and the same shape where possible
      if (pair.ra.kind == pair.rb.kind && pair.ra.points == pair.rb.points) p.b = p.a;
      p.pose_a = {r.once_in(2) ? r.rotation() : Mat3::Identity(), r.vec(-1, 1)};
      p.pose_b = p.pose_a;
      return p;
    }
    case 10: {  // quarter turns
      p.pose_a.rotation = quarter_turn(r), p.pose_b.rotation = quarter_turn(r);
      if (r.once_in(2)) p.pose_b.translation = 0.2 * r.vec(-1, 1);
      place_as(any_class(r), p, r, face_direction(p, r));
      return p;
    }
    default: {  // almost parallel
      p.pose_a.rotation = r.once_in(2) ? r.rotation() : Mat3::Identity();
      p.pose_b.rotation = slight_turn(r) * p.pose_a.rotation;
      p.pose_b.translation = 0.2 * r.vec(-1, 1);
      place_as(any_class(r), p, r, face_direction(p, r));
      return p;
    }
  }
}

PosedPair hard_pair(const ShapeRecipe& ra, const ShapeRecipe& rb, std::uint64_t index, Random& r) {
  const ShapePair pair{ra, rb, r};
  const auto scaled = [](double s) { return Stretch{s, s, s}; };
  const Stretch needle{1e-4, 1e-4, 1}, plate{1, 1, 1e-4};
  switch (index % 12) {
    case 4:
    case 5: {  // size ratio 1e4
      PosedPair p = index % 12 == 4 ? pair(scaled(100), scaled(0.01)) : pair(scaled(0.01), scaled(100));
      p.pose_a.rotation = r.rotation(), p.pose_b.rotation = r.rotation();
      place_as(any_class(r), p, r, r.direction());
      return p;
    }
    case 6: {  // far from the world's origin
      PosedPair p = pair({}, {});
      const double far = r.in(1e5, 1e6);
      p.pose_a = {r.rotation(), far * r.direction()};
      p.pose_b = {r.rotation(), p.pose_a.translation};
      place_as(any_class(r), p, r, r.direction());
      return p;
    }
    case 7:
    case 8:
    case 9: {  // needles, plates, one of each
      PosedPair p = pair(index % 12 == 7 ? needle : plate, index % 12 == 8 ? plate : needle);
      p.pose_a.rotation = r.rotation();
      p.pose_b.rotation = r.once_in(4) ? p.pose_a.rotation : r.rotation();
      if (r.once_in(2)) p.pose_b.translation = 0.3 * r.vec(-1, 1);
      place_as(any_class(r), p, r, r.direction());
      return p;
    }
    default:
      return parallel_pair(pair, index % 12, r);
  }
}

}  // namespace

std::string_view name(PairClass c) {
  constexpr std::array<std::string_view, all_pair_classes.size()> names = {"separated", "near", "shallow", "deep",
                                                                           "hard"};
  return names[static_cast<std::size_t>(c)];
}

std::string_view name(PairKind kind) { return rows[static_cast<std::size_t>(kind)].name; }
std::array<ShapeRecipe, 2> recipes(PairKind kind) { return rows[static_cast<std::size_t>(kind)].recipes; }

double size(const PosedPair& p) {
  const double larger = std::max(extent(p.a), extent(p.b));
  return larger > 0 ? larger : 1.0;
}

PosedPair make_pair(const ShapeRecipe& ra, const ShapeRecipe& rb, PairClass pair_class, std::uint64_t index) {
  const auto is_convex = [](ShapeKind kind) { return kind != ShapeKind::mesh && kind != ShapeKind::voxels; };
  if (!is_convex(ra.kind) || !is_convex(rb.kind) ||
      (ra.kind == ShapeKind::halfspace && rb.kind == ShapeKind::halfspace))
    throw std::invalid_argument("make_pair: the kinds must be convex and one of them bounded");
  std::uint64_t seed = index;
  for (const auto part :
       {static_cast<std::uint64_t>(ra.kind), static_cast<std::uint64_t>(ra.points), static_cast<std::uint64_t>(rb.kind),
        static_cast<std::uint64_t>(rb.points), static_cast<std::uint64_t>(pair_class)})
    seed = Random(seed * 1024 + part).bits();
  Random r(seed);
  if (pair_class == PairClass::hard) return hard_pair(ra, rb, index, r);
  Shape a = make_shape(ra, r, {});
  Shape b = make_shape(rb, r, {});
  PosedPair p{a, {r.rotation(), r.vec(-1, 1)}, b, {}};
  p.pose_b = {r.rotation(), p.pose_a.translation + 0.2 * r.vec(-1, 1)};
  place_as(pair_class, p, r, r.direction());
  return p;
}

PosedPair make_pair(PairKind kind, PairClass pair_class, std::uint64_t index) {
  const auto [a, b] = recipes(kind);
  return make_pair(a, b, pair_class, index);
}

}  // namespace tandem::reference
