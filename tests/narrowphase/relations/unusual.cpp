// Unusual pairs: repeated triangles, dense hulls, stacks, hollow solids, solids of cubes, shapes far from their origin.
#include "unusual.h"

#include <cmath>
#include <stdexcept>

#include "draw.h"
#include "mesh_samples.h"
#include "tandem/narrowphase/shape_makers.h"

namespace tandem::relations {
namespace {

constexpr int most_triangles = 600;  // of a changed mesh: larger ones take as long as all others together

/// A rotation by 1e-16 to 1e-3 radians, or none.
Mat3 slight_turn(Random& r) {
  if (r.once_in(3)) return Mat3::Identity();
  const Vec3 axis = r.direction();
  return Eigen::AngleAxisd(1e-3 * small(r, 13), axis).toRotationMatrix();
}

/// The mesh as a surface if it is refused as a solid.
Mesh checked(Mesh m) {
  try {
    if (m.solid) make_shape(m);
  } catch (const std::invalid_argument&) {
    m.solid = false;
  }
  return m;
}

Mesh some_mesh(const ShapeData& drawn, Random& r) {
  if (const Mesh* m = std::get_if<Mesh>(&drawn); m != nullptr && m->triangles.size() <= most_triangles) return *m;
  if (r.once_in(2)) {
    const int sides = 4 + r.below(5), segments = 5 + r.below(8);
    return test::torus(1, r.in(0.15, 0.6), segments, sides);
  }
  const int cuts = 1 + r.below(3);
  return test::box_mesh(r.vec(0.1, 1.5), cuts);
}

/// Repeats some triangles, also reversed and with separate vertices; adds vertices that no triangle uses.
Mesh with_repeated(Mesh m, Random& r) {
  m.solid = false;
  const std::size_t count = m.triangles.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (!r.once_in(3)) continue;
    auto t = m.triangles[i];
    if (r.once_in(2)) std::swap(t[1], t[2]);
    if (r.once_in(2))
      for (auto& v : t) {
        m.vertices.push_back(m.vertices[v]);
        v = static_cast<std::uint32_t>(m.vertices.size() - 1);
      }
    m.triangles.push_back(t);
  }
  if (r.once_in(2)) m.vertices.push_back(r.vec(-1, 1));
  return m;
}

/// Points on an ellipsoid, a cylinder or a lens, thin to 1e-6.
Convex many_points(Random& r) {
  Convex c;
  const int n = r.once_in(4) ? 1000 + r.below(2000) : 60 + r.below(400), what = r.below(3);
  const double thin = r.once_in(2) ? small(r, 6) : 1;
  for (int i = 0; i < n; ++i) {
    Vec3 p = r.direction();
    if (what == 1) p /= std::hypot(p.x(), p.y()), p.z() = r.sign();
    if (what == 2) p.z() = (1 - p.x() * p.x() - p.y() * p.y()) * (i % 2 == 0 ? 1 : -1);
    c.vertices.push_back({p.x(), p.y(), thin * p.z()});
  }
  return c;
}

/// Two boxes of equal or different sizes, B on A with a small gap or overlap and a slight rotation.
void stack(PosedPair& p, Random& r) {
  const Vec3 size = r.vec(0.1, 1.5);
  p.a.shape = Box{size};
  const Vec3 other = r.once_in(2) ? size : r.vec(0.1, 1.5);
  p.b.shape = Box{other};
  const int up = r.below(3);
  Vec3 by = r.once_in(3) ? Vec3(Vec3::Zero()) : Vec3((size - other) / 2);  // sides flush, or centred
  if (r.once_in(3)) by = r.in(-0.5, 0.5) * size;
  const double side = r.once_in(3) ? 0 : r.sign();
  by[up] = (size[up] + other[up]) / 2 + (side == 0 ? 0 : side * small(r, 16));
  p.b.pose = {p.a.pose.rotation * slight_turn(r), p.a.pose.translation + p.a.pose.rotation * by};
  const Mesh a = test::box_mesh(size, 1 + r.below(2)), b = test::box_mesh(other, 1 + r.below(2));
  if (r.once_in(3)) p.a.shape = a;
  if (r.once_in(3)) p.b.shape = b;
  if (r.once_in(6)) p.b.shape = Convex{b.vertices};
}

/// A solid and a similar one, 0.05 to 1 - 1e-9 as large, inside it.
void put_in(PosedPair& p, Random& r) {
  if (p.a.kind() == ShapeKind::halfspace || p.a.kind() == ShapeKind::plane) p.a.shape = Box{r.vec(0.1, 1.5)};
  if (r.once_in(3)) p.a.shape = checked(some_mesh(p.a.shape, r));
  p.b = p.a;
  const double factor = r.once_in(2) ? r.in(0.05, 0.95) : 1 - small(r, 9);
  scale(p.b.shape, factor);
  p.b.rounding *= factor;
  if (r.once_in(2)) p.b.pose.rotation = r.once_in(2) ? r.rotation() : Mat3(p.b.pose.rotation * slight_turn(r));
  if (r.once_in(3)) return;
  const Vec3 along = r.direction();
  p.b.pose.translation += r.in(0, 1) * (1 - factor) * reach(p.a) * along;
}

/// A hollow box or ring with walls thin to 1e-7.
Mesh hollow(Random& r) {
  const double wall = 0.5 * small(r, 7);
  Mesh m, inner;
  if (r.once_in(2)) {
    const Vec3 size = r.vec(0.2, 1.5);
    m = test::box_mesh(size, 1 + r.below(2));
    inner = test::box_mesh((1 - wall) * size, 1 + r.below(2));
  } else {
    const double tube = r.in(0.15, 0.6);
    const int segments = 5 + r.below(6), sides = 4 + r.below(4);
    m = test::torus(1, tube, segments, sides);
    inner = test::torus(1, (1 - wall) * tube, segments, sides);
  }
  m = test::with_hollow(std::move(m), inner);
  m.solid = !r.once_in(4);
  return checked(m);
}

/// The same points, up to 1e6 from the origin of their frame.
void put_far_from_origin(PosedShape& s, Random& r) {
  const Vec3 any = r.vec(-1, 1), by = std::ldexp(1.0, r.below(21)) * any;
  const auto move = [&](auto& points) {
    for (Vec3& v : points) v += by;
    s.pose.translation -= s.pose.rotation * by;
  };
  if (Mesh* m = std::get_if<Mesh>(&s.shape)) {
    move(m->vertices);
    *m = checked(*m);
  } else if (Convex* c = std::get_if<Convex>(&s.shape)) {
    move(c->vertices);
  } else if (Triangle* t = std::get_if<Triangle>(&s.shape)) {
    move(t->vertices);
  }
}

void turn_together(PosedPair& p, Random& r) {
  const Mat3 turn = r.rotation();
  for (PosedShape* s : {&p.a, &p.b}) s->pose = {turn * s->pose.rotation, turn * s->pose.translation};
}

/// Moves the pair to a touch, or leaves it.
void place_somewhere(PosedPair& p, Random& r) {
  const double size = reach(p.a) + reach(p.b);
  if (r.once_in(3)) return;
  const double side = r.once_in(8) ? 0 : r.sign();
  place(p, side == 0 ? 0 : side * (r.once_in(2) ? small(r, 16) : 0.02 * small(r, 2)) * size);
}

/// Solids of a grid beside each other, where their faces often meet exactly, or one beside any shape.
void put_on_grid(PosedPair& p, Random& r) {
  const double size = r.once_in(2) ? (1 + r.below(8)) / 8.0 : r.in(0.1, 1);
  p.a.shape = r.once_in(3) ? land(size, r) : cubes(size, r);
  if (r.once_in(3)) return place_somewhere(p, r);
  p.b.shape = r.once_in(4) ? land(size, r) : cubes(r.once_in(4) ? size / 2 : size, r);
  const int z = r.below(9) - 4, y = r.below(9) - 4, x = r.below(9) - 4;
  p.a.pose = p.b.pose = {};
  p.b.pose.translation = size * (r.once_in(3) ? 0.5 : 1.0) * Vec3(x, y, z);
  if (r.once_in(3)) p.b.pose.rotation = slight_turn(r);
  if (r.once_in(3)) turn_together(p, r);
}

void change(PosedPair& p, Random& r) {
  Random apart(~p.seed);  // a separate generator: the other numbers of a seed stay the same
  if (apart.once_in(6)) return put_on_grid(p, apart);
  switch (r.below(8)) {
    case 0:
      p.a.shape = with_repeated(some_mesh(p.a.shape, r), r);
      if (r.once_in(2)) p.b.shape = with_repeated(some_mesh(p.b.shape, r), r);
      return place_somewhere(p, r);
    case 1:
      p.a.shape = many_points(r);
      if (r.once_in(3)) p.b.shape = many_points(r);
      return place_somewhere(p, r);
    case 2:
      return stack(p, r);
    case 3:
      return put_in(p, r);
    case 4:
      p.a.shape = hollow(r);
      if (r.once_in(3)) p.b.shape = hollow(r);
      return place_somewhere(p, r);
    case 5:
      put_far_from_origin(p.a, r);
      put_far_from_origin(p.b, r);
      return;
    case 6:
      if (p.a.kind() == ShapeKind::halfspace || p.a.kind() == ShapeKind::plane) return turn_together(p, r);
      p.b = p.a;
      if (!r.once_in(3)) {
        const Vec3 along = r.direction();
        p.b.pose.translation += small(r, 16) * reach(p.a) * along;
      }
      if (r.once_in(2)) p.b.pose.rotation = p.b.pose.rotation * slight_turn(r);
      return;
    default:
      return turn_together(p, r);
  }
}

}  // namespace

