// A mesh with anything: which of the two goes first, and which solver answers. Of two meshes: by which method, which
// their surfaces decide, and whether one bounds a convex set.
#pragma once
#include <array>
#include <cstdint>
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

}  // namespace tandem
