#pragma once
#include <filesystem>

#include "tandem/engine/scene.h"

namespace tandem {

/// Reads a scene. Throws InputError "FILE: POINTER: FOUND, allowed: ALLOWED" or "FILE: byte N: ...". A shape that no
/// body uses is fine, and so are no bodies. Mesh files are relative to the scene file's folder.
Scene read_scene_file(const std::filesystem::path& path);

/// Writes the scene to a file that `read_scene_file` reads back with the same contacts, bit for bit; meshes are written
/// out. Body indices move up where a body was removed. Throws std::runtime_error where the file cannot be written.
void write_scene_file(const std::filesystem::path& path, const Scene& scene);

}  // namespace tandem
