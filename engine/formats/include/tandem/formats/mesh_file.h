// Reading and writing of mesh files.
#pragma once
#include <filesystem>
#include <string_view>

#include "tandem/narrowphase/build_options.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The file name extensions that read_mesh_file accepts, for messages.
inline constexpr std::string_view mesh_extensions = ".obj, .stl, .ply, .off, .gltf, .glb";

/// True if the name has one of mesh_extensions, in upper or lower case. The file need not exist.
bool is_mesh_file(const std::filesystem::path& path);

/// The surface in a file of one of mesh_extensions: triangles in the file's order of faces, polygons as fans from their
/// first corner, coordinates as they are written, text rounded correctly to doubles. Not solid: set Mesh::solid for a
/// surface that closes.
///
/// OBJ, PLY (text and binary) and OFF (text) vertices stay as they are. STL and glTF corners with equal coordinates
/// become one vertex, as these formats have a corner of its own for each triangle or normal. Of a glTF file (2.0, its
/// buffers in it or beside it) the triangles of its scene's nodes are taken in the scene's axes, y up; without skins,
/// morph targets and compression.
///
/// Throws InputError "FILE:LINE: ..." (text), "FILE: byte N: ..." (binary) or "FILE: /JSON/POINTER: ..." (glTF) for a
/// file that is missing, cut off, empty, of another format or has an index out of range.
Mesh read_mesh_file(const std::filesystem::path& path);

/// Reads a mesh file as a shape. `solid`: the inside counts; throws InputError that names the first edge that does not
/// close, and its place, if the surface is not closed. Corners with equal coordinates become one vertex, whatever the
/// format. `options`: how the hierarchy of the mesh is built.
Shape read_mesh_shape(const std::filesystem::path& path, bool solid = false, const BuildOptions& options = {});

}  // namespace tandem
