#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "convex_view.h"
#include "mesh_model.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// All pairs of triangles [i of A, j of B] that meet, sorted; each shape a mesh or a triangle. Exact.
std::vector<std::array<std::uint32_t, 2>> mesh_triangle_pairs(const Shape& a, const Pose& pose_a, const Shape& b,
                                                              const Pose& pose_b);

/// A shape where it is.
struct Posed {
  const Shape& shape;
  const Pose& pose;
};

inline bool has_triangles(const Shape& s) { return s.kind() == ShapeKind::mesh || s.kind() == ShapeKind::triangle; }

/// Fixed roles for two with triangles, whichever way round they came: the same pair is then solved with the same
/// rounding. The one that goes first has the larger unit.
bool goes_first(const Posed& a, const Posed& b);

/// The solvers by what the other shape is; the mesh comes first. Contacts are appended for Request::contacts only.
PairAnswer solve_meshes(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                        std::vector<Contact>* contacts);  ///< both have triangles, goes_first(a, b)
PairAnswer solve_mesh_halfspace(const Posed& mesh, const Posed& half, Request request,
                                const NarrowPhaseOptions& options, std::vector<Contact>* contacts);
PairAnswer solve_mesh_convex(const Posed& mesh, const Posed& convex, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts);  ///< bounded; a solid mesh may be that is its own hull

// ---- What these have in common ----

using Corners = std::array<Vec3, 3>;

/// Largest absolute coordinate of a vertex, or a little more.
inline double reach(const MeshModel& mesh) { return (mesh.centre.cwiseAbs() + mesh.half).maxCoeff(); }

/// The mesh's hull as a convex shape.
ConvexView view_hull(const Shape& mesh);

/// The options for the triangles of a mesh: a solver that was named is one for meshes.
NarrowPhaseOptions for_triangles(const NarrowPhaseOptions& options);

/// The answer of the deepest of the contacts from `first` on.
PairAnswer from_deepest(const std::vector<Contact>& contacts, std::size_t first);

}  // namespace tandem
