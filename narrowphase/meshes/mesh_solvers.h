// The solvers of a mesh with another shape, by the kind of that, and their common functions.
#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// A plane, or that of a half-space, in the mesh's frame: local . x = level.
struct PlaneInMesh {
  Vec3 up;     ///< its normal in the world
  Vec3 local;  ///< its normal in the mesh's frame
  double level;

  PlaneInMesh(const Pose& mesh, const Posed& plane);
  PlaneInMesh(const Vec3& up, const Vec3& local, double level) : up(up), local(local), level(level) {}
  PlaneInMesh turned_over() const { return {-up, -local, -level}; }
};

/// The distances of a mesh to a plane on either side, by triangles that do not cross it; infinity without any.
struct PlaneGaps {
  double above = std::numeric_limits<double>::infinity(), below = above;
  std::uint32_t vertex_above = 0, vertex_below = 0;
  bool cut = false;  ///< a triangle meets the plane: nothing else is set
};
PlaneGaps plane_gaps(const MeshModel& mesh, const PlaneInMesh& plane, const WorkLimit* limit);

/// The solvers by the kind of the other shape; the mesh comes first. Contacts are appended for Request::contacts only.
PairAnswer solve_meshes(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                        std::vector<Contact>* contacts);  ///< both have triangles, goes_first(a, b)
PairAnswer solve_mesh_halfspace(const Posed& mesh, const PlaneInMesh& half, Request request,
                                const NarrowPhaseOptions& options, std::vector<Contact>* contacts);
/// A half-space and only these of a mesh's vertices, of which those at least `floor` above the plane count.
PairAnswer solve_vertices_halfspace(const Posed& mesh, const PlaneInMesh& half, std::span<const std::uint32_t> vertices,
                                    double floor, Request request, const NarrowPhaseOptions& options,
                                    std::vector<Contact>* contacts);
PairAnswer solve_mesh_plane(const Posed& mesh, const PlaneInMesh& plane, Request request,
                            const NarrowPhaseOptions& options, std::vector<Contact>* contacts);
PairAnswer solve_mesh_convex(const Posed& mesh, const Posed& convex, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts);  ///< bounded; may be a solid mesh equal to its hull

/// The options for single triangles of a mesh: a named solver is one for meshes.
inline NarrowPhaseOptions for_triangles(const NarrowPhaseOptions& options) {
  NarrowPhaseOptions o = options;
  o.solver.clear();  // it was the name of a solver for meshes
  return o;
}

/// The answer's points as one contact.
inline Contact contact_of(const PairAnswer& r, std::uint32_t feature = 0) {
  return {(r.point_a + r.point_b) / 2, r.normal, -r.signed_distance, feature};
}

/// Moves an answer, and its contacts from `first` on if there are any, from about zero to about `origin`.
inline void move_answer(const Vec3& origin, PairAnswer& answer, std::vector<Contact>* contacts, std::size_t first) {
  answer.point_a += origin;
  answer.point_b += origin;
  if (contacts == nullptr) return;
  for (std::size_t i = first; i < contacts->size(); ++i) (*contacts)[i].point += origin;
}

/// The answer of the deepest of the contacts from `first` on.
inline PairAnswer from_deepest(const std::vector<Contact>& contacts, std::size_t first) {
  PairAnswer answer;
  const Contact* deepest = nullptr;
  for (std::size_t i = first; i < contacts.size(); ++i)
    if (!deepest || contacts[i].depth > deepest->depth) deepest = &contacts[i];
  if (!deepest) return answer;
  answer.collide = deepest->depth >= 0;
  answer.signed_distance = -deepest->depth;
  answer.normal = deepest->normal;
  answer.point_a = deepest->point + deepest->normal * (deepest->depth / 2);
  answer.point_b = deepest->point - deepest->normal * (deepest->depth / 2);
  return answer;
}

}  // namespace tandem
