// The scene that a command line names.
#pragma once
#include <string>

#include "tandem/engine/scene.h"

namespace tandem {

/// The scene that a command line names: a built-in one, or a scene file. `bodies` and `seed` as typed; empty: not
/// given. Throws std::invalid_argument that names the option, the value found and what is allowed.
Scene load_scene(const std::string& scene, const std::string& bodies, const std::string& seed);

}  // namespace tandem
