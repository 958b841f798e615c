// Turns a patch into contacts: its normal, its points, and their depths.
#include "meshes/contacts/patch_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "manifold/patch_collector.h"
#include "shapes/metered_sort.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"
#include "triangles/triangle_rows.h"

namespace tandem {
namespace {

// The rounding error of the area of a patch's curve: its points lie in both triangles' planes to rounding, less exactly
// the smaller the angle between these.
double noise_of(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings) {
  const auto normal = [&](bool of_a, std::uint32_t t) { return unit(area_vector(m.corners(of_a, t))); };
  const double off = 8 * epsilon * (m.a.half + m.b.half).norm() + m.frame.delta();
  double noise = 0;
  WorkMeter meter(m.limit);
  for (const std::uint32_t k : patch.crossings) {
    meter.spend();
    const Crossing& c = crossings[k];
    const double length = (c.end[1].point - c.end[0].point).norm();
    const double sine = normal(true, c.triangles[0]).cross(normal(false, c.triangles[1])).norm();
    if (length > 0) noise += length * off / sine;
  }
  return noise;
}

// The only plane of a mesh's triangles of a patch that faces the other mesh along n; nullptr if there are several.
const Facet* sole_face(std::span<const Facet> facets, const Vec3& n, double slack) {
  constexpr double on_its_side = 0.1;
  const Facet* face = nullptr;
  for (const Facet& f : facets) {
    if (!(f.n.dot(n) > on_its_side)) continue;
    if (face == nullptr) face = &f;
    for (const Vec3& v : f.p)
      if (std::abs(face->n.dot(v - face->p[0])) > slack) return nullptr;
  }
  return face;
}

constexpr std::size_t span_limit = 16;  // ridges of a patch that are tested against those of the other mesh

// True if the two triangles at the edge lie behind each other's planes, or the edge is a border. Only such edges can be
// deepest where they cross one of the other mesh. For a surface with a border either side may be the outer one: all
// edges count.
bool is_ridge(const MeshModel& mesh, std::uint32_t t, std::uint32_t corner) {
  const std::uint32_t next = mesh.neighbours()[t][corner];
  if (next == no_index || !mesh.closed) return true;
  const auto p = mesh.corners(t), q = mesh.corners(next);
  const Vec3 n = area_vector(p);
  const auto& back = mesh.neighbours()[next];
  const auto shared = static_cast<std::size_t>(std::find(back.begin(), back.end(), t) - back.begin());
  return n.dot(q[(shared + 2) % 3] - p[0]) < -tolerance::in_plane * n.norm() * mesh.half.norm();
}

// The depth at which two ridge intervals, of A and of B, overlap along n where they cross in projection; also within
// `slack` of their ends, which lie over the other's where a face is parallel to n.
std::optional<double> overlap_of_ridges(const RidgeSpan& a, const RidgeSpan& b, const Vec3& n, double slack,
                                        Vec3& point) {
  const Vec3 d = a.q - a.p, e = b.q - b.p, r = b.p - a.p;
  const double det = n.dot(d.cross(e));
  // The crossing of parallel ones depends on rounding; points over their ends are known without it.
  if (!(std::abs(det) > tolerance::flush * d.norm() * e.norm())) return std::nullopt;
  const double s = n.dot(r.cross(e)) / det, t = n.dot(r.cross(d)) / det;
  const auto on = [slack](double fraction, const Vec3& edge) {
    const double beyond = std::max(-fraction, fraction - 1);
    return beyond <= 0 || beyond * edge.norm() <= slack;
  };
  if (!on(s, d) || !on(t, e)) return std::nullopt;
  const Vec3 on_a = a.p + std::clamp(s, 0.0, 1.0) * d, on_b = b.p + std::clamp(t, 0.0, 1.0) * e;
  point = (on_a + on_b) / 2;
  const double depth = n.dot(on_a - on_b);
  return depth >= 0 ? std::optional(depth) : std::nullopt;
}

// The intervals that are tested against others: those farthest along n, among equals those farthest along another
// direction.
List<const RidgeSpan*> farthest_spans(std::span<const RidgeSpan> spans, const Vec3& n, double slack, WorkMeter& meter,
                                      Memory memory) {
  struct Place {
    const RidgeSpan* span;
    double reach, aside;
  };
  List<Place> places(memory);
  places.reserve(spans.size());
  const Vec3 tie_break = tie_break_direction(n);
  for (const RidgeSpan& s : spans) {
    meter.spend();
    places.push_back({&s, std::round(std::max(n.dot(s.p), n.dot(s.q)) / slack), tie_break.dot(s.p + s.q)});
  }
  const std::size_t kept = std::min(spans.size(), span_limit);
  if (kept < places.size())
    std::nth_element(places.begin(), places.begin() + span_limit, places.end(), [](const Place& x, const Place& y) {
      return x.reach != y.reach ? x.reach > y.reach : x.aside > y.aside;
    });
  List<const RidgeSpan*> out(memory);
  out.reserve(kept);
  for (std::size_t i = 0; i < kept; ++i) out.push_back(places[i].span);
  return out;
}

// Measures how far a point of one mesh lies beyond the other's surface along `n` (from A to B); negative if that
// surface has no point there.
class DepthProbe {
 public:
  DepthProbe(const Facets& facets, const Vec3& n, const WorkLimit* limit, Memory memory)
      : n_(n), boxes_{List<Box>(memory), List<Box>(memory)}, flats_{List<Flat>(memory), List<Flat>(memory)} {
    u_ = tie_break_direction(n).normalized();
    v_ = n.cross(u_);
    WorkMeter meter(limit);
    for (const std::size_t of_a : {std::size_t{1}, std::size_t{0}}) {
      boxes_[of_a].reserve(std::min(facets[of_a].size(), usual_flats));
      flats_[of_a].reserve(std::min(facets[of_a].size(), usual_flats));
      for (const Facet& facet : facets[of_a]) {
        meter.spend();
        const auto& p = facet.p;
        // Only facets that face the other mesh, not those parallel to n within a small angle.
        if (!(facet.n.dot(n) > tolerance::flush)) continue;
        Flat f;
        for (std::size_t k = 0; k < 3; ++k) f.x[k] = u_.dot(p[k]), f.y[k] = v_.dot(p[k]), f.z[k] = n.dot(p[k]);
        const auto [low_x, high_x] = std::minmax({f.x[0], f.x[1], f.x[2]});
        const auto [low_y, high_y] = std::minmax({f.y[0], f.y[1], f.y[2]});
        const double slack = 4 * edge * (high_x - low_x + high_y - low_y) +
                             tolerance::place_rounding * (std::abs(f.x[0]) + std::abs(f.y[0]));
        boxes_[of_a].push_back({low_x - slack, high_x + slack, low_y - slack, high_y + slack});
        flats_[of_a].push_back(f);
      }
    }
  }

