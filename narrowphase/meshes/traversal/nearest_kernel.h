#pragma once
#include <array>
#include <variant>

#include "shapes/mesh_model.h"
#include "tolerances.h"

namespace tandem {

/// A box or triangle of one mesh in the frame of the other's boxes: about its centre, in its units.
struct NearBox {
  Vec3 mid, half;
  Mat3 axes;  ///< unit columns
  /// What is in it lies between two planes, too: |thin . x - thin_mid| <= thin_half.
  Vec3 thin = Vec3::Zero();
  double thin_mid = 0, thin_half = 0;
};
struct NearTriangle {
  std::array<Vec3, 3> corner, edge;  ///< each edge from its corner to the next
  std::array<double, 3> per_square;  ///< 1 / edge^2, 0 for none
  std::array<Vec3, 3> outward;       ///< across its edges, in its plane; all zero for one without area
  Vec3 normal;                       ///< unit, or zero
};
struct NearVolume {
  std::variant<NearBox, NearTriangle> shape;
  Vec3 aligned_mid, aligned_half;  ///< a box about it along the frame's axes

  explicit NearVolume(const NearBox& box);
  explicit NearVolume(const std::array<Vec3, 3>& corners);
  /// The most of n . x over all of it.
  double reach(const Vec3& n) const;
};

/// A mesh as another sees it, whose frame that is.
struct MeshView {
  const MeshModel& mesh;
  Mat3 turn;  ///< v about the mesh's centre, in metres, lies at turn * v / unit + shift
  Vec3 shift;
  double unit;  ///< the other's

  /// The box or triangle at that place (`child_ref` or `whole`) of its hierarchy.
  NearVolume volume(std::uint32_t ref) const;
};

/// A plane that the volume keeps to one side of: normal (unit) . x <= top for all of it.
struct NearPlane {
  Vec3 normal;
  double top;
};

/// Lower bounds on how far from the volume the children of the node are, a lane each, boxes or triangles; in the units
/// of the mesh, and too large by at most `bounds_off` of them. Those of lanes that are not in use are any. What is
/// beyond `enough` is not looked at further: its bound need not be the best one.
inline constexpr double bounds_off = tolerance::distance_of_floats;
void bound_distances(const NearVolume& volume, const NearPlane& plane, const MeshModel& mesh, const MeshNode& node,
                     double enough, std::array<double, mesh_lanes>& least);

}  // namespace tandem
