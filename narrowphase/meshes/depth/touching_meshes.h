// Two meshes that only touch: a translation as short as rounding parts them, though no plane may lie between them, as
// of solids that are hooked into each other face to face.
#pragma once
#include <optional>
#include <span>

#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// A translation of B out of A, in metres, after which the meshes do not meet, nor after twice as much; none if none is
/// found. Its length is at most four times `slack`, or 128 epsilon of B's translation where that is more, as shorter
/// ones would be rounded; it is the one by which B's pose really changes. None is looked for where one of the triangles
/// `pairs` that meet (not empty; of many, some are tested) is deeper in another than a quarter of that.
std::optional<Vec3> parting_translation(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                                        double slack, const NarrowPhaseOptions& options);

}  // namespace tandem
