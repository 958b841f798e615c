#include "meshes/contacts/mesh_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory_resource>
#include <optional>

#include "closed_forms/closed_forms.h"
#include "manifold/manifold.h"
#include "manifold/patch_collector.h"
#include "meshes/contacts/crossing_patches.h"
#include "meshes/contacts/face_overlaps.h"
#include "shapes/metered_sort.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"
#include "triangles/patch_rows.h"

namespace tandem {
namespace {

constexpr std::size_t span_limit = 16;   // ridges of a patch that are held against those of the other mesh
constexpr std::size_t flat_limit = 512;  // triangles of a patch and mesh among which flat faces are looked for
using tolerance::same_place;             // points nearer than this times the size are one

struct PatchNormal {
  Vec3 n;             // unit, from A to B; zero if there is none
  bool sure = false;  // of a curve with an area
  Vec3 area;          // of the curve
};

// What rounding may make of the area of a patch's curve: its points lie in both triangles' planes to rounding, the less
// exactly the flatter these cross.
double noise_of(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings) {
  const auto normal = [&](bool of_a, std::uint32_t t) {
    const auto p = m.corners(of_a, t);
    return unit((p[1] - p[0]).cross(p[2] - p[0]));
  };
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
  // A curve that closes has an area; a slit or an open curve (of a surface with a border) has no direction.
  // Two edges that cross make a sliver with the right normal, however thin; a wide patch that thin is noise.
  const double least = patch.vertices.empty() ? tolerance::sliver_patch : tolerance::wide_patch, ample = 1e3;
  if (open.norm() <= tolerance::flush * length &&
      (area.norm() > least * length * length || area.norm() > ample * noise_of(m, patch, crossings)))
    return {unit(area), true, area};
  for (const bool of_a : {true, false})
    for (const Facet& f : facets[of_a ? 1 : 0]) meter.spend(), sides += f.n;
  return {sides.norm() > tolerance::flush ? Vec3(sides.normalized()) : Vec3(Vec3::Zero()), false, area};
}

// How far `point` of one mesh lies beyond the other's surface, measured along `n` (from A to B); negative if nothing of
// that surface is there.
class DepthProbe {
 public:
  DepthProbe(const Facets& facets, const Vec3& n, const WorkLimit* limit, Memory memory)
      : n_(n), flats_{List<Flat>(memory), List<Flat>(memory)} {
    u_ = uncommon(n).normalized();
    v_ = n.cross(u_);
    WorkMeter meter(limit);
    for (const std::size_t of_a : {std::size_t{1}, std::size_t{0}}) {
      flats_[of_a].reserve(std::min(facets[of_a].size(), usual_flats));
      for (const Facet& facet : facets[of_a]) {
        meter.spend();
        const auto& p = facet.p;
        // Only the sides that face each other, not those along n but for what little a pose is off.
        if (!(facet.n.dot(n) > tolerance::flush)) continue;
        Flat f;
        for (std::size_t k = 0; k < 3; ++k) f.x[k] = u_.dot(p[k]), f.y[k] = v_.dot(p[k]), f.z[k] = n.dot(p[k]);
        const auto [low_x, high_x] = std::minmax({f.x[0], f.x[1], f.x[2]});
        const auto [low_y, high_y] = std::minmax({f.y[0], f.y[1], f.y[2]});
        const double slack = 4 * edge * (high_x - low_x + high_y - low_y) +
                             tolerance::place_rounding_of_nearest * (std::abs(f.x[0]) + std::abs(f.y[0]));
        f.low_x = low_x - slack, f.high_x = high_x + slack, f.low_y = low_y - slack, f.high_y = high_y + slack;
        flats_[of_a].push_back(f);
      }
    }
  }

