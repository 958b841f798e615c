// The readers of mesh file formats.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "tandem/narrowphase/shape.h"

namespace tandem {

// One reader for each format; read_mesh_file documents what they read. `file` names the file in errors.
Mesh read_obj(const std::string& file, std::string_view text);
Mesh read_stl(const std::string& file, std::string_view bytes);
Mesh read_ply(const std::string& file, std::string_view bytes);
Mesh read_off(const std::string& file, std::string_view text);
/// Reads a .gltf or .glb file, distinguished by its first bytes. Separate buffer files are searched for in `folder`.
Mesh read_gltf(const std::string& file, std::string_view bytes, const std::filesystem::path& folder);

}  // namespace tandem