  double operator()(const Candidate& c, WorkMeter& meter) const {
    const double x = u_.dot(c.point), y = v_.dot(c.point), z = n_.dot(c.point);
    double nearest = std::numeric_limits<double>::infinity();
    const std::span<const Box> boxes = boxes_[c.of_a ? 0 : 1];
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      if (k % 32 == 0) meter.spend();
      // `&`: which comparison fails is unpredictable.
      const Box& box = boxes[k];
      if (((x >= box.low_x) & (x <= box.high_x) & (y >= box.low_y) & (y <= box.high_y)) == 0) continue;
      const Flat& f = flats_[c.of_a ? 0 : 1][k];
      const double ax = f.x[1] - f.x[0], ay = f.y[1] - f.y[0], bx = f.x[2] - f.x[0], by = f.y[2] - f.y[0];
      const double det = ax * by - ay * bx;
      if (det == 0) continue;
      const double px = x - f.x[0], py = y - f.y[0];
      const double s = (px * by - py * bx) / det, t = (ax * py - ay * px) / det;
      if (!(s >= -edge && t >= -edge && s + t <= 1 + edge)) continue;
      const double height = f.z[0] + s * (f.z[1] - f.z[0]) + t * (f.z[2] - f.z[0]);
      const double depth = c.of_a ? z - height : height - z;
      if (depth >= 0) nearest = std::min(nearest, depth);
    }
    return std::isfinite(nearest) ? nearest : -1;
  }

  const Vec3& u() const { return u_; }
  const Vec3& v() const { return v_; }

