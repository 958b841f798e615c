#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshes/traversal/meeting_pairs.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"
#include "triangles/predicates.h"

namespace tandem {

/// What is known of the patches that were found.
struct PatchSides {
  bool sure = false;  ///< no normal is in doubt, as of faces and edges that only touch, of which rounding makes curves
  bool in_corner = false;  ///< a patch lies in a concave corner of one of the meshes, on each of its faces
};

/// Appends contacts of two meshes whose triangles `pairs` meet (not empty), in A's frame: one patch for each connected
/// curve along which the surfaces cross, at most 4 points a patch. A patch's normal is the area vector of its curve,
/// which equals the integral of A's normals over what of A is inside B; its depth is how far what of A and of B
/// lies inside the other reaches past each other along it. Of a mesh with a border the inside is that of its two
/// sides with the shorter translation. Where a curve goes round a corner of one mesh, two planes and up to four that
/// each lie in front of the others, there is a patch for each of them. Where flat faces have sunk into each other there
/// is a patch for each of their normals instead. Normals from A to B. Of the options: `parts` shares the work
/// where many triangles meet, and changes no bit, `limit` and `memory`.
PatchSides patch_contacts(const MeshModel& a, const MeshModel& b, const TriangleTest& frame,
                          std::span<const TrianglePair> pairs, const NarrowPhaseOptions& options,
                          std::vector<Contact>& contacts);

/// For those: if all triangles that meet only touch along some direction, their contacts along it take the place of
/// those from `first` on; if there are none of these, there is at least one afterwards. Of the options: `limit` and
/// `memory`.
void touching_contacts(const MeshModel& a, const MeshModel& b, const TriangleTest& frame,
                       std::span<const TrianglePair> pairs, const NarrowPhaseOptions& options, std::size_t first,
                       std::vector<Contact>& contacts);

}  // namespace tandem
