// Vertices with equal coordinates, which files often repeat.
#pragma once
#include <cstdint>
#include <vector>

#include "shapes/build_meter.h"
#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/pose.h"

namespace tandem {

/// For each vertex the first of those with the same coordinates. The same for any number of threads. The meter, if any,
/// is asked whether to continue.
std::vector<std::uint32_t> weld(const std::vector<Vec3>& vertices, const PartRunner& parts = {},
                                BuildMeter* meter = nullptr);

}  // namespace tandem
