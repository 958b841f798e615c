#include "convex/gjk.h"

#include <tuple>

#include "convex/descent_kernel.h"
#include "convex/triangle_height.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int max_iterations = 96;
/// A candidate for the simplex's point nearest the origin: which vertices carry it, with what weights.
struct Nearest {
  Vec3 v;
  double squared = infinity;
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

/// By the longest side first, then away from it: a sliver's height keeps its digits, and so does the place along it.
void nearest_on_triangle(const Simplex& s, int i, int j, int k, Nearest& best) {
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
  height -= (height.dot(side) / longest) * side;  // square, whatever is left of so small a difference
  const double height2 = height.squaredNorm();
  if (height2 > tolerance::parallel_edges2 * longest) {
    const double wc = -a.dot(height) / height2, wb = -(a + wc * slant).dot(side) / longest, wa = 1 - wb - wc;
    if (wa > 0 && wb > 0 && wc > 0) {
      Nearest t;
      // The nearer it is, the more exactly the sides tell its direction: they are rounded, too.
      Vec3 v = wa * a + wb * b + wc * c;
      if (v.squaredNorm() < longest) v -= (v.dot(side) / longest) * side;
      if (v.squaredNorm() > height2) {
        t.take(v, {i, j, k}, {wa, wb, wc});
      } else {
        // Along the normal, as far as the corner nearest the origin is: a tiny distance keeps its digits.
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

/// Of a flat one, which side of a face the origin is on is noise: all faces are tried.
void nearest_on_tetrahedron(const Simplex& s, Nearest& best) {
  constexpr int face[4][4] = {{0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}, {0, 1, 2, 3}};  // the last: opposite
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

/// On the surface of a tetrahedron.
Nearest nearest_on_sides(const Simplex& s) {
  Nearest best;
  nearest_on_triangle(s, 0, 1, 2, best);
  nearest_on_triangle(s, 0, 1, 3, best);
  nearest_on_triangle(s, 0, 2, 3, best);
  nearest_on_triangle(s, 1, 2, 3, best);
  return best;
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

/// The point of a simplex nearest the origin, where the last point was added to the nearest feature of the others, so
/// that the nearest feature holds the last point. Keeps that feature's points, the last one last.
class Descent {
 public:
  explicit Descent(Simplex& s) : s_(s) {}

  enum class Step { moved, inside, lost };
  Step step(Vec3& v) {
    switch (s_.count) {
      case 1:
        v = s_.p[0].w;
        return Step::moved;
      case 2:
        on_segment(s_.p[1].w, s_.p[0].w);
        break;
      case 3:
        on_triangle(2, 0, 1);
        break;
      default:
        if (in_tetrahedron()) return Step::inside;
    }
    if (!(squared_ < v.squaredNorm())) return Step::lost;
    v = v_;
    const MinkowskiPoint last = s_.p[s_.count - 1];
    int count = 0;
    for (int i = 0; i + 1 < s_.count; ++i)
      if (keep_ >> i & 1u) {
        if (i != count) s_.p[count] = s_.p[i];
        ++count;
      }
    s_.p[count++] = last;
    s_.count = count;
    return Step::moved;
  }

 private:
  void take(const Vec3& v, unsigned keep) {
    const double squared = v.squaredNorm();
    if (squared < squared_) v_ = v, squared_ = squared, keep_ = keep;
  }
  static Vec3 point_on(const Vec3& p, const Vec3& q, const Vec3& pq, double t, double length2) {
    // From the end that is nearer: less cancellation.
    const double s = t / length2;
    return s <= 0.5 ? Vec3(p + s * pq) : Vec3(q - ((length2 - t) / length2) * pq);
  }
  void on_segment(const Vec3& p, const Vec3& q) {
    const Vec3 pq = q - p;
    const double t = -p.dot(pq), length2 = pq.squaredNorm();
    if (!(t > 0)) return take(p, 0);
    take(t >= length2 ? q : point_on(p, q, pq, t, length2), 1);
  }
  void on_triangle(int ip, int iq, int ir) {
    const Vec3 &p = s_.p[ip].w, &q = s_.p[iq].w, &r = s_.p[ir].w;
    const Vec3 a = q - p, b = r - p;
    const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b);
    const double da = -p.dot(a), db = -p.dot(b);
    double beyond_a = da * ab - db * aa, beyond_b = db * ab - da * bb;
    if (aa * bb - ab * ab < tolerance::crossing2 * aa * bb) {
      // A sliver: the same from cross products, where nothing cancels.
      const Vec3 n = a.cross(b);
      beyond_a = n.dot(a.cross(p)), beyond_b = -n.dot(b.cross(p));
    }
    if (!(beyond_a > 0) && !(beyond_b > 0)) {
      // By the third side where that is the shortest: long ones lose what they differ by.
      const Vec3 n = aa + bb - 2 * ab < std::min(aa, bb) ? Vec3(a.cross(r - q)) : Vec3(a.cross(b));
      const double n2 = n.squaredNorm();
      if (n2 > tolerance::parallel_lines2 * aa * bb) return take(n * (n.dot(p) / n2), 1u << iq | 1u << ir);
    }
    const bool on_a = da > 0, on_b = db > 0;
    if (!on_a && !on_b) return take(p, 0);
    if (on_a) take(da >= aa ? q : point_on(p, q, a, da, aa), 1u << iq);
    if (on_b) take(db >= bb ? r : point_on(p, r, b, db, bb), 1u << ir);
  }
  bool in_tetrahedron() {
    const Vec3& p = s_.p[3].w;
    const Vec3 a = s_.p[0].w - p, b = s_.p[1].w - p, c = s_.p[2].w - p;
    const Vec3 ab = a.cross(b), bc = b.cross(c), ca = c.cross(a);
    const double volume = ab.dot(c);
    const double longest2 = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
    const bool thin = volume * volume <= tolerance::parallel_edges2 * ab.squaredNorm() * longest2;
    const double sign = volume > 0 ? 1 : -1;
    const bool out_ab = thin || sign * p.dot(ab) > 0, out_bc = thin || sign * p.dot(bc) > 0,
               out_ca = thin || sign * p.dot(ca) > 0;
    if (!out_ab && !out_bc && !out_ca) return true;
    if (out_ab) on_triangle(3, 0, 1);
    if (out_bc) on_triangle(3, 1, 2);
    if (out_ca) on_triangle(3, 2, 0);
    return false;
  }

  Simplex& s_;
  Vec3 v_;
  double squared_ = infinity;
  unsigned keep_ = 0;  ///< of the points before the last
};

/// The direction of v as the edges of the shapes have it that the simplex is made of: the difference of two nearly
/// equal points is exact only in that it is square to these.
Vec3 square_to_edges(const MinkowskiDifference& d, const Simplex& s, const Vec3& v) {
  Vec3 n = v;
  if (s.count == 2) {
    const Vec3 e = d.edge(s.p[1], s.p[0]);
    const double e2 = e.squaredNorm();
    for (int i = 0; i < 2 && e2 > 0; ++i) n -= (n.dot(e) / e2) * e;
  } else if (s.count == 3) {
    const Height h = height_of(d.edge(s.p[1], s.p[0]), d.edge(s.p[2], s.p[1]), d.edge(s.p[0], s.p[2]));
    n = h.side.cross(h.height);
    if (n.dot(v) < 0) n = -n;
  }
  const double length = n.norm();
  return length > 0 ? unit(n, length) : unit(v);
}

/// Points of round shapes have no numbers to know them by.
bool has(const Simplex& s, const MinkowskiPoint& p, bool polytopes) {
  return std::any_of(s.p, s.p + s.count, [&](const MinkowskiPoint& q) {
    return polytopes ? p.vertex_a == q.vertex_a && p.vertex_b == q.vertex_b : p.w == q.w;
  });
}

/// GJK's last steps once more where rounding may have made what the fast ones ended with (of polytopes also where the
/// bounds do not meet): the upper bound is the length of a point that the simplex has, the lower one is along that, or
/// else, of polytopes, along a direction square to the simplex's edges. Sets the weights.
void refine(const MinkowskiDifference& d, const DescentLimits& limits, GjkResult& r) {
  constexpr int most_steps = 16;
  const auto close = [&limits](double upper) { return 2 * limits.rounding + limits.tolerance * upper; };
  const bool polytopes = d.polytopes();
  Nearest n = nearest(r.simplex);
  if (n.inside) n = nearest_on_sides(r.simplex);  // rounding's doing: this is not asked where it holds the origin
  if ((n.v - r.v).squaredNorm() <= 16 * limits.rounding * limits.rounding &&
      (!polytopes || r.upper - r.lower <= close(r.upper)))
    return keep(r.simplex, n);
  Simplex s = r.simplex;
  for (int step = 0; step < most_steps && !n.inside; ++step, n = nearest(s)) {
    const double upper = std::sqrt(n.squared);
    // From afar a step sideways changes the direction, and of the length no digit.
    if (step > 0 && !(upper <= r.upper)) return;
    keep(s, n);
    r.simplex = s;
    r.upper = upper;
    r.along = -infinity;
    bool known = true;
    const auto try_along = [&](const Vec3& along) {
      const MinkowskiPoint p = d.support(-along);
      const double lower = along.dot(p.w);
      if (lower > r.along) r.along = lower, r.v = upper * along;
      if (!has(s, p, polytopes)) known = false, s.p[s.count] = p;
      return upper - lower <= close(upper);
    };
    const bool met = try_along(unit(n.v)) || (polytopes && try_along(square_to_edges(d, s, n.v)));
    r.lower = std::max(r.lower, r.along);
    if (met || known) return;
    ++s.count;
  }
}

/// Between shapes of which one is round.
void descend_round(const MinkowskiDifference& d, const DescentLimits& limits, GjkResult& r) {
  Vec3& v = r.v;
  Simplex& s = r.simplex;
  r.upper = infinity;
  r.lower = -r.upper;
  double length = v.norm();
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const MinkowskiPoint p = d.support(-v);
    r.along = v.dot(p.w) / length;
    r.lower = std::max(r.lower, r.along);
    if (r.lower > limits.beyond ||
        (s.count > 0 && r.upper - r.lower <= limits.tolerance * std::min(r.upper, limits.size) + limits.rounding))
      break;
    bool known = false;
    for (int i = 0; i < s.count; ++i) known = known || p.w == s.p[i].w;
    if (known) break;
    s.p[s.count++] = p;
    if (s.count == 1) {
      v = p.w;
    } else {
      const auto step = Descent(s).step(v);
      if (step == Descent::Step::inside) {
        r.end = GjkResult::End::inside;
        r.upper = 0;
        return;
      }
      if (step == Descent::Step::lost) {
        --s.count;
        break;
      }
    }
    length = v.norm();
    r.upper = length;
    if (r.upper <= limits.within || length <= limits.rounding) break;
  }
}

}  // namespace

GjkResult descend(const MinkowskiDifference& d, double tolerance, double beyond, double within, const Vec3* start,
                  double at_once) {
  GjkResult r;
  Vec3& v = r.v;
  v = start != nullptr ? -*start : Vec3(core_centre(d.a) - d.pose.rotation * core_centre(d.b) - d.pose.translation);
  if (const double length = v.norm(); !(length > tolerance::shortest_squared))
    v = length > 0 ? unit(v, length) : Vec3(-Vec3::UnitX());
  const bool polytopes = d.polytopes();
  const double scale = d.scale();
  const double rounding = 2 * epsilon * scale;
  const DescentLimits limits{tolerance, beyond, within, at_once, rounding, scale, larger(d)};
  r.end = GjkResult::End::near;
  if (polytopes)
    descent_kernel()(d, limits, r);
  else
    descend_round(d, limits, r);
  // A simplex does not hold the origin where a direction separates: it is flat.
  if (polytopes && r.end == GjkResult::End::inside && r.lower > 2 * rounding)
    r.end = GjkResult::End::near, r.upper = r.simplex.p[0].w.norm();
  if (r.end == GjkResult::End::inside || r.simplex.count == 0) return r;
  if (!(r.lower > beyond)) refine(d, limits, r);
  // Polytopes: what is certified to rounding needs no second opinion.
  const double near =
      polytopes
          ? (r.upper - r.lower <= 8 * rounding + tolerance * r.upper ? 16 * rounding : tolerance::near_surface * scale)
          : tolerance::near_surface * scale;
  r.end = r.upper > near ? GjkResult::End::separated : GjkResult::End::near;
  return r;
}

void weigh(Simplex& s) {
  Nearest n = nearest(s);
  if (!n.inside) return keep(s, n);
  n = nearest_on_sides(s);  // asked of flat ones only: the origin lies next to a side
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

GjkResult gjk(const MinkowskiDifference& d, double tolerance, double beyond, double within, const Vec3* start) {
  GjkResult r = descend(d, tolerance, beyond, within, start);
  if (r.simplex.count > 0) weigh(r.simplex);
  return r;
}

void pair_points(const MinkowskiDifference& d, LocalAnswer& answer) {
  const bool polytopes = is_polytope(d.a.kind) && is_polytope(d.b.kind);
  const double scale = d.scale();
  MinkowskiDifference apart = d;
  if (polytopes) {
    // What a distance is rounded to leaves its ends free sideways, by the square root of it times the distance: nearer
    // where that shows.
    double least = infinity;
    for (const double out :
         {tolerance::far_apart * scale, tolerance::near_apart * scale, tolerance::least_apart * scale}) {
      apart.pose.translation = d.pose.translation + (out - answer.signed_distance) * answer.normal;
      const GjkResult r = gjk(apart, tolerance::ends_on_polytopes, infinity, -infinity);
      LocalAnswer there;
      set_points(r.simplex, there);
      const double sideways = (there.point_a - there.point_b + out * answer.normal).norm();
      if (!(sideways < least)) continue;
      least = sideways;
      answer.point_a = there.point_a, answer.point_b = there.point_b;
      answer.point_b -= (out - answer.signed_distance) * answer.normal;
      if (sideways <= tolerance::place_rounding * scale) break;
    }
    return;
  }
  const double out = tolerance::moved_apart * scale;
  for (int round = 0;; ++round) {
    apart.pose.translation = d.pose.translation + (out - answer.signed_distance) * answer.normal;
    const GjkResult r = gjk(apart, tolerance::ends_on_polytopes, infinity, -infinity);
    answer.point_a.setZero();
    for (int i = 0; i < r.simplex.count; ++i) answer.point_a += r.simplex.weight[i] * r.simplex.p[i].a;
    if (round == 8 || !(r.upper > 0)) break;
    // From outside, the direction to a curved surface turns towards the shortest one from inside.
    const Vec3 n = -r.v / r.upper;
    const double change = (n - answer.normal).squaredNorm();
    const double depth = n.dot(d.support(n).w);
    if (!(depth < -answer.signed_distance)) break;
    answer.signed_distance = -depth;
    answer.normal = n;
    if (change < tolerance::stopped_turning2) break;
  }
  answer.point_b = answer.point_a + answer.signed_distance * answer.normal;
}

}  // namespace tandem
