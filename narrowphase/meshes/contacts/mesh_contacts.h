// Contacts of two meshes that intersect.
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

/// The feature of a contact that represents a patch, or an overlap, as a whole.
inline constexpr std::uint32_t of_no_feature = 0xffffffffu;

/// Properties of the patches that were found.
struct PatchSides {
  /// No normal is in doubt, unlike for faces and edges that only touch, where rounding creates curves.
  bool sure = false;
  bool in_corner = false;  ///< a patch lies in a concave corner of one of the meshes, on each of its faces
};

/// Appends contacts of two meshes whose triangles `pairs` intersect (not empty), in A's frame: one patch for each
/// connected curve along which the surfaces cross, at most 4 points a patch. A patch's normal is the area vector of its
/// curve, which equals the integral of A's normals over the part of A inside B; its depth is the extent along it by
/// which the inner parts of A and B reach past each other. For a mesh with a border the inside is that of its two sides
/// with the shorter translation. Where a curve goes around a concave corner of one mesh, of two to four planes that
/// each lie in front of the others, there is a patch for each plane. Where flat faces have sunk into each other there
/// is a patch for each of their normals instead. Where all points of a patch lie on its curve, as those of two
/// triangles that cross, it has one contact, that of its deepest pair of triangles. Normals from A to B. Uses of the
/// options: `parts` distributes the work if many triangles intersect, and changes no bit; `limit` and `memory`.
PatchSides patch_contacts(const MeshModel& a, const MeshModel& b, const TriangleTest& frame,
                          std::span<const TrianglePair> pairs, const NarrowPhaseOptions& options,
                          std::vector<Contact>& contacts);

/// For the same pairs: if all intersecting triangles only touch along some direction, replaces the contacts from
/// `first` on by contacts along it; if there are none, adds at least one. Uses `limit` and `memory` of the options.
void touching_contacts(const Posed& a, const Posed& b, const TriangleTest& frame, std::span<const TrianglePair> pairs,
                       const NarrowPhaseOptions& options, std::size_t first, std::vector<Contact>& contacts);

}  // namespace tandem
