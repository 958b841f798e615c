// Exact times of impact of moving features, in integers. The features meet at t where the polygon of their differences
// holds the origin: the determinant of a corner and two sides is 0, and the origin lies in no edge's outer half plane;
// or, for a polygon without area, the origin lies on an edge. All these conditions are signs of polynomials in t of
// degree 4 at most. The closed set of such t, if not empty, has its first point at 0 or at a root of one of the
// polynomials; so it suffices to test the determinant's roots, or, where it vanishes everywhere, those of all others.
// Roots are isolated by Descartes' rule on Bernstein coefficients (Lane, Riesenfeld 1981; Collins, Akritas 1976).
#include "exact_impact.h"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <vector>

namespace tandem::reference {
namespace {

using Int = boost::multiprecision::cpp_int;
using Poly = std::vector<Int>;  // coefficient k of t^k; the last is not 0, no coefficients: 0

Poly trimmed(Poly p) {
  while (!p.empty() && p.back() == 0) p.pop_back();
  return p;
}
Poly operator+(const Poly& p, const Poly& q) {
  Poly r(std::max(p.size(), q.size()));
  for (std::size_t i = 0; i < p.size(); ++i) r[i] += p[i];
  for (std::size_t i = 0; i < q.size(); ++i) r[i] += q[i];
  return trimmed(std::move(r));
}
Poly operator-(const Poly& p, const Poly& q) {
  Poly r(std::max(p.size(), q.size()));
  for (std::size_t i = 0; i < p.size(); ++i) r[i] += p[i];
  for (std::size_t i = 0; i < q.size(); ++i) r[i] -= q[i];
  return trimmed(std::move(r));
}
Poly operator*(const Poly& p, const Poly& q) {
  if (p.empty() || q.empty()) return {};
  Poly r(p.size() + q.size() - 1);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t j = 0; j < q.size(); ++j) r[i + j] += p[i] * q[j];
  return trimmed(std::move(r));
}

Poly derivative(const Poly& p) {
  Poly r;
  for (std::size_t i = 1; i < p.size(); ++i) r.push_back(p[i] * i);
  return r;
}
Poly primitive(Poly p) {
  Int content = 0;
  for (const Int& c : p) content = gcd(content, c);
  if (content != 0)
    for (Int& c : p) c /= content;
  return p;
}
// The remainder of p by q, times some nonzero number.
Poly remainder(Poly p, const Poly& q) {
  while (p.size() >= q.size()) {
    const Int lead = p.back();
    const std::size_t shift = p.size() - q.size();
    for (Int& c : p) c *= q.back();
    for (std::size_t i = 0; i < q.size(); ++i) p[i + shift] -= lead * q[i];
    p = trimmed(std::move(p));
  }
  return p;
}
Poly common_divisor(Poly p, Poly q) {
  p = primitive(std::move(p)), q = primitive(std::move(q));
  while (!q.empty()) {
    Poly r = primitive(remainder(p, q));
    p = std::move(q), q = std::move(r);
  }
  return p;
}
// p / q where that is a polynomial, times some nonzero number.
Poly quotient(Poly p, const Poly& q) {
  Poly r(p.size() - q.size() + 1);
  while (p.size() >= q.size()) {
    const Int lead = p.back();
    const std::size_t shift = p.size() - q.size();
    for (Int& c : r) c *= q.back();
    r[shift] += lead;
    for (Int& c : p) c *= q.back();
    for (std::size_t i = 0; i < q.size(); ++i) p[i + shift] -= lead * q[i];
    p = trimmed(std::move(p));
  }
  return primitive(trimmed(std::move(r)));
}

// The number k / 2^m.
struct Dyadic {
  Int k;
  unsigned m;
};
int sign_at(const Poly& p, const Dyadic& x) {  // Horner's rule, times 2^(m deg)
  if (p.empty()) return 0;
  Int sum = 0;
  unsigned shift = 0;
  for (std::size_t i = p.size(); i-- > 0; shift += x.m) sum = sum * x.k + (p[i] << shift);
  return sum.sign();
}
int compare(const Dyadic& x, const Dyadic& y) { return Int((x.k << y.m) - (y.k << x.m)).sign(); }

// Bernstein coefficients on [k, k + 1] / 2^m, times a positive number.
Poly bernstein(const Poly& p, const Int& k, unsigned m) {
  const std::size_t n = p.size() - 1;
  Poly q = p;  // p(x / 2^m), then shifted by k
  for (std::size_t i = 0; i <= n; ++i) q[i] <<= m * static_cast<unsigned>(n - i);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = n; j-- > i;) q[j] += k * q[j + 1];
  static constexpr int choose[5][5] = {{1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}};
  Poly b(n + 1);
  for (std::size_t j = 0; j <= n; ++j)
    for (std::size_t i = 0; i <= j; ++i) b[j] += q[i] * (12 * choose[j][i] / choose[n][i]);  // 12: of 1, 2, 3, 4 and 6
  return b;
}
int variations(const Poly& b) {
  int count = 0, last = 0;
  for (const Int& c : b)
    if (const int s = c.sign(); s != 0) count += last * s < 0, last = s;
  return count;
}

