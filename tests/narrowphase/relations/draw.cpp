// Random pairs for the relations: shapes of all kinds, degenerate ones, and their poses.
#include "draw.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh_samples.h"
#include "settle.h"
#include "shapes/hull.h"
#include "shapes/shape_insides.h"
#include "slivers.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "unusual.h"

namespace tandem::relations {
namespace {

// Functions that draw several numbers draw each in a statement of its own: the order of evaluation within an expression
// differs between compilers and processors, and a seed must give the same pair on all.

/// Numbers of few bits, so that midpoints and sums are exact.
double rounded(double x) { return std::round(x * 0x1p20) * 0x1p-20; }
Vec3 rounded(const Vec3& v) { return {rounded(v.x()), rounded(v.y()), rounded(v.z())}; }

/// The style of a shape: plump, thin and flat, or with coordinates that are multiples of an eighth.
enum class Build { plump, degenerate, dyadic };

double length(Random& r, Build build) {
  if (build == Build::dyadic) return (1 + r.below(16)) / 8.0;
  const double plump = r.in(0.1, 1.5);
  return plump * (build == Build::degenerate && r.once_in(2) ? small(r, 8) : 1.0);
}

Vec3 lengths(Random& r, Build build) {
  const double x = length(r, build), y = length(r, build);
  return {x, y, length(r, build)};
}

Vec3 point(Random& r, Build build) {
  if (build == Build::dyadic) {
    const int z = r.below(17) - 8, y = r.below(17) - 8, x = r.below(17) - 8;
    return Vec3(x, y, z) / 8.0;
  }
  return rounded(r.vec(-1, 1));
}

/// A point of the line through p and q, displaced by `off` in a random direction.
template <class Off>
Vec3 near_line(Random& r, const Vec3& p, const Vec3& q, Off&& off) {
  const Vec3 aside = r.direction();
  const Vec3 by = off() * aside;
  return p + r.in(-0.5, 1.5) * (q - p) + by;
}

/// A third point that forms a triangle without area, a sliver, or any triangle.
std::array<Vec3, 3> corners(Random& r, Build build) {
  const Vec3 p = point(r, build), q = point(r, build);
  if (build != Build::degenerate) return {p, q, point(r, build)};
  switch (r.below(4)) {
    case 0:
      return {p, q, (p + q) / 2};  // three collinear points, exactly: the sum is
    case 1:
      return {p, q, r.once_in(2) ? p : q};
    case 2:
      return {p, q, near_line(r, p, q, [&] { return small(r, 16); })};
    default:
      return {p, q, point(r, build)};
  }
}

/// Three corners, collinear up to 1e-16 to 1e-5 of their length, or a long cloud, thin to 1e-8.
ShapeData needle(Random& r) {
  if (r.once_in(2)) {
    const Vec3 p = point(r, Build::degenerate), q = point(r, Build::degenerate);
    return Triangle{{p, q, near_line(r, p, q, [&] { return small(r, 5, 16); })}};
  }
  Convex c;
  const double broad = r.once_in(3) ? 1 : small(r, 4, 8);
  const Vec3 stretch(small(r, 4, 8), broad, 1);
  for (int n = 3 + r.below(12); n > 0; --n) c.vertices.push_back(point(r, Build::degenerate).cwiseProduct(stretch));
  return c;
}

Convex cloud(Random& r, Build build) {
  Convex c;
  const int n = 1 + r.below(r.once_in(4) ? 60 : 12);
  Vec3 stretch(1, 1, 1);
  if (build == Build::degenerate) {
    stretch.y() = r.once_in(3) ? small(r, 8) : 1;
    stretch.x() = r.once_in(2) ? small(r, 8) : 1;
  }
  for (int i = 0; i < n; ++i) c.vertices.push_back(point(r, build).cwiseProduct(stretch));
  if (build == Build::degenerate && r.once_in(2)) c.vertices.push_back(c.vertices[0]);
  return c;
}

Mesh l_prism(Random& r) {
  const double arm = r.in(0.2, 1.5);
  return test::prism({{0, 0}, {2, 0}, {2, arm}, {arm, arm}, {arm, 2}, {0, 2}},
                     {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, r.in(0.3, 1.5));
}

Mesh u_prism(Random& r) {
  const double arm = r.in(0.2, 0.9), floor = r.in(0.2, 1.2);
  return test::prism({{0, 0}, {2, 0}, {2, 2}, {2 - arm, 2}, {2 - arm, floor}, {arm, floor}, {arm, 2}, {0, 2}},
                     {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}}, r.in(0.3, 1.5));
}

/// An open sheet of n x n squares with random heights, each divided into two triangles.
Mesh bumpy_grid(Random& r, Build build) {
  Mesh m;
  const int n = 1 + r.below(5);
  const double bump = build == Build::dyadic ? 0 : r.once_in(4) ? small(r, 12) : 0.3;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      m.vertices.push_back(rounded(Vec3(2.0 * i / n - 1, 2.0 * j / n - 1, bump * r.in(-1, 1))));
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return m;
}

Mesh soup(Random& r, Build build) {
  Mesh m;
  const int n = 1 + r.below(6);
  for (int i = 0; i < n; ++i) {
    const auto first = static_cast<std::uint32_t>(m.vertices.size());
    for (const Vec3& p : corners(r, build)) m.vertices.push_back(p);
    m.triangles.push_back({first, first + 1, first + 2});
    if (build == Build::degenerate && r.once_in(6)) m.triangles.push_back({first, first + 2, first + 1});
  }
  return m;
}

Mesh hull_mesh(Random& r) {
  const Shape s(cloud(r, Build::plump));
  const Hull& h = hull_of(s);
  if (h.dimension < 3) return test::box_mesh({1, 1, 1});
  Mesh m;
  m.solid = true;
  m.vertices = h.vertices;
  for (const Hull::Face& f : h.faces)
    for (std::uint32_t k = 1; k + 1 < f.count; ++k)
      m.triangles.push_back({h.loop[f.first], h.loop[f.first + k], h.loop[f.first + k + 1]});
  return m;
}

Mesh draw_mesh(Random& r, Build build, const std::vector<NamedMesh>& real) {
  Mesh m;
  switch (r.below(real.empty() ? 8 : 16)) {  // half of them real
    case 0:
      m = soup(r, build);
      break;
    case 1:
      m = bumpy_grid(r, build);
      break;
    case 2: {
      const int cuts = 1 + r.below(3);
      m = test::box_mesh(lengths(r, build), cuts);
      break;
    }
    case 3:
      m = l_prism(r);
      break;
    case 4:
      m = u_prism(r);
      break;
    case 5: {
      const int sides = 4 + r.below(5), segments = 5 + r.below(8);
      m = test::torus(1, r.in(0.15, 0.6), segments, sides);
      break;
    }
    case 6:
      m = hull_mesh(r);
      break;
    case 7: {
      const auto p = corners(r, build);
      m.vertices.assign(p.begin(), p.end());
      m.triangles = {{0, 1, 2}};
      break;
    }
    default:
      m = real[static_cast<std::size_t>(r.below(static_cast<int>(real.size())))].mesh;
  }
  if (m.solid && r.once_in(3)) m.solid = false;
  if (build != Build::dyadic)
    for (Vec3& v : m.vertices) v = rounded(v);
  return m;
}

/// A few dozen cells about the origin, some of them larger.
Voxels cells(Random& r, Build build) {
  const bool exact = build == Build::dyadic;
  Voxels v;
  v.cell_size = exact ? 0.125 : rounded(r.in(0.05, 0.3));
  v.origin = exact ? point(r, build) : rounded(r.vec(-0.5, 0.5));
  for (int i = 1 + r.below(40); i > 0; --i) {
    const auto level = static_cast<std::uint8_t>(r.once_in(4) ? 1 + r.below(2) : 0);
    const auto place = [&] { return (r.below(10) - 5) >> level << level; };
    const std::int32_t x = place(), y = place();
    v.cells.push_back({{x, y, place()}, level});
  }
  return v;
}

ShapeData draw_shape(ShapeKind kind, Random& r, Build build, const std::vector<NamedMesh>& real) {
  switch (kind) {
    case ShapeKind::sphere:
      return Sphere{r.once_in(8) ? 0.0 : length(r, build)};
    case ShapeKind::box:
      return Box{lengths(r, build)};
    case ShapeKind::capsule: {
      const double radius = length(r, build);
      return Capsule{radius, r.once_in(16) ? 0.0 : length(r, build)};
    }
    case ShapeKind::cylinder: {
      const double radius = length(r, build);
      return Cylinder{radius, length(r, build)};
    }
    case ShapeKind::cone: {
      const double radius = length(r, build);
      return Cone{radius, length(r, build)};
    }
    case ShapeKind::ellipsoid:
      return Ellipsoid{r.once_in(8) ? Vec3(Vec3::Constant(length(r, build))) : lengths(r, build)};
    case ShapeKind::halfspace:
      return HalfSpace{build == Build::dyadic ? Vec3(Vec3::Unit(r.below(3))) : r.direction(),
                       build == Build::dyadic ? r.below(9) / 8.0 : r.in(-0.5, 0.5)};
    case ShapeKind::plane:
      return Plane{build == Build::dyadic ? Vec3(Vec3::Unit(r.below(3))) : r.direction(),
                   build == Build::dyadic ? r.below(9) / 8.0 : r.in(-0.5, 0.5)};
    case ShapeKind::voxels:
      return cells(r, build);
    case ShapeKind::convex:
      return cloud(r, build);
    case ShapeKind::triangle:
      return Triangle{corners(r, build)};
    default:
      return draw_mesh(r, build, real);
  }
}

Mat3 rotation(Random& r, Build build) {
  if (build == Build::dyadic || r.once_in(8)) return exact_rotation(r);
  if (r.once_in(8)) {
    // Nearly an exact one.
    const Vec3 axis = r.direction();
    const Mat3 exact = exact_rotation(r);
    return Eigen::AngleAxisd(small(r, 16), axis).toRotationMatrix() * exact;
  }
  return r.rotation();
}

/// Puts B about the middle of A, up to exactly there.
void put_deep(PosedPair& p, Random& r) {
  if (r.once_in(2)) scale(p.b.shape, small(r, 8));
  const Vec3 along = r.direction();
  const Vec3 aside = r.once_in(4) ? Vec3(Vec3::Zero()) : Vec3(0.3 * reach(p.a) * small(r, 12) * along);
  p.b.pose.translation = p.a.pose.translation + aside;
}

}  // namespace

Mat3 exact_rotation(Random& r) {
  Mat3 m = Mat3::Zero();
  const int first = r.below(3), second = (first + 1 + r.below(2)) % 3, third = 3 - first - second;
  m(first, 0) = r.sign(), m(second, 1) = r.sign(), m(third, 2) = 1;
  if (m.determinant() < 0) m(third, 2) = -1;
  return m;
}

void place(PosedPair& p, double gap) {
  const Shape a = make_shape(p.a), b = make_shape(p.b);
  const NarrowPhase solver;
  for (int i = 0; i < 2; ++i) {
    const PairAnswer r = solver.solve(a, p.a.pose, b, p.b.pose, Request::distance);
    const double step = gap - r.signed_distance;
    if (!(std::abs(step) < 1e3 * (1 + unit_of(p)))) return;
    p.b.pose.translation += step * r.normal;
  }
}

PosedPair draw_pair(std::uint64_t seed, const DrawOptions& options) {
  Random r(seed * 0x9e3779b97f4a7c15u + 17);
  const auto any_kind = [&] {
    return static_cast<ShapeKind>(r.below(static_cast<int>(ShapeKind::plane)));
  };  // planes must be requested
  ShapeKind ka = options.a.value_or(any_kind()), kb = options.b.value_or(any_kind());
  const auto is_bounded = [](ShapeKind k) { return k != ShapeKind::halfspace && k != ShapeKind::plane; };
  if (!is_bounded(ka) && !is_bounded(kb)) (options.a ? kb : ka) = ShapeKind::box;
  const Build build = options.needles ? Build::degenerate
                                      : std::array{Build::plump, Build::degenerate,
                                                   Build::dyadic}[static_cast<std::size_t>(r.below(3))];
  const bool exact = build == Build::dyadic;
  PosedPair p;
  p.seed = r.bits();
  p.a.shape = options.needles ? needle(r) : draw_shape(ka, r, build, options.meshes);
  p.b.shape = draw_shape(kb, r, build, options.meshes);
  if (options.needles)
    scale(p.b.shape, small(r, 3, 8));
  else if (r.once_in(4))
    scale(p.b.shape, exact ? std::ldexp(1.0, -r.below(27)) : small(r, 8));
  if (options.rounded) {
    const int which = r.below(3);
    for (PosedShape* s : {which != 1 ? &p.a : nullptr, which != 0 ? &p.b : nullptr})
      if (s != nullptr) {
        const double most = exact ? std::ldexp(1.0, -r.below(8)) : r.in(0.1, 1);
        s->rounding = exact ? most : most * small(r, 8);
      }
  }
  const auto translation = [&]() -> Vec3 {
    if (exact) return point(r, build) + point(r, build);
    const Vec3 along = r.direction();
    return r.in(0.1, 1.0) * (reach(p.a) + reach(p.b)) * along;
  };
  p.a.pose = {rotation(r, build), Vec3::Zero()};
  p.b.pose = {rotation(r, build), r.once_in(12) ? Vec3(Vec3::Zero()) : translation()};
  const double size = reach(p.a) + reach(p.b);
  if (!exact && r.once_in(2)) {
    const double side = r.once_in(8) ? 0 : r.sign();
    place(p, side == 0 ? 0 : side * (r.once_in(2) ? small(r, 16) : 0.02 * small(r, 2)) * size);
  }
  if (r.once_in(4)) {
    const double how_far = std::ldexp(1.0, r.below(28));
    const Vec3 far = rounded(r.vec(-1, 1)) * how_far;
    p.a.pose.translation += far;
    p.b.pose.translation += far;
  }
  p.margin = (r.once_in(2) ? 0.1 : small(r, 9)) * size;
  if (p.margin == 0) p.margin = 0.1;
  if (options.unusual) make_unusual(p, r);
  if (options.deep) put_deep(p, r);
  if (options.settled) settle(p, r);
  if (options.slivers) set_on_sliver(p, r);
  return p;
}

}  // namespace tandem::relations
