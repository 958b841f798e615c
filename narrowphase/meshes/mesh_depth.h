// The depth of two meshes that collide: which of the search's methods are asked, in which order, and when the answer is
// good enough.
#pragma once
#include <span>
#include <vector>

#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// The answer to a distance: triangles `pairs` meet, or one is inside the other.
PairAnswer depth_of_meshes(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                           const NarrowPhaseOptions& options);

/// The answer to contacts, those from `first` on: their deepest, and how far off its depth may be. Contacts that are
/// deeper than a translation that separates, or push along one direction by less than any that does, give way to the
/// shortest translation that is known.
PairAnswer bounded_contacts(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                            const NarrowPhaseOptions& options, std::size_t first, std::vector<Contact>& contacts);

}  // namespace tandem
