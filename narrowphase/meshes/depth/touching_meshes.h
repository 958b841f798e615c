// Two meshes that only touch: a translation as short as rounding parts them, though no plane may lie between them, as
// of solids that are hooked into each other face to face.
#pragma once
#include <optional>
#include <span>

#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// A translation of B out of A, at most four times `slack` (metres) long, if none of the triangles `pairs` that meet
/// (not empty; of many, those that are tested) is deeper in another than `slack` and one is found; else none. It is
/// proven: after it the meshes do not meet.
std::optional<Vec3> parting_translation(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                                        double slack, const NarrowPhaseOptions& options);

}  // namespace tandem
