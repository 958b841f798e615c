// Vertices with equal coordinates: files often repeat vertices.
#pragma once
#include <cstdint>
#include <vector>

#include "shapes/build_meter.h"
#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/pose.h"

namespace tandem {

/// For each vertex the first of those with the same coordinates. The same on any number of threads. A meter, if there
/// is one, is asked whether to go on.
std::vector<std::uint32_t> weld(const std::vector<Vec3>& vertices, const PartRunner& parts = {},
                                BuildMeter* meter = nullptr);

}  // namespace tandem
