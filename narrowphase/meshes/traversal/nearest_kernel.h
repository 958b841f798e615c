// Lower bounds on distances of boxes and triangles of two meshes.
#pragma once
#include <array>
#include <variant>

#include "shapes/mesh_model.h"
#include "tolerances.h"

namespace tandem {

/// A box or triangle of one mesh in the frame of the other's boxes: relative to its centre, in its units.
struct NearBox {
  Vec3 mid, half;
  Mat3 axes;  ///< unit columns
  /// A slab that contains the content, too: |thin . x - thin_mid| <= thin_half.
  Vec3 thin = Vec3::Zero();
  double thin_mid = 0, thin_half = 0;
};
struct NearTriangle {
  std::array<Vec3, 3> corner, edge;  ///< each edge from its corner to the next
  std::array<double, 3> per_square;  ///< 1 / edge^2, 0 for an edge without length
  std::array<Vec3, 3> outward;       ///< perpendicular to its edges, in its plane; all zero without area
  Vec3 normal;                       ///< unit, or zero
};
struct NearVolume {
  std::variant<NearBox, NearTriangle> shape;
  Vec3 aligned_mid, aligned_half;  ///< an axis-aligned box about it in the frame

  explicit NearVolume(const NearBox& box);
  explicit NearVolume(const std::array<Vec3, 3>& corners);
  /// The maximum of n . x over all of it.
  double reach(const Vec3& n) const;
};

/// A mesh in the frame of another.
struct MeshView {
  const MeshModel& mesh;
  Mat3 turn;  ///< v relative to the mesh's centre, in metres, is at turn * v / unit + shift
  Vec3 shift;
  double unit;  ///< the other's

  /// The box or triangle at that place (`child_ref` or `whole`) of its hierarchy.
  NearVolume volume(std::uint32_t ref) const;
};

/// A half-space that contains the volume: normal (unit) . x <= top for all of it.
struct NearPlane {
  Vec3 normal;
  double top;
};

/// Lower bounds on the distance of the volume from the node's children, a lane each, boxes or triangles; in the units
/// of the mesh, too large by at most `bounds_off` of them. Values of unused lanes are arbitrary. Once a bound exceeds
/// `enough` it is not improved.
inline constexpr double bounds_off = tolerance::distance_of_floats;
void bound_distances(const NearVolume& volume, const NearPlane& plane, const MeshModel& mesh, const MeshNode& node,
                     double enough, std::array<double, mesh_lanes>& least);

}  // namespace tandem