std::vector<std::array<std::int32_t, 3>> grid_places(int count, Random& r) {
  std::vector<std::array<std::int32_t, 3>> places;
  for (int n = count; n > 0; --n) {
    const int z = r.below(4) - 2, y = r.below(3) - 1, x = r.below(3) - 1;
    places.push_back({x, y, z});
  }
  return places;
}

Mesh cubes(double size, Random& r) {
  return std::get<Mesh>(data_of(voxel_mesh(grid_places(1 + r.below(12), r), size)));
}

Mesh land(double size, Random& r) {
  const int columns = 2 + r.below(5), rows = 2 + r.below(5), what = r.below(3);
  const double bump = what == 0 ? small(r, 12) : 1;
  std::vector<double> heights(static_cast<std::size_t>(columns * rows));
  for (double& h : heights) h = size * (what == 1 ? r.below(9) / 8.0 : bump * r.unit());
  const double bottom = -size * (r.once_in(3) ? small(r, 6) : 0.5);
  return std::get<Mesh>(
      data_of(height_field(heights, static_cast<std::size_t>(columns), static_cast<std::size_t>(rows), size, bottom)));
}

void make_unusual(PosedPair& p, Random& r) {
  change_if_allowed(p, [&](PosedPair& changed) { change(changed, r); });
}

}  // namespace tandem::relations
