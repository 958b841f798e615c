#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// All pairs of triangles [i of A, j of B] that meet, sorted; each shape a mesh or a triangle. Exact. Of the
/// options: `parts` and `limit`.
std::vector<std::array<std::uint32_t, 2>> mesh_triangle_pairs(const Shape& a, const Pose& pose_a, const Shape& b,
                                                              const Pose& pose_b, const NarrowPhaseOptions& options);

/// A mesh against anything (either or both may be the mesh; never two half-spaces).
PairAnswer solve_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      const NarrowPhaseOptions& options, std::vector<Contact>* contacts);

/// Fixed roles for two with triangles, whichever way round they came: the same pair is then solved with the same
/// rounding. The one that goes first has the larger unit.
bool goes_first(const Posed& a, const Posed& b);

/// A plane, or that of a half-space, as a mesh sees it: local . x = level.
struct PlaneInMesh {
  Vec3 up;     ///< its normal in the world
  Vec3 local;  ///< in the mesh's frame
  double level;

  PlaneInMesh(const Pose& mesh, const Posed& plane);
  PlaneInMesh(const Vec3& up, const Vec3& local, double level) : up(up), local(local), level(level) {}
  PlaneInMesh turned_over() const { return {-up, -local, -level}; }
};

/// How near a mesh comes to a plane from either side, by triangles that it does not cut; infinity without any.
struct PlaneGaps {
  double above = std::numeric_limits<double>::infinity(), below = above;
  std::uint32_t vertex_above = 0, vertex_below = 0;
  bool cut = false;  ///< a triangle meets the plane: nothing else is told
};
PlaneGaps plane_gaps(const MeshModel& mesh, const PlaneInMesh& plane, const WorkLimit* limit);

/// The solvers by what the other shape is; the mesh comes first. Contacts are appended for Request::contacts only.
PairAnswer solve_meshes(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                        std::vector<Contact>* contacts);  ///< both have triangles, goes_first(a, b)
PairAnswer solve_mesh_halfspace(const Posed& mesh, const PlaneInMesh& half, Request request,
                                const NarrowPhaseOptions& options, std::vector<Contact>* contacts);
/// Of these vertices alone, and of them those at least `floor` above the plane.
PairAnswer solve_vertices_halfspace(const Posed& mesh, const PlaneInMesh& half, std::span<const std::uint32_t> vertices,
                                    double floor, Request request, const NarrowPhaseOptions& options,
                                    std::vector<Contact>* contacts);
PairAnswer solve_mesh_plane(const Posed& mesh, const PlaneInMesh& plane, Request request,
                            const NarrowPhaseOptions& options, std::vector<Contact>* contacts);
PairAnswer solve_mesh_convex(const Posed& mesh, const Posed& convex, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts);  ///< bounded; a solid mesh may be that is its own hull

/// The options for the triangles of a mesh: a solver that was named is one for meshes.
NarrowPhaseOptions for_triangles(const NarrowPhaseOptions& options);

/// The answer's points as one contact.
inline Contact contact_of(const PairAnswer& r, std::uint32_t feature = 0) {
  return {(r.point_a + r.point_b) / 2, r.normal, -r.signed_distance, feature};
}

/// The answer of the deepest of the contacts from `first` on.
PairAnswer from_deepest(const std::vector<Contact>& contacts, std::size_t first);

}  // namespace tandem