// A root of `p`, isolated: it is the only one in the closed interval `at`, or equals `at` where it is exact.
struct Root {
  Poly p;
  Int k;
  unsigned m;
  bool exact;

  Dyadic low() const { return {k, m}; }
  Dyadic high() const { return {exact ? k : k + 1, m}; }
  void halve() {
    const Dyadic middle{2 * k + 1, m + 1};
    const int s = sign_at(p, middle);
    if (s == 0)
      exact = true, k = middle.k, m = middle.m;
    else
      k = s == sign_at(p, low()) ? middle.k : 2 * k, ++m;
  }
  int sign_of(const Poly& q) {
    if (q.empty()) return 0;
    for (int i = 0;; ++i) {
      if (exact) return sign_at(q, low());
      const Poly b = bernstein(q, k, m);
      if (variations(b) == 0 && b.front() != 0 && b.back() != 0) return b.front().sign();
      if (i == 8) {
        const Poly g = common_divisor(p, q);
        if (g.size() > 1 && sign_at(g, low()) * sign_at(g, high()) < 0) return 0;
      }
      halve();
    }
  }
  bool before(const Dyadic& t) {  // true if the root is less than t
    if (exact || compare(t, low()) <= 0 || compare(t, high()) >= 0) return compare(high(), t) <= (exact ? -1 : 0);
    const int s = sign_at(p, t);
    return s != 0 && s != sign_at(p, low());
  }
};

// Adds the roots in [0, 1] of a polynomial that is not 0.
void add_roots(Poly p, std::vector<Root>& roots) {
  if (p.size() > 2) p = quotient(p, common_divisor(p, derivative(p)));
  struct Piece {
    Int k;
    unsigned m;
  };
  const auto take_exact = [&](const Dyadic& x) {
    if (p.size() < 2 || sign_at(p, x) != 0) return false;
    roots.push_back({{}, x.k, x.m, true});
    p = quotient(p, Poly{-x.k, Int(1) << x.m});
    return true;
  };
  take_exact({0, 0});
  take_exact({1, 0});
  for (bool again = true; again;) {
    again = false;
    const std::size_t kept = roots.size();
    std::vector<Piece> pieces{{0, 0}};
    while (!pieces.empty() && p.size() > 1) {
      const Piece piece = pieces.back();
      pieces.pop_back();
      const int count = variations(bernstein(p, piece.k, piece.m));
      if (count == 0) continue;
      if (count == 1) {
        roots.push_back({p, piece.k, piece.m, false});
        continue;
      }
      if (sign_at(p, {2 * piece.k + 1, piece.m + 1}) == 0) {
        roots.resize(kept, Root{{}, 0, 0, true});
        again = take_exact({2 * piece.k + 1, piece.m + 1});
        break;
      }
      pieces.push_back({2 * piece.k + 1, piece.m + 1});
      pieces.push_back({2 * piece.k, piece.m + 1});
    }
  }
}

