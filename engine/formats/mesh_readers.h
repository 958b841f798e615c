#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "tandem/narrowphase/shape.h"

namespace tandem {

// A reader a format; what each makes of a file is said at read_mesh_file. `file` names it in refusals.
Mesh read_obj(const std::string& file, std::string_view text);
Mesh read_stl(const std::string& file, std::string_view bytes);
Mesh read_ply(const std::string& file, std::string_view bytes);
Mesh read_off(const std::string& file, std::string_view text);
/// A .gltf or .glb file, told apart by how it begins. Buffers in files of their own are looked for in `folder`.
Mesh read_gltf(const std::string& file, std::string_view bytes, const std::filesystem::path& folder);

}  // namespace tandem
