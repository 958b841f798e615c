// The scene that a command line names.
#include "scene_option.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "option_text.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/formats/mesh_file.h"
#include "tandem/formats/scene_file.h"

namespace tandem {

Scene load_scene(const std::string& scene, const std::string& bodies, const std::string& seed) {
  const auto known = builtin_scenes();
  const bool builtin = std::any_of(known.begin(), known.end(), [&](const auto& s) { return s.name == scene; });
  if (builtin) {
    const auto count = bodies.empty() ? 0 : whole_option("--bodies", bodies, 1, 1'000'000);
    const auto start = seed.empty() ? 1 : whole_option("--seed", seed, 0, UINT64_MAX);
    return make_builtin_scene(scene, count, start);
  }
  std::error_code ignored;
  if (!std::filesystem::exists(scene, ignored)) {
    if (scene.find_first_of("./") != std::string::npos)
      throw std::invalid_argument("SCENE: there is no file '" + scene + "'");
    std::string names;
    for (const BuiltinScene& one : known) names += std::string(one.name) + ", ";
    refuse_option("SCENE", scene, names + "or a scene file");
  }
  if (is_mesh_file(scene))
    throw RequestError("SCENE: '" + scene + "' is a mesh, allowed: a scene file in JSON whose shapes may name it");
  if (!bodies.empty()) refuse_option("--bodies", bodies, "with a built-in scene only");
  if (!seed.empty()) refuse_option("--seed", seed, "with a built-in scene only");
  return read_scene_file(scene);
}

}  // namespace tandem