using PolyVec = std::array<Poly, 3>;
PolyVec operator-(const PolyVec& u, const PolyVec& v) { return {u[0] - v[0], u[1] - v[1], u[2] - v[2]}; }
PolyVec cross(const PolyVec& u, const PolyVec& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
Poly dot(const PolyVec& u, const PolyVec& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }

// The vertices as polynomials of degree 1, scaled so that their coefficients are integers.
std::array<PolyVec, 4> vertices(const ImpactQuery& query) {
  int low = std::numeric_limits<int>::max();
  const auto each = [&](auto&& take) {
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t end = 0; end < 2; ++end)
          take(i, k, end, (end == 0 ? query.from : query.to)[i][static_cast<Eigen::Index>(k)]);
  };
  each([&](std::size_t, std::size_t, std::size_t, double x) {
    if (x == 0) return;
    int exponent;
    auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    for (exponent -= 53; mantissa % 2 == 0; mantissa /= 2) ++exponent;
    low = std::min(low, exponent);
  });
  std::array<std::array<std::array<Int, 2>, 3>, 4> ends;
  each([&](std::size_t i, std::size_t k, std::size_t end, double x) {
    if (x == 0) return;
    int exponent;
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    const int shift = exponent - 53 - low;
    ends[i][k][end] = shift >= 0 ? Int(mantissa) << shift : Int(mantissa / (std::int64_t{1} << -shift));
  });
  std::array<PolyVec, 4> r;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) r[i][k] = trimmed({ends[i][k][0], ends[i][k][1] - ends[i][k][0]});
  return r;
}

// The polynomials whose signs tell whether the origin lies in the polygon.
struct Conditions {
  Poly plane;                    // the determinant of a corner and two sides
  PolyVec normal;                // cross product of two sides
  std::vector<Poly> inside;      // for each edge: >= 0 if the origin is on its inner side
  std::vector<PolyVec> on_line;  // for each edge: 0 where its line holds the origin
  std::vector<Poly> between;     // for each edge: <= 0 if the origin is then between its ends

  explicit Conditions(const ImpactQuery& query) {
    const std::array<PolyVec, 4> x = vertices(query);
    std::vector<PolyVec> w;
    if (query.edges)
      w = {x[0] - x[2], x[1] - x[2], x[1] - x[3], x[0] - x[3]};
    else
      w = {x[0] - x[1], x[0] - x[2], x[0] - x[3]};
    normal = cross(w[1] - w[0], w.back() - w[0]);
    plane = dot(w[0], normal);
    for (std::size_t i = 0; i < w.size(); ++i) {
      const PolyVec& next = w[(i + 1) % w.size()];
      on_line.push_back(cross(w[i], next));
      between.push_back(dot(w[i], next));
      inside.push_back(dot(on_line.back(), normal));
    }
  }
  bool hold(Root& t) const {
    if (t.sign_of(plane) != 0) return false;
    const auto none = [&](const PolyVec& v) {
      return std::all_of(v.begin(), v.end(), [&](const Poly& p) { return t.sign_of(p) == 0; });
    };
    if (!none(normal))
      return std::all_of(inside.begin(), inside.end(), [&](const Poly& p) { return t.sign_of(p) >= 0; });
    for (std::size_t i = 0; i < between.size(); ++i)
      if (t.sign_of(between[i]) <= 0 && none(on_line[i])) return true;
    return false;
  }
  std::vector<Root> candidates() const {
    std::vector<Root> roots;
    if (!plane.empty()) {
      add_roots(plane, roots);
      return roots;
    }
    roots.push_back({{}, 0, 0, true});
    const auto add = [&](const Poly& p) {
      if (!p.empty()) add_roots(p, roots);
    };
    for (const Poly& p : normal) add(p);
    for (std::size_t i = 0; i < between.size(); ++i) {
      add(inside[i]);
      add(between[i]);
      for (const Poly& p : on_line[i]) add(p);
    }
    return roots;
  }
};

Dyadic dyadic(double t) {
  if (t == 0) return {0, 0};
  int exponent;
  const double mantissa = std::frexp(t, &exponent);
  return {Int(static_cast<std::int64_t>(std::ldexp(mantissa, 53))), static_cast<unsigned>(53 - exponent)};
}

}  // namespace

struct ExactImpact::Insides {
  std::vector<Root> hits;
};

ExactImpact::ExactImpact(const ImpactQuery& query) : insides_(std::make_unique<Insides>()) {
  const Conditions conditions(query);
  for (Root& root : conditions.candidates())
    if (conditions.hold(root)) insides_->hits.push_back(std::move(root));
}
ExactImpact::~ExactImpact() = default;
ExactImpact::ExactImpact(ExactImpact&&) noexcept = default;

bool ExactImpact::hit() const { return !insides_->hits.empty(); }
bool ExactImpact::hit_before(double t) const {
  const Dyadic at = dyadic(t);
  return std::any_of(insides_->hits.begin(), insides_->hits.end(), [&](Root& root) { return root.before(at); });
}

}  // namespace tandem::reference
