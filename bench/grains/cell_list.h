// Cell lists for spheres over half-spaces, as contestants.
#pragma once
#include "peers/scene_detector.h"

namespace tandem::bench {

/// Spheres over half-spaces by a cell list (Allen, Tildesley, Computer Simulation of Liquids, 1987, 5.3.2), built anew
/// each step. Two contestants: one reports pairs in no order with the depth of each, no points and no normals; the
/// other makes the same list as tandem, to the last bit.
SceneDetectors cell_list_detectors(const Scene& scene);

}  // namespace tandem::bench
