// Bounds on the distance of voxels and another shape, by boxes.
#include "dispatch/voxel_gap.h"

#include <algorithm>
#include <cmath>

#include "shapes/support.h"
#include "shapes/without_hull.h"
#include "tolerances.h"

namespace tandem {

VoxelGap::VoxelGap(const Shape& voxels, const Pose& pose, const Shape& other, const Pose& other_pose,
                   const WorkLimit* limit)
    : model_(voxels_of(voxels)), is_bounded_(other.is_bounded()), is_plane_(other.kind() == ShapeKind::plane) {
  const auto [rotation, translation] = relative(pose, other_pose);
  const auto [root_mid, root_half] = model_.box(model_.root());
  double reach = root_mid.cwiseAbs().maxCoeff() + root_half.maxCoeff() + translation.cwiseAbs().maxCoeff();
  axes_ = rotation;
  if (is_bounded_) {
    const Bounds own = quick_bounds(other, Pose{}, limit);
    own_mid_ = (own.lo + own.hi) / 2, own_half_ = (own.hi - own.lo) / 2;
    const Bounds seen = quick_bounds(other, {rotation, translation}, limit);
    mid_ = (seen.lo + seen.hi) / 2, half_ = (seen.hi - seen.lo) / 2;
    own_mid_ += rotation.transpose() * translation;
    reach += own_mid_.cwiseAbs().maxCoeff() + own_half_.maxCoeff();
  } else {
    mid_ = rotation * other.normal();
    offset_ = other.offset() + mid_.dot(translation);
    reach += std::abs(other.offset());
  }
  // Rotations need not be quite orthonormal.
  const auto skew = [](const Mat3& r) { return (r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff(); };
  slack_ = (tolerance::place_rounding + 4 * (skew(pose.rotation) + skew(other_pose.rotation))) * reach;
  wider_ = slack_ + voxels.rounding() + (is_bounded_ ? 0 : other.rounding());
}

double VoxelGap::of_boxes(VoxelRef ref, double enough) const {
  const auto [mid, half] = model_.box(ref);
  const Vec3 apart = (mid - mid_).cwiseAbs() - half - half_;
  const double along_grid = apart.maxCoeff();
  if (along_grid - wider_ > enough) return along_grid - wider_;
  const double gap = along_grid > 0 ? apart.cwiseMax(0.0).norm() : along_grid;
  const Vec3 along_own =
      (axes_.transpose() * mid - own_mid_).cwiseAbs() - axes_.cwiseAbs().transpose() * half - own_half_;
  return std::max(gap, along_own.maxCoeff()) - wider_;
}

double VoxelGap::of_plane(VoxelRef ref) const {
  const auto [mid, half] = model_.box(ref);
  const double height = mid_.dot(mid) - offset_, reach = mid_.cwiseAbs().dot(half);
  return (is_plane_ ? std::abs(height) : height) - reach - wider_;
}

}  // namespace tandem
