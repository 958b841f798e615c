// The points of a contact patch, and the angles within which faces and edges share one.
#pragma once
#include <cstdint>

#include "tandem/narrowphase/pose.h"
#include "tolerances.h"

namespace tandem {

/// Cosine: a face within 1.1 degrees of the contact plane carries the patch.
constexpr double carries_patch = 0.9998;
/// Ratio of a contact patch's width to its length, up to which it counts as an edge.
constexpr double thin = tolerance::thin_patch;
/// Edges with a cosine no larger than this cross in one point.
constexpr double clearly_crossing = 0.999;
/// Cosine of the angle within which normals belong to one patch of a mesh.
constexpr double one_patch = 0.9;

/// A contact point in a shape's frame.
struct PatchPoint {
  Vec3 at;  ///< midway between the surfaces
  double depth;
  std::uint32_t feature;
  bool lowest = false;  ///< the deepest point of a leaning disc, which moves farther than the poses do
};

using tolerance::alike;

}  // namespace tandem
