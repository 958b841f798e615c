#include "gjk.h"

#include <limits>

#include "epa.h"

namespace tandem {
namespace {

constexpr int max_iterations = 96;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// A candidate for the simplex's point nearest the origin: which vertices carry it, with what weights.
struct Nearest {
  Vec3 v;
  double squared = std::numeric_limits<double>::infinity();
  int index[4];
  double weight[4];
  int count = 0;
  bool inside = false;

  void take(const Vec3& point, std::initializer_list<int> which, std::initializer_list<double> weights) {
    v = point;
    squared = point.squaredNorm();
    count = 0;
    for (const int i : which) index[count++] = i;
    std::copy(weights.begin(), weights.end(), weight);
  }
};

void nearest_on_segment(const Simplex& s, int i, int j, Nearest& best) {
  const Vec3 &a = s.p[i].w, &b = s.p[j].w;
  const Vec3 ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? -a.dot(ab) / length2 : 0.0;
  Nearest n;
  if (!(t > 0)) {
    n.take(a, {i}, {1.0});
  } else if (t >= 1) {
    n.take(b, {j}, {1.0});
  } else {
    // From the end that is nearer: less cancellation.
    n.take(t <= 0.5 ? Vec3(a + t * ab) : Vec3(b - (1 - t) * ab), {i, j}, {1 - t, t});
  }
  if (n.squared < best.squared) best = n;
}

void nearest_on_triangle(const Simplex& s, int i, int j, int k, Nearest& best) {
  const Vec3 &a = s.p[i].w, &b = s.p[j].w, &c = s.p[k].w;
  const Vec3 ab = b - a, ac = c - a, bc = c - b;
  // The two shorter edges give the most exact normal.
  const double ab2 = ab.squaredNorm(), ac2 = ac.squaredNorm(), bc2 = bc.squaredNorm();
  const double longest = std::max({ab2, ac2, bc2});
  const Vec3 n = longest == bc2 ? Vec3(ab.cross(ac)) : longest == ac2 ? Vec3(ab.cross(bc)) : Vec3(ac.cross(bc));
  const double n2 = n.squaredNorm();
  if (n2 > 1e-28 * longest * longest) {
    const double wa = n.dot(b.cross(c)), wb = n.dot(c.cross(a)), wc = n.dot(a.cross(b));
    if (wa > 0 && wb > 0 && wc > 0) {
      const double sum = wa + wb + wc;
      // The offset by the vertex nearest the origin, so that a tiny distance keeps its digits.
      const double a2 = a.squaredNorm(), b2 = b.squaredNorm(), c2 = c.squaredNorm();
      const Vec3& near = a2 <= b2 ? (a2 <= c2 ? a : c) : (b2 <= c2 ? b : c);
      Nearest t;
      t.take(n * (n.dot(near) / n2), {i, j, k}, {wa / sum, wb / sum, wc / sum});
      if (t.squared < best.squared) best = t;
      return;
    }
  }
  nearest_on_segment(s, i, j, best);
  nearest_on_segment(s, i, k, best);
  nearest_on_segment(s, j, k, best);
}

void nearest_on_tetrahedron(const Simplex& s, Nearest& best) {
  constexpr int face[4][4] = {{0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}, {0, 1, 2, 3}};  // the last: opposite
  bool outside = false;
  for (const auto& f : face) {
    const Vec3 &a = s.p[f[0]].w, &b = s.p[f[1]].w, &c = s.p[f[2]].w, &opposite = s.p[f[3]].w;
    const Vec3 n = (b - a).cross(c - a);
    const double origin_side = -n.dot(a), other_side = n.dot(opposite - a);
    const double rounding = 16 * epsilon * n.norm() * (a.norm() + opposite.norm());
    const bool flat = std::abs(other_side) <= rounding;
    if (flat || (other_side > 0 ? origin_side < 0 : origin_side > 0)) {
      outside = true;
      nearest_on_triangle(s, f[0], f[1], f[2], best);
    }
  }
  if (!outside) best.inside = true;
}

Nearest nearest(const Simplex& s) {
  Nearest best;
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

void keep(Simplex& s, const Nearest& n) {
  Simplex r;
  for (int i = 0; i < n.count; ++i) {
    r.p[i] = s.p[n.index[i]];
    r.weight[i] = n.weight[i];
  }
  r.count = n.count;
  s = r;
}

}  // namespace

GjkResult gjk(const MinkowskiDifference& d, double tolerance, double beyond, double within) {
  GjkResult r;
  Vec3 direction = d.pose.rotation * core_centre(d.b) + d.pose.translation - core_centre(d.a);
  if (!(direction.squaredNorm() > 0)) direction = Vec3::UnitX();
  Simplex& s = r.simplex;
  s.p[0] = d.support(direction);
  s.weight[0] = 1;
  s.count = 1;
  r.v = s.p[0].w;
  const double scale = d.scale() + r.v.norm();
  const double near = 1e-7 * scale;
  r.lower = -std::numeric_limits<double>::infinity();
  r.end = GjkResult::End::near;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const double length = r.v.norm();
    r.upper = length;
    if (length <= 4 * epsilon * scale) return r;
    const MinkowskiPoint p = d.support(-r.v);
    r.lower = std::max(r.lower, r.v.dot(p.w) / length);
    if (r.lower > beyond || r.upper <= within) break;
    if (r.upper - r.lower <= tolerance * r.upper + 2 * epsilon * scale) break;
    bool known = false;
    for (int i = 0; i < s.count; ++i) known = known || p.w == s.p[i].w;
    if (known) break;
    const Simplex before = s;
    s.p[s.count++] = p;
    const Nearest n = nearest(s);
    if (n.inside) {
      r.end = GjkResult::End::inside;
      r.upper = 0;
      return r;
    }
    if (!(n.squared < length * length)) {  // rounding: no nearer point can be found
      s = before;
      break;
    }
    keep(s, n);
    r.v = n.v;
  }
  r.end = r.upper > near ? GjkResult::End::separated : GjkResult::End::near;
  return r;
}

bool gjk_collide(const MinkowskiDifference& d, double tolerance) {
  const double rounding = core_radius(d.a) + core_radius(d.b);
  const GjkResult r = gjk(d, std::max(tolerance, 1e-14), rounding, rounding);
  if (r.end == GjkResult::End::inside) return true;
  if (r.end == GjkResult::End::separated || r.lower > rounding) return r.lower <= rounding && r.upper <= rounding;
  return gjk_signed_distance(d, tolerance).signed_distance <= 0;
}

namespace {

/// A few Newton steps for the direction of the extreme separation, where the difference's surface is smooth there.
/// -h(n) is concave along the surface; keeps the best n met.
void polish(const MinkowskiDifference& d, Vec3& n, double& h, Vec3& point_a, Vec3& point_w) {
  constexpr double step = 1e-5;
  for (int iteration = 0; iteration < 6; ++iteration) {
    const Vec3 e1 = any_perpendicular(n), e2 = n.cross(e1);
    const Vec3 w = d.support(n).w;
    const double g1 = e1.dot(w), g2 = e2.dot(w);
    // Forward differences of the tangential support point, the gradient of h on the sphere.
    const Vec3 m1 = (n + step * e1).normalized(), m2 = (n + step * e2).normalized();
    const Vec3 w1 = d.support(m1).w - w, w2 = d.support(m2).w - w;
    const double hn = n.dot(w);
    const double a = w1.dot(e1) / step - hn, c = w2.dot(e2) / step - hn;
    const double b = 0.5 * (w1.dot(e2) + w2.dot(e1)) / step;
    const double det = a * c - b * b;
    if (!(std::abs(det) > 0)) return;
    const double x = -(c * g1 - b * g2) / det, y = -(a * g2 - b * g1) / det;
    if (!(x * x + y * y < 0.01)) return;
    const Vec3 m = (n + x * e1 + y * e2).normalized();
    const MinkowskiPoint p = d.support(m);
    const double hm = m.dot(p.w);
    if (!(hm < h)) return;
    h = hm;
    n = m;
    point_a = p.a;
    point_w = p.w;
  }
}

}  // namespace

void pair_points(const MinkowskiDifference& d, LocalAnswer& answer) {
  const double infinity = std::numeric_limits<double>::infinity();
  const bool polytopes = is_polytope(d.a.kind) && is_polytope(d.b.kind);
  const double out = (polytopes ? 1.0 : 0.01) * d.scale();
  MinkowskiDifference apart = d;
  for (int round = 0;; ++round) {
    apart.pose.translation = d.pose.translation + (out - answer.signed_distance) * answer.normal;
    const GjkResult r = gjk(apart, 1e-14, infinity, -infinity);
    answer.point_a.setZero();
    for (int i = 0; i < r.simplex.count; ++i) answer.point_a += r.simplex.weight[i] * r.simplex.p[i].a;
    if (polytopes || round == 8 || !(r.upper > 0)) break;
    // From outside, the way to a curved surface turns towards the shortest one from inside.
    const Vec3 n = -r.v / r.upper;
    const double change = (n - answer.normal).squaredNorm();
    const double depth = n.dot(d.support(n).w);
    if (!(depth < -answer.signed_distance)) break;
    answer.signed_distance = -depth;
    answer.normal = n;
    if (change < 1e-16) break;
  }
  answer.point_b = answer.point_a + answer.signed_distance * answer.normal;
}

LocalAnswer gjk_signed_distance(const MinkowskiDifference& d, double tolerance) {
  const double infinity = std::numeric_limits<double>::infinity();
  const double ra = core_radius(d.a), rb = core_radius(d.b);
  // Round surfaces are approached step by step: the last digits cost more steps than they are worth.
  const double least = is_polytope(d.a.kind) && is_polytope(d.b.kind) ? 1e-14 : 2e-10;
  const GjkResult r = gjk(d, std::max(tolerance, least), infinity, -infinity);
  LocalAnswer answer;
  double core;  // signed distance of the cores
  if (r.end == GjkResult::End::separated) {
    core = r.upper;
    answer.normal = -r.v / r.upper;
    for (int i = 0; i < r.simplex.count; ++i) answer.point_a += r.simplex.weight[i] * r.simplex.p[i].a;
    answer.point_b = answer.point_a - r.v;
    answer.gap = r.upper - std::max(r.lower, 0.0);
  } else {
    const double scale = d.scale();
    EpaResult e = expand(d, r.simplex, std::max(tolerance, least) * scale);
    if (e.upper - e.lower > 1e-13 * scale && !(is_polytope(d.a.kind) && is_polytope(d.b.kind))) {
      Vec3 w = e.point_a - e.point_b, on_a = e.point_a;
      const double before = e.upper;
      polish(d, e.normal, e.upper, on_a, w);
      if (e.upper < before) {
        e.point_a = on_a;
        e.point_b = on_a - w;
      }
    }
    core = -e.upper;
    answer.normal = e.normal;
    answer.point_a = e.point_a;
    answer.point_b = e.point_b;
    answer.gap = std::max(0.0, e.upper - e.lower);
    const bool polytopes = is_polytope(d.a.kind) && is_polytope(d.b.kind);
    if (r.end == GjkResult::End::near && (r.lower > core || polytopes) && std::max(r.lower, core) > 0) {
      // Apart, and maybe by a corner or an edge that no face of the polytope stands for.
      if (r.lower > core) answer.normal = -r.v / r.upper;
      answer.gap = r.upper - std::max(r.lower, core);
      core = r.upper;
      answer.point_a.setZero();
      for (int i = 0; i < r.simplex.count; ++i) answer.point_a += r.simplex.weight[i] * r.simplex.p[i].a;
      answer.point_b = answer.point_a - r.v;
    } else if ((e.point_a - e.point_b - e.upper * e.normal).squaredNorm() >
               (polytopes ? 1e-24 : 1e-16) * scale * scale) {
      answer.signed_distance = core;
      pair_points(d, answer);
      core = answer.signed_distance;
      answer.gap = std::max(0.0, -core - e.lower);
    }
  }
  answer.signed_distance = core - ra - rb;
  answer.point_a += ra * answer.normal;
  answer.point_b -= rb * answer.normal;
  if (answer.gap <= 1e-13 * (d.scale() + std::abs(core))) answer.gap = 0;
  return answer;
}

}  // namespace tandem
