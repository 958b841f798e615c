// Reads mesh files by the extension of their names.
#include "tandem/formats/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "formats/mesh_readers.h"
#include "formats/text_file.h"

namespace tandem {
namespace {

using Read = Mesh (*)(const std::string& file, std::string_view bytes, const std::filesystem::path& folder);

template <Mesh (*read)(const std::string&, std::string_view)>
Mesh alone(const std::string& file, std::string_view bytes, const std::filesystem::path&) {
  return read(file, bytes);
}

constexpr struct {
  std::string_view extension;
  Read read;
} formats[] = {{".obj", alone<read_obj>}, {".stl", alone<read_stl>}, {".ply", alone<read_ply>},
               {".off", alone<read_off>}, {".gltf", read_gltf},      {".glb", read_gltf}};

/// The reader for the file name's extension; null for an unknown one.
Read reader_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const auto& format : formats)
    if (extension == format.extension) return format.read;
  return nullptr;
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& path) { return reader_of(path) != nullptr; }

Mesh read_mesh_file(const std::filesystem::path& path) {
  const std::string file = path.string();
  const Read read = reader_of(path);
  if (read == nullptr) {
    std::error_code none;
    if (!std::filesystem::is_other(path, none)) const InputFile must_exist(path, InputFile::Kind::regular);
    throw InputError(file, "extension '" + quotation(path.extension().string()) + '\'', mesh_extensions);
  }
  return read(file, read_file(path, limits::mesh_bytes), path.parent_path());
}

Shape read_mesh_shape(const std::filesystem::path& path, bool solid, const BuildOptions& options) {
  Mesh mesh = read_mesh_file(path);
  mesh.solid = solid;
  try {
    return Shape(std::move(mesh), options);
  } catch (const std::invalid_argument& error) {
    throw InputError(path.string(), error.what());
  }
}

}  // namespace tandem
