// The built-in scenes.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

#include "tandem/engine/scene.h"

namespace tandem {

/// A scene made by code from a seed.
struct BuiltinScene {
  std::string_view name;         ///< as on the command line
  std::string_view description;  ///< one line
  std::size_t bodies;            ///< moving ones, at the paper's size
};

/// All built-in scenes; the first four are the paper's (Avril, Gouranton and Arnaldi, ICAT 2010, section 5).
std::span<const BuiltinScene> builtin_scenes();

/// Makes a built-in scene. Throws std::invalid_argument for an unknown name (the message lists the known ones).
/// `bodies` 0 is the paper's size; [1, 1'000'000]. The same name, bodies and seed give the same scene on every machine.
Scene make_builtin_scene(std::string_view name, std::size_t bodies = 0, std::uint64_t seed = 1);

}  // namespace tandem
