// The expanding polytope algorithm (van den Bergen 2001), for the depth of overlapping cores.
#include "convex/epa.h"

#include <array>
#include <memory>
#include <span>

#include "convex/expanding_polytope.h"
#include "lanes/fetch_ahead.h"
#include "shapes/triangle_height.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {

void set_points(const MinkowskiPoint& a, const MinkowskiPoint& b, const MinkowskiPoint& c, EpaResult& r) {
  const Vec3 q = r.upper * r.normal;
  const Vec3 n = (b.w - a.w).cross(c.w - a.w);
  double wa = n.dot((b.w - q).cross(c.w - q)), wb = n.dot((c.w - q).cross(a.w - q)),
         wc = n.dot((a.w - q).cross(b.w - q));
  wa = std::max(wa, 0.0), wb = std::max(wb, 0.0), wc = std::max(wc, 0.0);
  double sum = wa + wb + wc;
  if (!(sum > 0)) wa = sum = 1;
  r.point_a = (wa * a.a + wb * b.a + wc * c.a) / sum;
  r.point_b = r.point_a - (wa * a.w + wb * b.w + wc * c.w) / sum;
}

namespace epa {
namespace {

/// A difference without volume: its depth is along its normal.
void set_flat(const MinkowskiDifference& d, const Simplex& start, const Vec3& normal, EpaResult& r) {
  r.normal = normal;
  const MinkowskiPoint up = d.support(r.normal), down = d.support(-r.normal);
  const double h = r.normal.dot(up.w), opposite = -r.normal.dot(down.w);
  const bool flip = opposite < h;
  if (flip) r.normal = -r.normal;
  r.upper = r.lower = flip ? opposite : h;
  for (int i = 0; i < start.count; ++i) {
    r.point_a += start.weight[i] * start.p[i].a;
    r.point_b += start.weight[i] * (start.p[i].a - start.p[i].w);
  }
}

/// Expands until the nearest face is the difference's own, to the tolerance; `best`: the vertices of that face.
Polytope::Added expand_faces(const MinkowskiDifference& d, double tolerance, Polytope& p, int* best, EpaResult& r) {
  r.upper = infinity;
  auto added = Polytope::Added::yes;
  WorkMeter meter(d.limit, a_hundred_points);
  while (added == Polytope::Added::yes) {
    meter.spend(a_point);
    const int nearest = p.nearest_face();
    if (nearest < 0) {  // no face is nearer than the depth found
      r.lower = r.upper < infinity ? r.upper : 0;
      break;
    }
    const Face& f = p.face(nearest);
    r.lower = f.offset();
    const Vec3 normal = f.normal();
    if (r.lower >= r.upper - tolerance) break;
    p.vertex[p.vertices] = d.support(normal);
    const MinkowskiPoint& w = p.vertex[p.vertices];
    const double h = normal.dot(w.w);
    if (h < r.upper) {
      r.upper = h;
      r.normal = normal;
      std::copy_n(f.v, 3, best);
      p.limit(h);
    }
    if (h - r.lower <= std::max(tolerance, p.rounding())) break;
    if (d.polytopes()) {
      bool own = false;
      for (const int v : f.v) own |= p.vertex[v].vertex_a == w.vertex_a && p.vertex[v].vertex_b == w.vertex_b;
      if (own) break;
    }
    added = p.add(nearest);
  }
  return added;
}

/// Computes the plane of a face again, from the shapes' own edges.
void sharpen(const MinkowskiDifference& d, const MinkowskiPoint& a, const MinkowskiPoint& b, const MinkowskiPoint& c,
             double rounding, EpaResult& r) {
  const Vec3 n = normal_of(d.edge(b, a), d.edge(c, b), d.edge(a, c));
  const double length = n.norm();
  if (!(length > 0)) return;
  const Vec3 m = (n.dot(r.normal) < 0 ? -1 : 1) / length * n;
  if (!((m - r.normal).squaredNorm() > 64 * epsilon * epsilon)) return;
  const double h = m.dot(d.support(m).w);
  if (h <= r.upper + rounding) r.upper = h, r.normal = m;
}

/// Runs with the given memory, from the start and further points. False if the memory was too small; the result then is
/// the best so far.
bool expand_in(const PolytopeMemory& memory, const MinkowskiDifference& d, const Simplex& start, double tolerance,
               std::span<const MinkowskiPoint> more, EpaResult& r) {
  r = {};
  Polytope p(d, memory);
  if (p.span(start) < 3) {
    set_flat(d, start, p.base_normal, r);
    return true;
  }
  p.close_tetrahedron();
  for (const MinkowskiPoint& q : more) {
    p.vertex[p.vertices] = q;
    // If rounding prevents that, without the further points.
    if (p.include() != Polytope::Added::yes) return expand_in(memory, d, start, tolerance, {}, r);
  }
  int best[3] = {0, 1, 2};
  const Polytope::Added added = expand_faces(d, tolerance, p, best, r);
  if (r.upper == infinity) {  // all faces are slivers: take the plane of the largest
    r.normal = any_perpendicular(p.vertex[1].w - p.vertex[0].w);
    r.upper = r.normal.dot(d.support(r.normal).w);
    r.lower = 0;
  }
  const MinkowskiPoint &a = p.vertex[best[0]], &b = p.vertex[best[1]], &c = p.vertex[best[2]];
  if (d.polytopes()) sharpen(d, a, b, c, p.rounding(), r);
  set_points(a, b, c, r);
  return added != Polytope::Added::full;
}

}  // namespace
}  // namespace epa

namespace {

EpaResult expand(const MinkowskiDifference& d, const Simplex& start, double tolerance,
                 std::span<const MinkowskiPoint> more) {
  EpaResult r;
  epa::Workspace<128> small;
  if (epa::expand_in(epa::PolytopeMemory(small), d, start, tolerance, more, r)) return r;
  const auto large = std::make_unique_for_overwrite<epa::Workspace<4096>>();
  epa::expand_in(epa::PolytopeMemory(*large), d, start, tolerance, more, r);
  return r;
}

}  // namespace

EpaResult expand(const MinkowskiDifference& d, const Simplex& start, double tolerance) {
  return expand(d, start, tolerance, {});
}

EpaResult expand_all_around(const MinkowskiDifference& d) {
  // Initial directions: the corners of a cube, those of a tetrahedron first, then the centres of its faces.
  constexpr double directions[][3] = {{1, 1, 1},    {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, 0, 0},
                                      {-1, 0, 0},   {0, 1, 0},   {0, -1, 0},  {0, 0, 1},   {0, 0, -1},
                                      {-1, -1, -1}, {-1, 1, 1},  {1, -1, 1},  {1, 1, -1}};
  constexpr std::size_t most_fetched = 512;  // vertices: of larger hulls only few are read
  for (const ConvexView* const v : {&d.a, &d.b}) {
    if (v->vertices.size() > most_fetched) continue;
    fetch_ahead(v->vertices);
    if (v->hull != nullptr) fetch_ahead(v->hull->support.chambers());
  }
  std::array<MinkowskiPoint, std::size(directions)> points;
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = d.support({directions[i][0], directions[i][1], directions[i][2]});
  Simplex start;
  for (; start.count < 4; ++start.count) {
    start.p[start.count] = points[static_cast<std::size_t>(start.count)];
    start.weight[start.count] = 0.25;
  }
  return expand(d, start, 0, std::span(points).subspan(4));
}

}  // namespace tandem