 private:
  static constexpr double edge = tolerance::on_edge;  // a point on an edge belongs to both sides
  static constexpr std::size_t usual_flats = 64;
  struct Box {
    double low_x, high_x, low_y, high_y;  // enlarged by that
  };
  struct Flat {
    std::array<double, 3> x, y, z;
  };
  Vec3 n_, u_, v_;
  std::array<List<Box>, 2> boxes_;  // of `flats_`
  std::array<List<Flat>, 2> flats_;
};

// Chooses from the candidates, all of one mesh, those farthest in eight directions along the patch, and the farthest
// beyond it: of those equal within `slack` the farthest along the patch's u.
void choose(std::span<const Candidate> all, const Vec3& n, const Vec3& u, const Vec3& v, double slack, WorkMeter& meter,
            List<Candidate>& chosen) {
  constexpr std::size_t at_once = 256;
  constexpr double lean = tolerance::tie_lean;
  if (all.empty()) return;
  const Vec3 beyond = all.front().of_a ? n : Vec3(-n);
  const std::array<Vec3, 10> directions{u, v, u + v, u - v, -u, -v, -u - v, v - u, beyond, beyond + lean * u};
  DirectionRows rows{};
  for (std::size_t k = 0; k < directions.size(); ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      rows.direction[axis][k] = directions[k][static_cast<Eigen::Index>(axis)];
  static_assert(sizeof(Candidate) % sizeof(double) == 0);
  for (std::size_t first = 0; first < all.size(); first += at_once) {
    meter.spend(at_once / 8);
    find_farthest(rows, directions.size(), all.front().point.data(), sizeof(Candidate) / sizeof(double), first,
                  std::min(all.size(), first + at_once));
  }
  std::array<std::size_t, 10> best;
  for (std::size_t k = 0; k < best.size(); ++k) best[k] = static_cast<std::size_t>(rows.best[k]);
  if (beyond.dot(all[best[8]].point - all[best[9]].point) <= slack) best[8] = best[9];
  for (auto at = best.begin(); at != best.end(); ++at)
    if (std::find(best.begin(), at, *at) == at) chosen.push_back(all[*at]);
}

}  // namespace

PatchNormal normal_of(const PosedMeshes& m, const Patch& patch, const Facets& facets,
                      std::span<const Crossing> crossings) {
  const Vec3 base = crossings[patch.crossings[0]].end[0].point;
  Vec3 area = Vec3::Zero(), open = Vec3::Zero(), sides = Vec3::Zero();
  double length = 0;
  WorkMeter meter(m.limit);
  for (const std::uint32_t c : patch.crossings) {
    meter.spend();
    const Vec3 p = crossings[c].end[0].point - base, q = crossings[c].end[1].point - base;
    area += p.cross(q) / 2;
    open += q - p;
    length += (q - p).norm();
  }
  // A closed curve has an area vector; a slit or an open curve (of a surface with a border) has no direction. Two edges
  // that cross make a sliver with the right normal, however thin; a wide patch that thin is noise.
  const double least = patch.vertices.empty() ? tolerance::sliver_patch : tolerance::wide_patch, ample = 1e3;
  if (open.norm() <= tolerance::flush * length &&
      (area.norm() > least * length * length || area.norm() > ample * noise_of(m, patch, crossings)))
    return {unit(area), true, area};
  for (const bool of_a : {true, false})
    for (const Facet& f : facets[of_a ? 1 : 0]) meter.spend(), sides += f.n;
  return {sides.norm() > tolerance::flush ? Vec3(sides.normalized()) : Vec3(Vec3::Zero()), false, area};
}

Vec3 normal_of_face(const PosedMeshes& m, const PatchPoints& points, const Vec3& n) {
  const double slack = tolerance::in_plane * (m.a.half + m.b.half).norm();
  const Facet *of_a = sole_face(points.facets[1], n, slack), *of_b = sole_face(points.facets[0], n, slack);
  if (of_a != nullptr && of_b != nullptr) {
    // The face of the two through which less of the other mesh has passed.
    double beyond_a = 0, beyond_b = 0;
    const auto include = [&](std::span<const Candidate> some) {
      for (const Candidate& c : some) {
        beyond_a = std::max(beyond_a, of_a->n.dot(of_a->p[0] - c.point));
        beyond_b = std::max(beyond_b, of_b->n.dot(c.point - of_b->p[0]));
      }
    };
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) include(points.vertices[k]), include(points.edges[k]);
    return beyond_a <= beyond_b ? of_a->n : of_b->n;
  }
  if (of_a == nullptr && of_b == nullptr) return n;
  return of_a != nullptr ? of_a->n : of_b->n;
}

