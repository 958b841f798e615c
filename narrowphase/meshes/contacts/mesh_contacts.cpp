// Contacts of two meshes that intersect: chooses the method for each patch.
#include "meshes/contacts/mesh_contacts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory_resource>

#include "manifold/patch_collector.h"
#include "meshes/contacts/concave_corner.h"
#include "meshes/contacts/crossing_patches.h"
#include "meshes/contacts/face_overlaps.h"
#include "meshes/contacts/patch_points.h"
#include "pairs/convex_pair.h"
#include "shapes/lent_memory.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr std::size_t flat_limit = 512;  // triangles of a patch and mesh among which flat faces are searched

double deepest_depth(std::span<const Contact> contacts) {
  double deepest = 0;
  for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
  return deepest;
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
    return normal.sure ? find_corner(m, facets[of_a ? 1 : 0], of_a, memory) : ConcaveCorner(memory);
  };
  const ConcaveCorner of_first = corner_of(true), of_second = corner_of(false);
  const bool in_corner = of_first.faces.empty() != of_second.faces.empty();
  // Every triangle of one is tested against every one of the other.
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
  std::array<List<RidgeSpan>, 2> spans{List<RidgeSpan>(memory), List<RidgeSpan>(memory)};
  const std::size_t fewer = edges[0].size() < edges[1].size() ? 0 : 1;
  find_spans(m, patch, crossings, fewer == 1, memory, spans[fewer]);
  if (!spans[fewer].empty()) find_spans(m, patch, crossings, fewer == 0, memory, spans[1 - fewer]);
  const std::span<const Candidate> vertices(patch.vertices);
  const std::size_t of_b = static_cast<std::size_t>(
      std::find_if(vertices.begin(), vertices.end(), [](const Candidate& c) { return !c.of_a; }) - vertices.begin());
  const PatchPoints points{
      {vertices.subspan(of_b), vertices.first(of_b)}, {edges[0], edges[1]}, {spans[0], spans[1]}, facets};
  if (in_corner) {
    const ConcaveCorner& corner = of_first.faces.empty() ? of_second : of_first;
    for (const ConcaveCornerFace& face : corner.faces) add_corner_face(m, points, corner, face, memory, contacts);
    return {true, true};
  }
  add_points(m, points, normal.sure ? normal_of_face(m, points, normal.n) : normal.n, memory, contacts);
  return {normal.sure, false};
}

// The deepest pair of triangles of a patch, as a contact; of equally deep ones by position, in whatever order they
// come.
Contact deepest_pair(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings) {
  Contact deepest{Vec3::Zero(), Vec3::Zero(), 0, of_no_feature};
  WorkMeter meter(m.limit);
  for (const std::uint32_t k : patch.crossings) {
    meter.spend(16);
    const auto [i, j] = crossings[k].triangles;
    const Corners p = m.corners(true, i), q = m.corners(false, j);
    // No deeper than along a direction.
    if (most_along(deepest.normal, p) - least_along(deepest.normal, q) < deepest.depth) continue;
    const PairAnswer r = solve_convex(TriangleView(p), {}, TriangleView(q), {}, Request::distance, {}, nullptr);
    const Vec3 point = (r.point_a + r.point_b) / 2;
    const double depth = -r.signed_distance;
    if (depth > deepest.depth ||
        (depth == deepest.depth &&
         std::lexicographical_compare(point.begin(), point.end(), deepest.point.begin(), deepest.point.end())))
      deepest.point = point, deepest.normal = r.normal, deepest.depth = depth;
  }
  return deepest;
}

struct Sides : PatchSides {
  double deepest = 0;  // along the patches' normals
};

Sides add_patches(const PosedMeshes& m, std::span<const TrianglePair> pairs, const NarrowPhaseOptions& options,
                  std::vector<Contact>& contacts) {
  alignas(std::max_align_t) std::array<std::byte, usual_memory> usual;
  std::pmr::monotonic_buffer_resource memory(usual.data(), usual.size(), lent_memory(options));
  const std::size_t first = contacts.size();
  const CrossingPatches found(m, pairs, options.parts, &memory);
  // Overlaps along one normal form one patch, as with a convex shape.
  PatchCollector overlaps((m.a.half + m.b.half).norm(), options);
  List<Contact> of_pairs(&memory);
  const double no_depth = tolerance::translation_slack * (m.a.half + m.b.half).norm();
  Sides sides;
  sides.sure = true;
  WorkMeter meter(options.limit);
  for (const Patch& patch : found.patches()) {
    meter.spend(8);
    const std::size_t before = contacts.size();
    const PatchSides here = add_patch(m, patch, found.crossings(), &memory, overlaps, contacts);
    sides.sure = sides.sure && here.sure;
    sides.in_corner = sides.in_corner || here.in_corner;
    if (here.sure || deepest_depth(std::span(contacts).subspan(before)) > no_depth) continue;
    // All its points lie on its curve, so its normal leads nowhere, unless its triangles only touch.
    const Contact pair = deepest_pair(m, patch, found.crossings());
    if (!(pair.depth > no_depth)) continue;
    contacts.resize(before);
    of_pairs.push_back(pair);
  }
  overlaps.finish(Vec3::Zero(), false, contacts);
  sides.deepest = deepest_depth(std::span(contacts).subspan(first));
  if (sides.deepest > 0.25 * std::min(m.a.half.norm(), m.b.half.norm()) || sides.deepest < no_depth) sides.sure = false;
  contacts.insert(contacts.end(), of_pairs.begin(), of_pairs.end());
  return sides;
}

}  // namespace

PatchSides patch_contacts(const MeshModel& a, const MeshModel& b, const TriangleTest& frame,
                          std::span<const TrianglePair> pairs, const NarrowPhaseOptions& options,
                          std::vector<Contact>& contacts) {
  const std::size_t first = contacts.size();
  const double slack = tolerance::alike * (a.half + b.half).norm();
  Sides taken;  // sides of the patches in `contacts`
  for (const bool turned_a : {false, true})
    for (const bool turned_b : {false, true}) {
      if ((turned_a && a.closed) || (turned_b && b.closed)) continue;
      const bool is_first = !turned_a && !turned_b;
      const std::size_t known = contacts.size();
      const Sides sides = add_patches({a, b, frame, turned_a, turned_b, options.limit}, pairs, options, contacts);
      if (!is_first) {
        // The shorter translation, if any. Patches whose points all lie on their curves, at no depth, know none.
        const bool has_depth = sides.deepest > slack, had_depth = taken.deepest > slack;
        const bool shorter = has_depth && (!had_depth || sides.deepest < taken.deepest - slack);
        const bool better = known == first || sides.sure > taken.sure || (sides.sure == taken.sure && shorter);
        if (contacts.size() == known || !better) {
          contacts.resize(known);
          continue;
        }
        contacts.erase(contacts.begin() + static_cast<std::ptrdiff_t>(first),
                       contacts.begin() + static_cast<std::ptrdiff_t>(known));
      }
      taken = sides;
    }
  sort_contacts(std::span(contacts).subspan(first));
  return taken;
}

}  // namespace tandem
