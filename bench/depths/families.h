// Solid meshes by formula that lie deep in each other: bowls, rings, gears, tori and blobs.
#pragma once
#include <string>
#include <vector>

#include "reference/random.h"
#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

struct DeepPair {
  Shape a, b;
  Pose pose_a, pose_b;
};

/// A family of pairs of solids, of some hundred to thousand triangles each, about 1 in radius.
struct DepthFamily {
  std::string name;
  DeepPair (*make)(reference::Random& random);
};

std::vector<DepthFamily> depth_families();

}  // namespace tandem::bench
