// Queries of a mesh's surface by a point: the nearest point, the first crossing of a ray.
#pragma once
#include <cstdint>

#include "shapes/mesh_model.h"

namespace tandem {

/// The point of the surface nearest to p; in the mesh's frame, like p.
struct SurfacePoint {
  double distance;
  Vec3 at;
  std::uint32_t triangle;  ///< on which it lies
};
SurfacePoint nearest_point(const MeshModel& mesh, const Vec3& p, const WorkLimit* limit = nullptr);

/// The triangle nearest to p; of those equally near to rounding the one most aligned with `outward` (for a surface that
/// is not solid, with either side), then the first. In the mesh's frame.
std::uint32_t nearest_triangle(const MeshModel& mesh, const Vec3& p, const Vec3& outward);

/// The distance of the first crossing along d (unit) from p, infinity if there is none; in the mesh's frame.
double first_crossing(const MeshModel& mesh, const Vec3& p, const Vec3& d, const WorkLimit* limit = nullptr);

}  // namespace tandem
