#include "meshes/contacts/ridge_spans.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "manifold/patch_collector.h"
#include "shapes/metered_sort.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr std::size_t span_limit = 16;  // ridges of a patch that are held against those of the other mesh

// Do the two triangles at the edge lie behind each other's planes, or is it a border? Only such edges can be deepest
// where they cross one of the other mesh. Of a surface with a border either side may be the outer one: all count.
bool is_ridge(const MeshModel& mesh, std::uint32_t t, std::uint32_t corner) {
  const std::uint32_t next = mesh.neighbours()[t][corner];
  if (next == no_index || !mesh.closed) return true;
  const auto p = mesh.corners(t), q = mesh.corners(next);
  const Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]);
  const auto& back = mesh.neighbours()[next];
  const auto shared = static_cast<std::size_t>(std::find(back.begin(), back.end(), t) - back.begin());
  return n.dot(q[(shared + 2) % 3] - p[0]) < -tolerance::in_plane * n.norm() * mesh.half.norm();
}

}  // namespace

void find_spans(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings, bool of_a, Memory memory,
                List<RidgeSpan>& spans) {
  const MeshModel& mesh = m.mesh(of_a);
  // Each edge is seen from both of its triangles.
  const auto is_first = [&](std::uint32_t t, std::uint32_t corner) {
    const std::uint32_t next = mesh.neighbours()[t][corner];
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

std::optional<double> overlap_of_ridges(const RidgeSpan& a, const RidgeSpan& b, const Vec3& n, double slack,
                                        Vec3& point) {
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

List<const RidgeSpan*> farthest_spans(std::span<const RidgeSpan> spans, const Vec3& n, double slack, Memory memory) {
  List<const RidgeSpan*> out(memory);
  out.reserve(spans.size());
  for (const RidgeSpan& s : spans) out.push_back(&s);
  if (spans.size() <= span_limit) return out;
  const Vec3 tie_break = uncommon(n);
  const auto reach = [&](const RidgeSpan* s) { return std::round(std::max(n.dot(s->p), n.dot(s->q)) / slack); };
  const auto aside = [&](const RidgeSpan* s) { return tie_break.dot(s->p + s->q); };
  const auto last = out.begin() + span_limit;
  std::nth_element(out.begin(), last, out.end(), [&](const RidgeSpan* x, const RidgeSpan* y) {
    return reach(x) != reach(y) ? reach(x) > reach(y) : aside(x) > aside(y);
  });
  out.erase(last, out.end());
  return out;
}

}  // namespace tandem
