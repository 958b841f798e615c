#pragma once
#include "shapes/mesh_model.h"

namespace tandem {

/// Does the surface about triangle t push along n (unit, mesh's frame)? It does if no triangle beside the feature of t
/// that lies farthest along n (its face, an edge, a corner) reaches farther: on a flat or hollow surface only faces
/// push, not the edges between them. `at` is where t is touched: of an edge only what lies beside it there counts,
/// around its corners within `slack` of these.
bool bears(const MeshModel& mesh, std::uint32_t t, const Vec3& n, const Vec3& at, double slack);

/// Does a triangle around corner k of t reach farther along n than that corner?
bool overtopped(const MeshModel& mesh, std::uint32_t t, std::size_t k, const Vec3& n);

/// How far p, a point of triangle t, lies at least from the border of what lies in the plane of t about it, both but
/// for `slack`; -1 if p is not in t. Mesh's frame.
double flat_about(const MeshModel& mesh, std::uint32_t t, const Vec3& p, double slack);

/// The point of the surface nearest to p; in the mesh's frame, as p is.
struct SurfacePoint {
  double distance;
  Vec3 at;
};
SurfacePoint nearest_point(const MeshModel& mesh, const Vec3& p);

/// Distance of the first crossing along d (unit) from p, infinity if there is none; in the mesh's frame.
double first_crossing(const MeshModel& mesh, const Vec3& p, const Vec3& d);

}  // namespace tandem
