// The pose of a body after a step by its velocities alone.
#pragma once
#include <cstdint>

#include "tandem/engine/scene.h"

namespace tandem {

/// After dt, of a body that is alive: it may be no valid pose, where the velocities are as large as numbers go.
Pose free_end(const Scene& scene, std::uint32_t body);

}  // namespace tandem
