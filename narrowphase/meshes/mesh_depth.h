// The depth of two meshes that collide: which of the search's methods are used, in which order, and when the answer is
// accepted.
#pragma once
#include <span>
#include <vector>

#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// The answer to a distance request: triangles `pairs` intersect, or one is inside the other.
PairAnswer depth_of_meshes(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                           const NarrowPhaseOptions& options);

/// The answer to a contact request, for the contacts from `first` on: the deepest, with a bound on the error of its
/// depth. Contacts deeper than a translation that separates, or that push along one direction by less than any such,
/// are replaced by the shortest known translation.
PairAnswer bounded_contacts(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                            const NarrowPhaseOptions& options, std::size_t first, std::vector<Contact>& contacts);

}  // namespace tandem
