// The point of a simplex nearest the origin.
#include "convex/simplex.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tolerances.h"

namespace tandem {
namespace {

void nearest_on_segment(const Simplex& s, int i, int j, NearestOnSimplex& best) {
  const Vec3 &a = s.p[i].w, &b = s.p[j].w;
  const Vec3 ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? -a.dot(ab) / length2 : 0.0;
  NearestOnSimplex n;
  if (!(t > 0)) {
    n.take(a, {i}, {1.0});
  } else if (t >= 1) {
    n.take(b, {j}, {1.0});
  } else {
    // From the nearer end: less cancellation.
    n.take(t <= 0.5 ? Vec3(a + t * ab) : Vec3(b - (1 - t) * ab), {i, j}, {1 - t, t});
  }
  if (n.squared < best.squared) best = n;
}

/// Along the longest side first, then perpendicular to it, so that a sliver's height keeps its digits, and so does the
/// position along it.
void nearest_on_triangle(const Simplex& s, int i, int j, int k, NearestOnSimplex& best) {
  const auto length2 = [&s](int p, int q) { return (s.p[q].w - s.p[p].w).squaredNorm(); };
  // The longest side leads from i to j.
  const double ij = length2(i, j), jk = length2(j, k), ki = length2(k, i), longest = std::max({ij, jk, ki});
  if (longest == jk)
    std::tie(i, j, k) = std::tuple(j, k, i);
  else if (longest == ki)
    std::tie(i, j, k) = std::tuple(k, i, j);
  const Vec3 &a = s.p[i].w, &b = s.p[j].w, &c = s.p[k].w;
  const Vec3 side = b - a, slant = c - a;
  Vec3 height = slant - (slant.dot(side) / longest) * side;
  height -= (height.dot(side) / longest) * side;  // perpendicular, despite the rounding of so small a difference
  const double height2 = height.squaredNorm();
  if (height2 > tolerance::parallel_edges2 * longest) {
    const double wc = -a.dot(height) / height2, wb = -(a + wc * slant).dot(side) / longest, wa = 1 - wb - wc;
    if (wa > 0 && wb > 0 && wc > 0) {
      NearestOnSimplex t;
      // Near the origin the sides give the direction more exactly than v; from afar their rounding would prevail.
      Vec3 v = wa * a + wb * b + wc * c;
      if (v.squaredNorm() < longest) v -= (v.dot(side) / longest) * side;
      if (v.squaredNorm() > height2) {
        t.take(v, {i, j, k}, {wa, wb, wc});
      } else {
        // Along the normal, as far as the corner nearest the origin: a tiny distance keeps its digits.
        const Vec3 n = side.cross(height);
        const double a2 = a.squaredNorm(), b2 = b.squaredNorm(), c2 = c.squaredNorm();
        const Vec3& near = a2 <= b2 ? (a2 <= c2 ? a : c) : (b2 <= c2 ? b : c);
        t.take(n * (n.dot(near) / (longest * height2)), {i, j, k}, {wa, wb, wc});
      }
      if (t.squared < best.squared) best = t;
      return;
    }
  }
  nearest_on_segment(s, i, j, best);
  nearest_on_segment(s, i, k, best);
  nearest_on_segment(s, j, k, best);
}

/// For a flat tetrahedron, the side of a face on which the origin lies is noise: all faces are tried.
void nearest_on_tetrahedron(const Simplex& s, NearestOnSimplex& best) {
  // The fourth number is the opposite corner.
  constexpr int face[4][4] = {{0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}, {0, 1, 2, 3}};
  bool outside[4], flat = false;
  for (int i = 0; i < 4; ++i) {
    const auto& f = face[i];
    const Vec3 &a = s.p[f[0]].w, &b = s.p[f[1]].w, &c = s.p[f[2]].w, &opposite = s.p[f[3]].w;
    const Vec3 n = (b - a).cross(c - a);
    const double origin_side = -n.dot(a), other_side = n.dot(opposite - a);
    const double rounding = 16 * epsilon * n.norm() * (a.norm() + opposite.norm());
    flat = flat || std::abs(other_side) <= rounding;
    outside[i] = other_side > 0 ? origin_side < 0 : origin_side > 0;
  }
  best.inside = true;
  for (int i = 0; i < 4; ++i) {
    if (!flat && !outside[i]) continue;
    best.inside = false;
    nearest_on_triangle(s, face[i][0], face[i][1], face[i][2], best);
  }
}

}  // namespace

/// The nearest point on the surface of a tetrahedron.
NearestOnSimplex nearest_on_sides(const Simplex& s) {
  NearestOnSimplex best;
  nearest_on_triangle(s, 0, 1, 2, best);
  nearest_on_triangle(s, 0, 1, 3, best);
  nearest_on_triangle(s, 0, 2, 3, best);
  nearest_on_triangle(s, 1, 2, 3, best);
  return best;
}

NearestOnSimplex nearest_to_origin(const Simplex& s) {
  NearestOnSimplex best;
  switch (s.count) {
    case 1:
      best.take(s.p[0].w, {0}, {1.0});
      break;
    case 2:
      nearest_on_segment(s, 0, 1, best);
      break;
    case 3:
      nearest_on_triangle(s, 0, 1, 2, best);
      break;
    default:
      nearest_on_tetrahedron(s, best);
      break;
  }
  return best;
}

void keep_nearest(Simplex& s, const NearestOnSimplex& n) {
  if (n.count == s.count) {
    for (int i = 0; i < n.count; ++i) s.weight[n.index[i]] = n.weight[i];
    return;
  }
  Simplex r;
  for (int i = 0; i < n.count; ++i) {
    r.p[i] = s.p[n.index[i]];
    r.weight[i] = n.weight[i];
  }
  r.count = n.count;
  s = r;
}

double farthest_from_origin(const Simplex& s) {
  double squared = 0;
  for (int i = 0; i < s.count; ++i) squared = std::max(squared, s.p[i].w.squaredNorm());
  return std::sqrt(squared);
}

bool is_solid(const MinkowskiDifference& d, const Simplex& s) {
  if (s.count != 4) return false;
  const Vec3 a = s.p[1].w - s.p[0].w, b = s.p[2].w - s.p[0].w, c = s.p[3].w - s.p[0].w;
  const Vec3 n = a.cross(b);
  const double thick = tolerance::thick_start * (d.scale() + farthest_from_origin(s));
  return a.squaredNorm() > thick * thick && n.squaredNorm() > thick * thick * a.squaredNorm() &&
         std::abs(n.dot(c)) > thick * n.norm();
}

void set_weights(Simplex& s) {
  NearestOnSimplex n = nearest_to_origin(s);
  if (!n.inside) return keep_nearest(s, n);
  n = nearest_on_sides(s);  // for flat tetrahedra, where the origin lies near a side
  std::fill_n(s.weight, s.count, 0.0);
  for (int i = 0; i < n.count; ++i) s.weight[n.index[i]] = n.weight[i];
}

void set_points(const Simplex& s, LocalAnswer& answer) {
  answer.point_a.setZero();
  answer.point_b.setZero();
  for (int i = 0; i < s.count; ++i) {
    answer.point_a += s.weight[i] * s.p[i].a;
    answer.point_b += s.weight[i] * (s.p[i].a - s.p[i].w);
  }
}

}  // namespace tandem
