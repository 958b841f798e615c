// Two meshes that only touch: a translation of the length of a rounding error separates them, although no plane may lie
// between them, as for interlocking solids that touch face to face.
#pragma once
#include <optional>
#include <span>

#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// A translation of B out of A, in metres, after which the meshes do not intersect, nor after twice as much; empty if
/// none is found. Its length is at most four times `slack`, or 128 epsilon of B's translation if that is more, as
/// shorter ones would be rounded. B's pose rounds it; its direction is that which leads farther on, too. No shorter one
/// than `certain` separates. There is no search if that, or how deep one of the intersecting triangles `pairs` (sorted;
/// not empty; of many, some are tested) is in another, is more than a quarter of the length.
std::optional<Vec3> separating_translation(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                                           double certain, double slack, const NarrowPhaseOptions& options);

}  // namespace tandem
