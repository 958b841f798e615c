// Built-in scenes after some steps.
#pragma once
#include <string_view>

#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"

namespace tandem::test {

/// A built-in scene after so many steps: bodies that have begun to fall onto each other.
inline Scene settled_scene(std::string_view name, std::size_t bodies, int steps) {
  Scene scene = make_builtin_scene(name, bodies);
  Pipeline pipeline({.answer = {.margin = recommended_margin(scene)}});
  Response response;
  for (int i = 0; i < steps; ++i) {
    pipeline.step(scene);
    response.step(scene, pipeline.contacts());
  }
  return scene;
}

}  // namespace tandem::test
