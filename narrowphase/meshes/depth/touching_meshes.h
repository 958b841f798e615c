// Two meshes that only touch: a translation as short as rounding parts them, though no plane may lie between them, as
// of solids that are hooked into each other face to face.
#pragma once
#include <optional>
#include <span>

#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// How B may be moved to leave A, where none of the triangles `pairs` that meet (not empty) is deeper in another than
/// `slack`, metres, and a translation of about that length is found; else none. It is proven: the meshes do not meet
/// there.
std::optional<Vec3> parting_translation(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                                        double slack, const NarrowPhaseOptions& options);

}  // namespace tandem
