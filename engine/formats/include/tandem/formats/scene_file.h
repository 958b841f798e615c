// Reading and writing of scene files.
#pragma once
#include <filesystem>

#include "tandem/engine/scene.h"

namespace tandem {

/// Reads a scene. Throws InputError "FILE: POINTER: FOUND, allowed: ALLOWED" or "FILE: byte N: ...". Shapes that no
/// body uses are permitted, and so is a scene without bodies. Mesh files are relative to the scene file's folder.
Scene read_scene_file(const std::filesystem::path& path);

/// Writes the scene to a file from which `read_scene_file` makes a scene with the same contacts, bit for bit; meshes
/// are written out. Body indices become consecutive where a body was removed. Throws std::runtime_error if the file
/// cannot be written.
void write_scene_file(const std::filesystem::path& path, const Scene& scene);

}  // namespace tandem
