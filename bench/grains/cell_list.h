#pragma once
#include "peers/scene_detector.h"

namespace tandem::bench {

/// Spheres over half-spaces by the plainest of methods, a cell list (Allen, Tildesley, Computer Simulation of Liquids,
/// 1987, 5.3.2), built anew each step. Two of them: one tells pairs in no order and the depth of each, no points and no
/// normals; the other the list that tandem has, to the last bit.
SceneDetectors cell_list_detectors(const Scene& scene);

}  // namespace tandem::bench
