// The normal cone of a surface about a point of it: the directions along which a contact there pushes.
#pragma once
#include "shapes/mesh_model.h"

namespace tandem {

/// Is n (unit, mesh's frame) in the normal cone of the feature of triangle t (its face, an edge, a corner) that lies
/// farthest along it? It is if no triangle beside that feature reaches farther: on a flat or hollow surface only faces
/// push, not the edges between them. `at` is where t is touched: of an edge only what lies beside it there counts,
/// around its corners within `slack` of these.
bool in_normal_cone(const MeshModel& mesh, std::uint32_t t, const Vec3& n, const Vec3& at, double slack);

/// Does a triangle around corner k of t reach farther along n than that corner?
bool has_higher_neighbour(const MeshModel& mesh, std::uint32_t t, std::size_t k, const Vec3& n);

}  // namespace tandem
