#pragma once
#include "peers/scene_detector.h"

namespace tandem::bench {

/// Spheres over half-spaces by the plainest of methods, a cell list (Allen, Tildesley, Computer Simulation of Liquids,
/// 1987, 5.3.2), built anew each step: pairs in no order, and of each the depth, no points and no normals.
std::unique_ptr<SceneDetector> cell_list_detector(const Scene& scene);

}  // namespace tandem::bench
