// Contacts of negative depth between two meshes.
#pragma once
#include <span>
#include <vector>

#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// Appends the contacts of two meshes where their surfaces are near each other without intersecting, in world
/// coordinates: at points with no nearer points around them and a distance of at most the margin. Patches of about one
/// normal, at most four points each; depths are negative. `meeting`: all pairs of intersecting triangles, sorted. If it
/// is empty, there is a contact if and only if the distance is at most the margin, the nearest contact has that
/// distance, and so has the answer; else the answer is meaningless.
PairAnswer gap_contacts(const Posed& a, const Posed& b, std::span<const TrianglePair> meeting,
                        const NarrowPhaseOptions& options, std::vector<Contact>& contacts);

}  // namespace tandem
