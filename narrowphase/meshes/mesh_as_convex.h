// Meshes that bound a convex set (a triangle, or a closed surface equal to its hull), solved as that set.
#pragma once
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

bool bounds_convex(const Posed& s, const WorkLimit* limit);

/// The answer for two of which at least one bounds a convex set: with that set.
PairAnswer solve_as_convex(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                           std::vector<Contact>* contacts);

/// As `solve_as_convex`, for two that are known to collide, however little.
PairAnswer overlap_as_convex(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts);

/// The answer for two that collide and both bound a convex set: that of their hulls.
PairAnswer overlap_of_hulls(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                            std::vector<Contact>* contacts);

/// A surface has no interior. True if the result of `overlap_as_convex` or `overlap_of_hulls` holds nevertheless, since
/// nothing can get inside a surface by a translation shorter than `length`, the one that separates.
bool holds_as_convex(const Posed& a, const Posed& b, double length, const WorkLimit* limit);
bool holds_as_hulls(const Posed& a, const Posed& b, double length, const WorkLimit* limit);

}  // namespace tandem
