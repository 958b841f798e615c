// Meshes that bound a convex set, a triangle or a closed surface that is its own hull, solved as that set.
#pragma once
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

bool bounds_convex(const Posed& s, const WorkLimit* limit);

/// Of two of which one at least bounds a convex set: as with that set.
PairAnswer solve_as_convex(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                           std::vector<Contact>* contacts);

/// As `solve_as_convex`, of two that are known to collide, however little.
PairAnswer overlap_as_convex(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts);

/// Of two that collide and both bound a convex set: as of their hulls.
PairAnswer overlap_of_hulls(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                            std::vector<Contact>* contacts);

/// A surface has nothing inside. Is what `overlap_as_convex` or `overlap_of_hulls` finds true all the same, as nothing
/// can slip into a surface on a translation shorter than `length`, that which separates?
bool is_as_convex(const Posed& a, const Posed& b, double length, const WorkLimit* limit);
bool is_as_hulls(const Posed& a, const Posed& b, double length, const WorkLimit* limit);

}  // namespace tandem
