// Lower bounds on the distance of voxels and another shape, by boxes.
#pragma once
#include "shapes/posed_mesh.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// Lower bounds on the signed distance of the other shape and a cell, or any cell of a node: by the other shape's boxes
/// in the grid's frame and in its own; for a half-space or plane by its normal.
class VoxelGap {
 public:
  VoxelGap(const Shape& voxels, const Pose& pose, const Shape& other, const Pose& other_pose, const WorkLimit* limit);

  /// Less than 0: no cell is deeper. A bound greater than `enough` is not improved.
  double operator()(VoxelRef ref, double enough) const { return is_bounded_ ? of_boxes(ref, enough) : of_plane(ref); }

  /// A bound on the rounding of positions, metres.
  double slack() const { return slack_; }

 private:
  double of_boxes(VoxelRef ref, double enough) const;
  double of_plane(VoxelRef ref) const;

  const VoxelModel& model_;
  const bool is_bounded_, is_plane_;
  Vec3 mid_, half_;          // the other shape's box in the grid's frame; for a half-space mid_ is its normal
  Mat3 axes_;                // the other shape's axes, as columns, in the grid's frame
  Vec3 own_mid_, own_half_;  // its box along them
  double offset_ = 0;        // for a half-space or plane, in the grid's frame
  double slack_;
  double wider_;             // enlargement by that, and by the voxels' and a plane's rounding radius
};

}  // namespace tandem
