#pragma once
#include <filesystem>
#include <string>

#include "shape_json.h"
#include "tandem/engine/scene.h"

namespace tandem {

/// Reads a scene. Throws InputError "FILE: POINTER: FOUND, allowed: ALLOWED" or "FILE: byte N: ...". A shape that no
/// body uses is fine, and so are no bodies. Mesh files are relative to the scene file's folder.
Scene read_scene_file(const std::filesystem::path& path);

/// The same from a document; the messages begin with the JSON pointer.
Scene read_scene(const JsonRef& json, ShapeReader& shapes);

/// Writes the bodies in the order of their indices and their shapes with unique names, so that the scene read back has
/// the same contacts, bit for bit, unless a body was removed from it (the indices then move up).
void write_scene(JsonWriter& out, const Scene& scene);

/// The name that `value` has, among `values`; empty if none does.
template <typename Enum, std::size_t n>
std::optional<Enum> by_name(std::string_view text, const Enum (&values)[n]) {
  for (const Enum value : values)
    if (name(value) == text) return value;
  return std::nullopt;
}
inline constexpr Request requests[] = {Request::collide, Request::distance, Request::contacts};

}  // namespace tandem
