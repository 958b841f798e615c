#pragma once
#include <span>
#include <vector>

#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// Appends the contacts of two meshes where their surfaces are near each other without meeting, in world coordinates:
/// where no point about them is nearer, and the gap is at most the margin. Patches of about one normal, at most four
/// points each; their depths are negative. `meeting`: all pairs of triangles that meet, sorted. If there are none,
/// there is a contact if and only if the distance is at most the margin, the nearest one has that distance, and the
/// answer tells it; else the answer says nothing.
PairAnswer gap_contacts(const Posed& a, const Posed& b, std::span<const TrianglePair> meeting,
                        const NarrowPhaseOptions& options, std::vector<Contact>& contacts);

}  // namespace tandem
