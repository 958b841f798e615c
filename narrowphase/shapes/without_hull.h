#pragma once
#include "shapes/mesh_model.h"

namespace tandem {

/// Triangles from which on a mesh's hull, which takes longer than its building (3 times of a million triangles, more of
/// larger ones), is asked for only where an answer needs it.
inline constexpr std::size_t triangles_without_hull = std::size_t{1} << 18;

/// Is the hull not asked for to be quicker? By nothing but the mesh, so that no answer depends on what was asked before.
inline bool does_without_hull(const MeshModel& mesh) {
  return mesh.bends || mesh.triangles.size() >= triangles_without_hull;
}

}  // namespace tandem
