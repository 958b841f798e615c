// A mesh and a half-space.
#include <algorithm>
#include <limits>
#include <span>

#include "manifold/manifold.h"
#include "manifold/patch_collector.h"
#include "meshes/mesh_solvers.h"
#include "shapes/mesh_hierarchy.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "shapes/without_hull.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {

PlaneInMesh::PlaneInMesh(const Pose& mesh, const Posed& plane)
    : up((plane.pose.rotation * plane.shape.normal()).normalized()),
      local(mesh.rotation.transpose() * up),
      level(plane.shape.offset() - up.dot(mesh.translation - plane.pose.translation)) {}

PairAnswer solve_vertices_halfspace(const Posed& mesh, const PlaneInMesh& half, std::span<const std::uint32_t> vertices,
                                    double floor, Request request, const NarrowPhaseOptions& options,
                                    std::vector<Contact>* contacts) {
  const MeshModel& m = mesh_of(mesh.shape);
  const auto& [up, local, level] = half;
  PairAnswer answer;
  double lowest = std::numeric_limits<double>::infinity();
  std::uint32_t at = 0;
  const std::size_t first = contacts ? contacts->size() : 0;
  // Relative to the mesh's translation: far from the origin, the positions by which corners are chosen would be
  // rounded.
  const Vec3& origin = mesh.pose.translation;
  const auto turned = [&](std::uint32_t v) -> Vec3 { return mesh.pose.rotation * m.vertices[v]; };
  // Contacts to rounding keep their whole patch.
  const double within = options.margin + tolerance::alike * mesh.shape.size();
  WorkMeter meter(options.limit);
  std::uint32_t seen = 0;
  for (const std::uint32_t v : vertices) {
    if (++seen % 16 == 0) meter.spend();
    const double height = local.dot(m.vertices[v]) - level;
    if (height < floor) continue;
    if (height < lowest) lowest = height, at = v;
    if (request == Request::contacts && height <= within)
      contacts->push_back({turned(v) - up * (height / 2), -up, std::max(-height, -options.margin), v});
  }
  if (request == Request::contacts && lowest > options.margin) contacts->resize(first);
  if (request == Request::contacts) {
    meter.spend(1 + static_cast<int>((contacts->size() - first) / 2));
    keep_widest(*contacts, first, mesh.shape.size());
    for (Contact& c : std::span(*contacts).subspan(first)) c.point += origin;
  }
  answer.collide = lowest <= 0;
  if (request == Request::collide || (request == Request::contacts && contacts->size() == first)) return answer;
  answer.signed_distance = lowest;
  answer.point_a = turned(at) + origin;
  answer.point_b = answer.point_a - up * lowest;
  answer.normal = -up;
  return answer;
}

PairAnswer solve_mesh_halfspace(const Posed& mesh, const PlaneInMesh& half, Request request,
                                const NarrowPhaseOptions& options, std::vector<Contact>* contacts) {
  const MeshModel& m = mesh_of(mesh.shape);
  // For a deforming or large mesh the hull is used only if there is something to report.
  if (does_without_hull(m) && request != Request::distance) {
    const double height = -farthest_along(m, -half.local) - half.level;
    if (request == Request::collide || !(height <= options.margin)) {
      PairAnswer answer;
      answer.collide = height <= 0;
      return answer;
    }
  }
  // The vertices that span the part below the plane are vertices of the hull.
  return solve_vertices_halfspace(mesh, half, m.extreme(options.limit), -infinity, request, options, contacts);
}

}  // namespace tandem
