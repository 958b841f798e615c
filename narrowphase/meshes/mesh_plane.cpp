// A mesh and a two-sided plane: separated, or, where triangles cross it, as a mesh and the half-space on one of its
// sides.
#include <algorithm>
#include <limits>
#include <vector>

#include "meshes/mesh_solvers.h"
#include "meshes/traversal/hierarchy.h"
#include "shapes/mesh_hierarchy.h"
#include "shapes/shape_insides.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {

PlaneGaps plane_gaps(const MeshModel& mesh, const PlaneInMesh& plane, const WorkLimit* limit) {
  const Vec3 extent = plane.local.cwiseAbs();
  const double slack = tolerance::place_rounding * (mesh.centre.norm() + mesh.half.norm() + std::abs(plane.level));
  PlaneGaps gaps;
  const auto include = [&](std::uint32_t triangle) {
    double lo = infinity, hi = -infinity;
    std::uint32_t lowest = 0, highest = 0;
    for (const std::uint32_t v : mesh.triangles[triangle]) {
      const double height = plane.local.dot(mesh.vertices[v]) - plane.level;
      if (height < lo) lo = height, lowest = v;
      if (height > hi) hi = height, highest = v;
    }
    if (lo <= 0 && hi >= 0) gaps.cut = true;
    if (lo > 0 && lo < gaps.above) gaps.above = lo, gaps.vertex_above = lowest;
    if (hi < 0 && -hi < gaps.below) gaps.below = -hi, gaps.vertex_below = highest;
  };
  WorkMeter meter(limit);
  std::vector<std::uint32_t> stack{whole};
  while (!stack.empty() && !gaps.cut) {
    const std::uint32_t at = stack.back();
    stack.pop_back();
    meter.spend();
    each_child(mesh, at, [&](std::uint32_t child) {
      const BoxOf box(mesh, child);
      const double middle = plane.local.dot(box.mid) - plane.level, reach = extent.dot(box.half) + slack;
      if (middle - reach >= gaps.above || -(middle + reach) >= gaps.below) return;
      if (is_leaf(mesh, child)) return include(leaf_triangle(mesh, child));
      stack.push_back(child);
    });
  }
  return gaps;
}

namespace {

/// The height interval of a triangle above the plane.
struct Span {
  double lo, hi;
};

/// The mesh may be moved along the plane's normal until a height without triangles is at the plane: the interval
/// between the nearest such heights, for a triangle that meets the plane. Connected triangles leave no such heights.
Span covered(const MeshModel& mesh, const PlaneInMesh& plane, const WorkLimit* limit) {
  WorkMeter meter(limit);
  std::vector<Span> spans;
  spans.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    if (spans.size() % 16 == 0) meter.spend();
    Span& span = spans.emplace_back(Span{infinity, -infinity});
    for (const std::uint32_t v : t) {
      const double height = plane.local.dot(mesh.vertices[v]) - plane.level;
      span.lo = std::min(span.lo, height), span.hi = std::max(span.hi, height);
    }
  }
  std::sort(spans.begin(), spans.end(), [](const Span& x, const Span& y) { return x.lo < y.lo; });
  Span joined = spans.front();
  for (const Span& next : spans) {
    if (next.lo <= joined.hi) {
      joined.hi = std::max(joined.hi, next.hi);
    } else if (joined.hi >= 0) {
      break;
    } else {
      joined = next;
    }
  }
  return joined;
}

/// Each position with a corner of a triangle, once.
std::vector<std::uint32_t> places_in_use(const MeshModel& mesh) {
  std::vector<std::uint32_t> places;
  places.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) places.push_back(mesh.representative(v));
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

}  // namespace

PairAnswer solve_mesh_plane(const Posed& mesh, const PlaneInMesh& plane, Request request,
                            const NarrowPhaseOptions& options, std::vector<Contact>* contacts) {
  const MeshModel& m = mesh_of(mesh.shape);
  const PlaneGaps gaps = plane_gaps(m, plane, options.limit);
  PairAnswer answer;
  answer.collide = gaps.cut;
  if (request == Request::collide) return answer;
  if (gaps.cut ? m.components(options.limit).size() == 1 : std::max(gaps.above, gaps.below) == infinity) {
    // Out on the side beyond which the mesh reaches less; if separated, on its side.
    const double above = -farthest_along(m, -plane.local) - plane.level,
                 below = plane.level - farthest_along(m, plane.local);
    return solve_mesh_halfspace(mesh, below > above ? plane.turned_over() : plane, request, options, contacts);
  }
  // In components: those beyond the height at which it comes out do not touch.
  const Span out = gaps.cut ? covered(m, plane, options.limit) : Span{gaps.above, -gaps.below};
  const bool over = gaps.cut ? -out.lo <= out.hi : gaps.above <= gaps.below;
  answer.signed_distance = over ? out.lo : -out.hi;
  if (gaps.cut || (request == Request::contacts && answer.signed_distance <= options.margin))
    return solve_vertices_halfspace(mesh, over ? plane : plane.turned_over(), places_in_use(m), answer.signed_distance,
                                    request, options, contacts);
  answer.normal = over ? Vec3(-plane.up) : plane.up;
  answer.point_a = mesh.pose * m.vertices[over ? gaps.vertex_above : gaps.vertex_below];
  answer.point_b = answer.point_a + answer.signed_distance * answer.normal;
  return answer;
}

}  // namespace tandem
