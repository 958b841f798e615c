// Shapes and poses as JSON (docs/scene-format.md).
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "formats/json_reader.h"
#include "formats/json_writer.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Reads shapes; a mesh file that several shapes name is read once.
class ShapeReader {
 public:
  /// `folders`: a mesh's `file` is relative to the first of these that has it.
  explicit ShapeReader(std::vector<std::filesystem::path> folders = {"."}) : folders_(std::move(folders)) {}

  /// Reads a shape. Throws InputError that names the JSON pointer, the value found and what is allowed.
  Shape read(const JsonRef& json);

 private:
  Shape read_core(const JsonRef& json);
  Shape mesh(const JsonRef& json);

  std::vector<std::filesystem::path> folders_;
  std::map<std::pair<std::string, bool>, Shape> mesh_files_;  // by path and `solid`
};

/// Reads a pose: `t` is required, at most one of `R` and `q`; without either the rotation is the identity.
Pose read_pose(const JsonRef& json);

/// Throws InputError "WHERE: ..." for a pose that shapes cannot have.
void require_valid_pose(const Pose& pose, std::string_view where);

/// Writes a shape or pose that `read` or `read_pose` reads back with the same bits. Meshes are written out, not named.
void write_shape(JsonWriter& out, const Shape& shape);
void write_pose(JsonWriter& out, const Pose& pose);

}  // namespace tandem