  double operator()(const Candidate& c, WorkMeter& meter) const {
    const double x = u_.dot(c.point), y = v_.dot(c.point), z = n_.dot(c.point);
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t seen = 0;
    for (const Flat& f : flats_[c.of_a ? 0 : 1]) {
      if (seen++ % 32 == 0) meter.spend();
      if (!(x >= f.low_x && x <= f.high_x && y >= f.low_y && y <= f.high_y)) continue;
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
  struct Flat {
    double low_x, high_x, low_y, high_y;  // wide enough for that
    std::array<double, 3> x, y, z;
  };
  Vec3 n_, u_, v_;
  std::array<List<Flat>, 2> flats_;
};

// The stretch of a ridge inside the other mesh.
struct Span {
  Vec3 p, q;
  std::uint32_t feature;
};

// Do the two triangles at the edge lie behind each other's planes, or is it a border? Only such edges can be deepest
// where they cross one of the other mesh. Of a surface with a border either side may be the outer one: all count.
bool is_ridge(const MeshModel& mesh, std::uint32_t t, std::uint32_t corner) {
  const std::uint32_t next = mesh.neighbours[t][corner];
  if (next == no_index || !mesh.closed) return true;
  const auto p = mesh.corners(t), q = mesh.corners(next);
  const Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]);
  const auto& back = mesh.neighbours[next];
  const auto shared = static_cast<std::size_t>(std::find(back.begin(), back.end(), t) - back.begin());
  return n.dot(q[(shared + 2) % 3] - p[0]) < -tolerance::in_plane * n.norm() * mesh.half.norm();
}

// What of the ridges of a mesh lies inside the other: between two piercings, or from one to an end that is inside. Of
// those that lie inside as a whole the ends say enough.
void find_spans(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings, bool of_a, Memory memory,
                List<Span>& spans) {
  const MeshModel& mesh = m.mesh(of_a);
  // Each edge is seen from both of its triangles.
  const auto is_first = [&](std::uint32_t t, std::uint32_t corner) {
    const std::uint32_t next = mesh.neighbours[t][corner];
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
}

// How far two such stretches, of A and of B, reach past each other where they cross as seen along n: within `slack` of
// their ends, too, which lie over the other's where a face stands along n.
std::optional<double> over(const Span& a, const Span& b, const Vec3& n, double slack, Vec3& point) {
  const Vec3 d = a.q - a.p, e = b.q - b.p, r = b.p - a.p;
  const double det = n.dot(d.cross(e));
  // Where two that are parallel cross is rounding's doing; what lies over their ends is known without.
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

// As many of the stretches as are held against others: those that reach farthest along n, of alike ones those that lie
// farthest along a direction of their own.
List<const Span*> farthest_spans(std::span<const Span> spans, const Vec3& n, double slack, Memory memory) {
  List<const Span*> out(memory);
  out.reserve(spans.size());
  for (const Span& s : spans) out.push_back(&s);
  if (spans.size() <= span_limit) return out;
  const Vec3 tie_break = uncommon(n);
  const auto reach = [&](const Span* s) { return std::round(std::max(n.dot(s->p), n.dot(s->q)) / slack); };
  const auto aside = [&](const Span* s) { return tie_break.dot(s->p + s->q); };
  const auto last = out.begin() + span_limit;
  std::nth_element(out.begin(), last, out.end(), [&](const Span* x, const Span* y) {
    return reach(x) != reach(y) ? reach(x) > reach(y) : aside(x) > aside(y);
  });
  out.erase(last, out.end());
  return out;
}

// The candidates, all of one mesh, farthest out in eight directions along the patch, and the farthest beyond it: of
// those that are as far but for `slack` the farthest along the patch's u.
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

// One of several planes that enclose a concave corner, as of a room.
struct CornerFace {
  Vec3 n;  // unit, from A to B
  double level;
  List<Facet> facets;
};

struct Corner {
  explicit Corner(Memory memory) : faces(memory) {}
  List<CornerFace> faces;  // none: it is no corner
  bool of_a = false;
};

// The planes of a mesh's triangles of a patch, where these are few and each lies in front of the others: what has come
// into such a corner is pushed by each of them. Most patches bend to the other side somewhere, which shows early.
Corner find_corner(const PosedMeshes& m, std::span<const Facet> facets, bool of_a, Memory memory) {
  constexpr std::size_t most = 4;
  struct Plane {
    Vec3 n;
    double level;
  };
  const double slack = tolerance::in_plane * (m.a.half + m.b.half).norm(), side = of_a ? 1 : -1;
  std::array<Plane, most> planes;
  std::size_t count = 0;
  // How far a triangle reaches in front of a plane, least and most.
  const auto heights = [&](const Plane& f, const std::array<Vec3, 3>& p) {
    return std::minmax(
        {side * (f.n.dot(p[0]) - f.level), side * (f.n.dot(p[1]) - f.level), side * (f.n.dot(p[2]) - f.level)});
  };
  Corner corner(memory);
  corner.of_a = of_a;
  bool is_bent = false;
  WorkMeter meter(m.limit);
  for (const Facet& facet : facets) {
    meter.spend();
    bool is_known = false;
    for (std::size_t k = 0; k < count && !is_known; ++k) {
      const auto [low, high] = heights(planes[k], facet.p);
      if (low < -slack) return corner;
      is_known = high <= slack;
    }
    if (is_known) continue;
    if (count == most) return corner;
    for (std::size_t k = 0; k < count; ++k) is_bent = is_bent || planes[k].n.dot(facet.n) < one_patch;
    planes[count++] = {facet.n, facet.n.dot(facet.p[0])};
  }
  if (!is_bent) return corner;
  for (const Plane& f : std::span(planes).first(count)) corner.faces.push_back({f.n, f.level, List<Facet>(memory)});
  for (const Facet& facet : facets) {
    meter.spend();
    for (std::size_t k = 0; k < count; ++k) {
      const auto [low, high] = heights(planes[k], facet.p);
      if (low < -slack) {
        corner.faces.clear();
        return corner;
      }
      if (high <= slack) corner.faces[k].facets.push_back(facet);
    }
  }
  return corner;
}

// Of a patch, what does not depend on the direction along which it is measured; of B, of A.
struct PatchPoints {
  std::array<std::span<const Candidate>, 2> vertices, edges;
  std::array<std::span<const Span>, 2> spans;
  Facets facets;
};

// Adds the contacts of a patch along n.
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
    most = std::max(most, d);
    const auto known = std::find_if(contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(),
                                    [&](const Contact& o) { return (o.point - point).norm() < same_place * size; });
    if (known == contacts.end())
      contacts.push_back({point, n, d, feature});
    else
      known->depth = std::max(known->depth, d);
  };
  for (const Candidate& c : chosen) {
    meter.spend();
    if (const double d = depth(c, meter); d >= 0) add(c.point - n * (c.of_a ? d / 2 : -d / 2), d, c.feature);
  }
  const List<const Span*> ridges[] = {farthest_spans(points.spans[0], -n, slack, memory),
                                      farthest_spans(points.spans[1], n, slack, memory)};
  for (const Span* a : ridges[1])
    for (const Span* b : ridges[0])
      if (Vec3 point = Vec3::Zero(); const auto d = over(*a, *b, n, slack, point)) add(point, *d, a->feature);
  // Where the surfaces cross the depth is nothing: such points say little beside the deep ones.
  const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
  contacts.erase(std::remove_if(begin, contacts.end(), [&](const Contact& c) { return c.depth < most / 4; }),
                 contacts.end());
  keep_widest(contacts, first, size, &meter);
}

// What was moved along a face may have left the other mesh, which leans there. A contact that is farther than half its
// depth from a mesh goes to the nearest point of the curve, which lies on both; of two that go to one the deeper stays.
void keep_on_both(const PosedMeshes& m, const PatchPoints& points, std::size_t first, std::vector<Contact>& contacts) {
  const double size = (m.a.half + m.b.half).norm();
  WorkMeter meter(m.limit);
  const auto is_near = [&](const Contact& c, std::span<const Facet> facets) {
    return std::any_of(facets.begin(), facets.end(), [&](const Facet& f) {
      meter.spend();
      const TriangleView triangle(f.p);
      return point_distance(triangle, c.point).signed_distance <= c.depth / 2 + tolerance::in_plane * size;
    });
  };
  for (Contact& c : std::span(contacts).subspan(first)) {
    if (is_near(c, points.facets[0]) && is_near(c, points.facets[1])) continue;
    const Vec3 from = c.point;
    double least = infinity;
    for (const std::span<const Candidate> edges : points.edges)
      for (const Candidate& e : edges)
        if (const double away = (e.point - from).norm(); away < least - tolerance::alike * size)
          least = away, c.point = e.point;
  }
  std::size_t end = first;
  for (std::size_t k = first; k < contacts.size(); ++k) {
    std::size_t same = first;
    while (same < end && !((contacts[same].point - contacts[k].point).norm() < same_place * size)) ++same;
    if (same == end)
      contacts[end++] = contacts[k];
    else if (contacts[k].depth > contacts[same].depth)
      contacts[same] = contacts[k];
  }
  contacts.resize(end);
}

// As `add_points` for one of a corner's faces: of its own mesh only what lies in it counts, and what of the other has
// gone through another face, too, lies over its border there.
void add_corner_face(const PosedMeshes& m, const PatchPoints& points, const Corner& corner, const CornerFace& face,
                     Memory memory, std::vector<Contact>& contacts) {
  const std::size_t own = corner.of_a ? 1 : 0;
  const double slack = tolerance::in_plane * (m.a.half + m.b.half).norm(), side = corner.of_a ? 1 : -1;
  Facets facets = points.facets;
  facets[own] = face.facets;
  const auto is_beside = [&](const Vec3& p) { return std::abs(face.n.dot(p) - face.level) > slack; };
  const auto there = [&](std::span<const Candidate> from, bool is_own) {
    List<Candidate> to(memory);
    for (Candidate c : from) {
      if (is_own && is_beside(c.point)) continue;
      for (const CornerFace& other : corner.faces) {
        const double ahead = other.n.dot(c.point) - other.level;
        const Vec3 across = other.n - other.n.dot(face.n) * face.n;
        if (!is_own && side * ahead < 0 && across.squaredNorm() > tolerance::slanting2)
          c.point -= (ahead / across.squaredNorm()) * across;
      }
      to.push_back(c);
    }
    return to;
  };
  const std::array<List<Candidate>, 2> vertices{there(points.vertices[0], own == 0),
                                                there(points.vertices[1], own == 1)},
      edges{there(points.edges[0], own == 0), there(points.edges[1], own == 1)};
  // An edge in a face, or between two, is no ridge that another edge could lie on.
  const PatchPoints on_it{{vertices[0], vertices[1]}, {edges[0], edges[1]}, {}, facets};
  const std::size_t first = contacts.size();
  add_points(m, on_it, face.n, memory, contacts);
  keep_on_both(m, points, first, contacts);
}

// The one plane of a mesh's triangles of a patch that faces the other along n; nullptr if there are several.
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

// The curve of what has come through a flat face goes round the face's edge, too, where it lies over that: a little off
// the face's normal, which is the shorter translation.
Vec3 normal_of_face(const PosedMeshes& m, const PatchPoints& points, const Vec3& n) {
  const double slack = tolerance::in_plane * (m.a.half + m.b.half).norm();
  const Facet *of_a = sole_face(points.facets[1], n, slack), *of_b = sole_face(points.facets[0], n, slack);
  if (of_a != nullptr && of_b != nullptr) {
    // Of two that which less has come through.
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

PatchSides add_patch(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings, Memory memory,
                     PatchCollector& overlaps, std::vector<Contact>& contacts) {
  WorkMeter meter(m.limit);
  std::array<List<Facet>, 2> all{List<Facet>(memory), List<Facet>(memory)};
  for (const std::size_t of_a : {std::size_t{0}, std::size_t{1}}) {
    all[of_a].reserve(patch.triangles[of_a].size());
    for (const std::uint32_t t : patch.triangles[of_a]) {
      meter.spend();
      all[of_a].push_back(facet_of(m, of_a == 1, t));
    }
  }
  const Facets facets{all[0], all[1]};
  const PatchNormal normal = normal_of(m, patch, facets, crossings);
  const auto corner_of = [&](bool of_a) {
    return normal.sure ? find_corner(m, facets[of_a ? 1 : 0], of_a, memory) : Corner(memory);
  };
  const Corner of_first = corner_of(true), of_second = corner_of(false);
  const bool in_corner = of_first.faces.empty() != of_second.faces.empty();
  // Every triangle of the one is held against every one of the other.
  const Facets some{facets[0].first(std::min(facets[0].size(), flat_limit)),
                    facets[1].first(std::min(facets[1].size(), flat_limit))};
  if (!in_corner &&
      add_face_overlaps(m, some, normal.sure ? normal.area : Vec3(Vec3::Zero()), memory, overlaps, contacts))
    return {true, false};
  if (normal.n.isZero()) return {};
  std::array<List<Candidate>, 2> edges{List<Candidate>(memory), List<Candidate>(memory)};
  for (List<Candidate>& some : edges) some.reserve(2 * patch.crossings.size());
  for (const std::uint32_t k : patch.crossings) {
    meter.spend();
    for (const Piercing& p : crossings[k].end)
      edges[p.edge_of_a ? 1 : 0].push_back(
          {p.point, p.edge_of_a, feature_of(p.edge_of_a ? 2 : 3, 3 * p.triangle + p.corner)});
  }
  std::array<List<Span>, 2> spans{List<Span>(memory), List<Span>(memory)};
  const std::size_t fewer = edges[0].size() < edges[1].size() ? 0 : 1;
  find_spans(m, patch, crossings, fewer == 1, memory, spans[fewer]);
  if (!spans[fewer].empty()) find_spans(m, patch, crossings, fewer == 0, memory, spans[1 - fewer]);
  const std::span<const Candidate> vertices(patch.vertices);
  const std::size_t of_b = static_cast<std::size_t>(
      std::find_if(vertices.begin(), vertices.end(), [](const Candidate& c) { return !c.of_a; }) - vertices.begin());
  const PatchPoints points{
      {vertices.subspan(of_b), vertices.first(of_b)}, {edges[0], edges[1]}, {spans[0], spans[1]}, facets};
  if (in_corner) {
    const Corner& corner = of_first.faces.empty() ? of_second : of_first;
    for (const CornerFace& face : corner.faces) add_corner_face(m, points, corner, face, memory, contacts);
    return {true, true};
  }
  add_points(m, points, normal.sure ? normal_of_face(m, points, normal.n) : normal.n, memory, contacts);
  return {normal.sure, false};
}

struct Sides : PatchSides {
  double deepest = 0;
};

Sides add_patches(const PosedMeshes& m, std::span<const TrianglePair> pairs, const NarrowPhaseOptions& options,
                  std::vector<Contact>& contacts) {
  alignas(std::max_align_t) std::array<std::byte, usual_memory> usual;
  std::pmr::monotonic_buffer_resource memory(usual.data(), usual.size());
  const std::size_t first = contacts.size();
  const CrossingPatches found(m, pairs, options.parts, &memory);
  PatchCollector overlaps((m.a.half + m.b.half).norm(),
                          options.limit);  // those along one normal are one patch, as with a convex shape
  Sides sides;
  sides.sure = true;
  WorkMeter meter(options.limit);
  for (const Patch& patch : found.patches()) {
    meter.spend(8);
    const PatchSides here = add_patch(m, patch, found.crossings(), &memory, overlaps, contacts);
    sides.sure = sides.sure && here.sure;
    sides.in_corner = sides.in_corner || here.in_corner;
  }
  overlaps.finish(Vec3::Zero(), false, contacts);
  for (std::size_t c = first; c < contacts.size(); ++c) sides.deepest = std::max(sides.deepest, contacts[c].depth);
  if (sides.deepest > 0.25 * std::min(m.a.half.norm(), m.b.half.norm()) ||
      sides.deepest < tolerance::no_depth * (m.a.half + m.b.half).norm())
    sides.sure = false;
  return sides;
}

}  // namespace

PatchSides patch_contacts(const MeshModel& a, const MeshModel& b, const TriangleTest& frame,
                          std::span<const TrianglePair> pairs, const NarrowPhaseOptions& options,
                          std::vector<Contact>& contacts) {
  const std::size_t first = contacts.size();
  const double slack = tolerance::alike * (a.half + b.half).norm();
  Sides taken;  // those in `contacts`
  std::vector<Contact> found;
  for (const bool turned_a : {false, true})
    for (const bool turned_b : {false, true}) {
      if ((turned_a && a.closed) || (turned_b && b.closed)) continue;
      const bool is_first = !turned_a && !turned_b;
      std::vector<Contact>& here = is_first ? contacts : found;
      if (!is_first) found.clear();
      const Sides sides = add_patches({a, b, frame, turned_a, turned_b, options.limit}, pairs, options, here);
      if (!is_first) {
        // The shorter translation, if any.
        const bool better = contacts.size() == first || sides.sure > taken.sure ||
                            (sides.sure == taken.sure && sides.deepest < taken.deepest - slack);
        if (found.empty() || !better) continue;
        contacts.resize(first);
        contacts.insert(contacts.end(), found.begin(), found.end());
      }
      taken = sides;
    }
  sort_contacts(std::span(contacts).subspan(first));
  return taken;
}

}  // namespace tandem
