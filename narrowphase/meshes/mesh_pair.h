// A mesh with any other shape: which of the two comes first, and which solver answers. For two meshes: by which method,
// depending on their surfaces, and on whether one bounds a convex set.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// All pairs of intersecting triangles [i of A, j of B], sorted; each shape a mesh or a triangle. Exact. Uses `parts`
/// and `limit` of the options.
std::vector<std::array<std::uint32_t, 2>> mesh_triangle_pairs(const Shape& a, const Pose& pose_a, const Shape& b,
                                                              const Pose& pose_b, const NarrowPhaseOptions& options);

/// Answers a mesh against any shape (either or both may be meshes; never two half-spaces).
PairAnswer solve_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      const NarrowPhaseOptions& options, std::vector<Contact>* contacts);

/// Canonical roles of two shapes with triangles, independent of their order: a pair is then solved with the same
/// rounding. The first has the larger unit.
bool goes_first(const Posed& a, const Posed& b);

}  // namespace tandem
