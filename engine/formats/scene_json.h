// Scenes as JSON (docs/scene-format.md).
#pragma once
#include <optional>
#include <string_view>

#include "formats/shape_json.h"
#include "tandem/engine/scene.h"

namespace tandem {

/// Reads a scene from a document. Throws InputError; the messages begin with the JSON pointer.
Scene read_scene(const JsonRef& json, ShapeReader& shapes);

/// Writes the bodies in the order of their indices and their shapes with unique names, so that the scene read back has
/// the same contacts, bit for bit, unless a body was removed from it (the indices then move up).
void write_scene(JsonWriter& out, const Scene& scene);

/// The name of `value` among `values`; empty if it is not among them.
template <typename Enum, std::size_t n>
std::optional<Enum> by_name(std::string_view text, const Enum (&values)[n]) {
  for (const Enum value : values)
    if (name(value) == text) return value;
  return std::nullopt;
}
inline constexpr Request requests[] = {Request::collide, Request::distance, Request::contacts};

}  // namespace tandem
