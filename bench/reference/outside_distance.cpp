// The distance of the origin from A - B in 113-bit arithmetic, by GJK.
#include <array>

#include "minkowski.h"

namespace tandem::reference {
namespace {

struct Simplex {
  std::array<Vec, 4> p;
  int count = 0;
};

struct Nearest {
  Vec v;
  Simplex simplex;  ///< the smallest simplex that holds v
};

Nearest nearest_on_segment(const Vec& a, const Vec& b) {
  const Vec ab = b - a;
  const Real along = -dot(a, ab), length = dot(ab, ab);
  if (!(along > 0)) return {a, {{a}, 1}};
  if (!(along < length)) return {b, {{b}, 1}};
  return {a + (along / length) * ab, {{a, b}, 2}};
}

Nearest nearer(const Nearest& m, const Nearest& n) { return dot(n.v, n.v) < dot(m.v, m.v) ? n : m; }

Nearest nearest_on_triangle(const Vec& a, const Vec& b, const Vec& c) {
  const Vec n = cross(b - a, c - a);
  const Real area = dot(n, n);
  if (area > 0 && dot(cross(b - a, n), a) >= 0 && dot(cross(c - b, n), b) >= 0 && dot(cross(a - c, n), c) >= 0)
    return {(dot(n, a) / area) * n, {{a, b, c}, 3}};
  return nearer(nearer(nearest_on_segment(a, b), nearest_on_segment(b, c)), nearest_on_segment(c, a));
}

bool holds_origin(const Simplex& s) {
  const auto volume = [](const Vec& a, const Vec& b, const Vec& c, const Vec& d) {
    return dot(cross(b - a, c - a), d - a);
  };
  const Vec o;
  const Real all = volume(s.p[0], s.p[1], s.p[2], s.p[3]);
  if (all == 0) return false;
  const Real parts[4] = {volume(o, s.p[1], s.p[2], s.p[3]), volume(s.p[0], o, s.p[2], s.p[3]),
                         volume(s.p[0], s.p[1], o, s.p[3]), volume(s.p[0], s.p[1], s.p[2], o)};
  for (const Real part : parts)
    if (all > 0 ? part < 0 : part > 0) return false;
  return true;
}

Nearest nearest(const Simplex& s) {
  switch (s.count) {
    case 1:
      return {s.p[0], s};
    case 2:
      return nearest_on_segment(s.p[0], s.p[1]);
    case 3:
      return nearest_on_triangle(s.p[0], s.p[1], s.p[2]);
    default:
      if (holds_origin(s)) return {Vec(), s};
      return nearer(nearer(nearest_on_triangle(s.p[0], s.p[1], s.p[2]), nearest_on_triangle(s.p[0], s.p[1], s.p[3])),
                    nearer(nearest_on_triangle(s.p[0], s.p[2], s.p[3]), nearest_on_triangle(s.p[1], s.p[2], s.p[3])));
  }
}

}  // namespace

Interval outside_distance(const Difference& difference, Real tolerance) {
  constexpr int most_steps = 3000;
  const Real touching = Real(1e-30) * difference.scale();
  Interval r;
  r.lower = -difference.scale();
  Simplex simplex;
  Vec v = difference.a.translation() - difference.b.translation();
  if (!(norm(v) > touching)) v = {1, 0, 0};
  v = difference.support(-v);
  simplex = {{v}, 1};
  for (int step = 0; step < most_steps; ++step) {
    const Real length = norm(v);
    r.upper = length;
    if (!(length > touching)) {
      r.upper = 0;
      return r;
    }
    const Vec w = difference.support(-v);
    const Real along = dot(v, w) / length;
    if (along > r.lower) {
      r.lower = along;
      r.normal = -(v / length);
    }
    if (!(length - r.lower > tolerance)) return r;
    simplex.p[static_cast<std::size_t>(simplex.count++)] = w;
    const Nearest next = nearest(simplex);
    if (next.simplex.count == 4) {
      r.upper = 0;
      return r;
    }
    if (!(dot(next.v, next.v) < length * length)) return r;  // no progress beyond rounding
    v = next.v;
    simplex = next.simplex;
  }
  return r;
}

}  // namespace tandem::reference
