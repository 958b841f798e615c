#pragma once
#include <filesystem>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The surface in a .obj or .stl file (by extension, either case): triangles in the file's order of faces, polygons as
/// fans from their first corner, coordinates rounded correctly to doubles. OBJ vertices stay as they are; STL corners
/// with equal coordinates become one vertex. Not solid. Throws InputError "FILE:LINE: ..." (text) or "FILE: byte N:
/// ..." (binary STL) for a file that is missing, cut off, empty, of another format or has an index out of range.
Mesh read_mesh_file(const std::filesystem::path& path);

}  // namespace tandem
