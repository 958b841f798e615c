// Minima of h where both supports are smooth: two circles, ellipsoids.
#include "round/smooth_search.h"

#include "round/circle_distance.h"

namespace tandem {
namespace {

/// By branch and bound: arcs of the smaller circle are halved until each is known to have one minimum, or none.
void search_arcs(Minima& m, const CircleDistance& circles) {
  using Sample = CircleDistance::Sample;
  using Found = CircleDistance::Minima;
  constexpr int most = 400, deepest = 64;  // 53 halvings leave nothing
  const auto evaluate = [&](const Sample& s) {
    const double limit = m.best.h - m.rounding;
    if (!(s.squared < limit * limit && s.squared > m.rounding * m.rounding && circles.supports(s, m.rounding))) return;
    const Vec3 n = circles.direction(s);
    if (n.dot(m.pair.support(n)) < limit) m.try_from(n);
  };
  const double nothing = m.rounding / std::min(m.pair.body[0].radius(), m.pair.body[1].radius());
  CircleDistance::Arc stack[CircleDistance::most_arcs + deepest];
  int height = circles.arcs(m.best.h, m.rounding, stack);
  for (int halved = 0; height > 0 && m.best.h > m.rounding;) {
    const CircleDistance::Arc arc = stack[--height];
    if (!circles.may_have_minimum(arc, m.best.h, m.rounding)) continue;
    const double limit = m.best.h - m.rounding, least = circles.least_squared(arc);
    if (least >= limit * limit) continue;
    const Found minima = circles.minima(arc);
    if (minima == Found::one) evaluate(circles.minimum(arc));
    // An arc as short as rounding equals its ends, which have been examined.
    if (minima != Found::unknown || arc.chord2() <= nothing * nothing) continue;
    if (halved++ >= most) {
      m.gap = std::max(m.gap, m.best.h - std::sqrt(std::max(0.0, least)));
      continue;
    }
    const Sample middle = circles.middle(arc);
    evaluate(middle);
    stack[height++] = {arc.first, middle};
    stack[height++] = {middle, arc.last};
  }
}

}  // namespace

void search_circles(Minima& m) {
  CircleDistance circles(m.pair.body[0], m.pair.body[1]);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      if (m.best.h > 0 && m.pair.body[0].is_circle(i) && m.pair.body[1].is_circle(j) &&
          circles.take(i, j, m.best.h, m.rounding))
        search_arcs(m, circles);
}

void search_ellipsoids(Minima& m) {
  // The vertices of an icosahedron and the centres of its edges: 42 directions, such that every direction is within 21
  // degrees of one.
  constexpr double phi = 1.61803398874989484820, c = 0.52573111211913360603, d = phi * c;
  constexpr double q = 0.5 / phi, w = 0.5 * phi;
  constexpr double base[21][3] = {{0, c, d},    {0, c, -d},   {c, d, 0},    {c, -d, 0},   {d, 0, c},    {-d, 0, c},
                                  {1, 0, 0},    {0, 1, 0},    {0, 0, 1},    {q, 0.5, w},  {-q, 0.5, w}, {q, -0.5, w},
                                  {q, 0.5, -w}, {0.5, w, q},  {-0.5, w, q}, {0.5, -w, q}, {0.5, w, -q}, {w, q, 0.5},
                                  {-w, q, 0.5}, {w, -q, 0.5}, {w, q, -0.5}};
  constexpr double cosine = 0.934, sine = 0.358, far = 1.0;
  const auto evaluate = [&](const Vec3& n, const Vec3& p) {
    const double h = n.dot(p);
    const Vec3 across = p - h * n;
    if (h * cosine - across.norm() * sine >= m.best.h) return;
    const Vec3 u = any_perpendicular(n), v = n.cross(u);
    double curvature[3] = {-h, 0, -h};
    for (const RoundBody& body : m.pair.body) body.add_curvature(body.support_piece(n), n, u, v, curvature);
    const double det = curvature[0] * curvature[2] - curvature[1] * curvature[1];
    if (curvature[0] + curvature[2] > 0 && det > 0) {
      const double gu = across.dot(u), gv = across.dot(v);
      const double x = -(curvature[2] * gu - curvature[1] * gv) / det,
                   y = -(curvature[0] * gv - curvature[1] * gu) / det;
      if (x * x + y * y < far * far) {
        const Vec3 target = (n + x * u + y * v).normalized();
        for (int k = 0; k < m.count; ++k)
          if ((m.known[k] - target).squaredNorm() < 0.1 * 0.1) return;
      }
    }
    m.try_from(n);
  };
  for (const auto& b : base) {
    const Vec3 n{b[0], b[1], b[2]};
    const Vec3 p = m.pair.support(n);
    evaluate(n, p);
    evaluate(-n, m.pair.opposite(n, p));
    if (m.best.h < 0) return;
  }
}

}  // namespace tandem
