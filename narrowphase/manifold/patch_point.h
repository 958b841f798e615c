// A point of a contact patch, and within which angles faces and edges share one.
#pragma once
#include <cstdint>

#include "tandem/narrowphase/pose.h"
#include "tolerances.h"

namespace tandem {

/// Cosine: a face within 1.1 degrees of the contact plane carries the patch.
constexpr double carries_patch = 0.9998;
/// Width of a contact patch to its length, up to which it counts as an edge.
constexpr double thin = tolerance::thin_patch;
/// Edges whose directions' cosine is no larger cross in one point.
constexpr double clearly_crossing = 0.999;
/// Cosine of the angle within which normals belong to one patch of a mesh.
constexpr double one_patch = 0.9;

/// A contact before it is placed in the world.
struct PatchPoint {
  Vec3 at;  ///< midway between the surfaces
  double depth;
  std::uint32_t feature;
  bool lowest = false;  ///< the deepest of a disc that leans: it moves farther than the poses do
};

using tolerance::alike;

}  // namespace tandem