void find_spans(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings, bool of_a, Memory memory,
                List<RidgeSpan>& spans) {
  const MeshModel& mesh = m.mesh(of_a);
  const auto& neighbours = mesh.neighbours();
  // Each edge belongs to two triangles: count it once.
  const auto is_first = [&](std::uint32_t t, std::uint32_t corner) {
    const std::uint32_t next = neighbours[t][corner];
    return next == no_index || t < next;
  };
  const auto add = [&](std::uint32_t edge, const Vec3& p, const Vec3& q) {
    if (is_ridge(mesh, edge / 3, edge % 3)) spans.push_back({p, q, feature_of(of_a ? 2 : 3, edge)});
  };
  WorkMeter meter(m.limit);
  List<std::uint32_t> inner(memory);
  inner.reserve(patch.vertices.size());
  for (const Candidate& c : patch.vertices)
    if (c.of_a == of_a) inner.push_back(c.feature & 0x3fffffffu);
  sort_metered(meter, inner.begin(), inner.end(), std::less<std::uint32_t>());
  const auto is_inside = [&](std::uint32_t vertex) { return std::binary_search(inner.begin(), inner.end(), vertex); };
  struct Pierced {
    std::uint32_t edge;
    const Piercing* piercing;
  };
  List<Pierced> pierced(memory);
  pierced.reserve(patch.crossings.size());
  for (const std::uint32_t k : patch.crossings) {
    meter.spend();
    for (const Piercing& p : crossings[k].end)
      if (p.edge_of_a == of_a && is_first(p.triangle, p.corner)) pierced.push_back({3 * p.triangle + p.corner, &p});
  }
  sort_metered(meter, pierced.begin(), pierced.end(), [](const Pierced& x, const Pierced& y) {
    return x.edge != y.edge ? x.edge < y.edge : x.piercing->fraction < y.piercing->fraction;
  });
  for (auto at = pierced.begin(); at != pierced.end();) {
    meter.spend(4);
    const std::uint32_t edge = at->edge;
    const Piercing& first = *at->piercing;
    bool is_open = first.from_inside && is_inside(first.from);
    Vec3 begin = is_open ? m.vertex(of_a, first.from) : Vec3(Vec3::Zero());
    for (; at != pierced.end() && at->edge == edge; ++at) {
      if (at->piercing->from_inside && is_open) add(edge, begin, at->piercing->point);
      is_open = !at->piercing->from_inside;
      begin = at->piercing->point;
    }
    if (is_open && is_inside(first.to)) add(edge, begin, m.vertex(of_a, first.to));
  }
  // Of a finer mesh most of a ridge are edges between the pierced ones.
  const auto is_pierced = [&](std::uint32_t edge) {
    const auto at = std::lower_bound(pierced.begin(), pierced.end(), edge,
                                     [](const Pierced& x, std::uint32_t e) { return x.edge < e; });
    return at != pierced.end() && at->edge == edge;
  };
  for (const std::uint32_t t : patch.triangles[of_a ? 1 : 0]) {
    meter.spend();
    const auto& corners = mesh.triangles[t];
    const std::array<bool, 3> inside{is_inside(corners[0]), is_inside(corners[1]), is_inside(corners[2])};
    for (std::uint32_t k = 0; k < 3; ++k)
      if (const std::uint32_t next = (k + 1) % 3; inside[k] && inside[next] && is_first(t, k) && !is_pierced(3 * t + k))
        add(3 * t + k, m.vertex(of_a, corners[k]), m.vertex(of_a, corners[next]));
  }
}

void add_points(const PosedMeshes& m, const PatchPoints& points, const Vec3& n, Memory memory,
                std::vector<Contact>& contacts) {
  const double size = (m.a.half + m.b.half).norm(), slack = tolerance::alike * size;
  WorkMeter meter(m.limit);
  const DepthProbe depth(points.facets, n, m.limit, memory);
  List<Candidate> chosen(memory);
  chosen.reserve(40);
  for (const std::size_t of_a : {std::size_t{1}, std::size_t{0}}) {
    choose(points.vertices[of_a], n, depth.u(), depth.v(), slack, meter, chosen);
    choose(points.edges[of_a], n, depth.u(), depth.v(), slack, meter, chosen);
  }
  const std::size_t first = contacts.size();
  double most = 0;
  const auto add = [&](const Vec3& point, double d, std::uint32_t feature) {
    meter.spend(static_cast<int>((contacts.size() - first) / 16));
    most = std::max(most, d);
    const auto known =
        std::find_if(contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(),
                     [&](const Contact& o) { return (o.point - point).norm() < tolerance::same_place * size; });
    if (known == contacts.end())
      contacts.push_back({point, n, d, feature});
    else
      known->depth = std::max(known->depth, d);
  };
  for (const Candidate& c : chosen) {
    meter.spend();
    if (const double d = depth(c, meter); d >= 0) add(c.point - n * (c.of_a ? d / 2 : -d / 2), d, c.feature);
  }
  const List<const RidgeSpan*> ridges[] = {farthest_spans(points.spans[0], -n, slack, meter, memory),
                                           farthest_spans(points.spans[1], n, slack, meter, memory)};
  for (const RidgeSpan* a : ridges[1])
    for (const RidgeSpan* b : ridges[0]) {
      meter.spend();
      if (Vec3 point = Vec3::Zero(); const auto d = overlap_of_ridges(*a, *b, n, slack, point))
        add(point, *d, a->feature);
    }
  // At the curve the depth is zero: such points matter little beside the deep ones.
  const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
  contacts.erase(std::remove_if(begin, contacts.end(), [&](const Contact& c) { return c.depth < most / 4; }),
                 contacts.end());
  keep_widest(contacts, first, size, &meter);
}

}  // namespace tandem
