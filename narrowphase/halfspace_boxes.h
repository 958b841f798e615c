#pragma once
#include <cstddef>
#include <cstdint>

#include "box_axes.h"

namespace tandem {

/// Half-spaces, in the world, and posed boxes by pairs, a pair a column.
struct HalfspaceBoxRows {
  static constexpr std::size_t most = 32;
  alignas(64) double normal[3][most], offset[most], origin[3][most];  ///< normal . (x - origin) <= offset
  double pose[12][most], half[3][most];                               ///< rotation by columns, then the translation

  void set(std::size_t column, const Vec3& normal, double offset, const Vec3& origin, const HalfSize& half,
           const Pose& pose);
};

/// What is found, a pair a column: all in the world.
struct HalfspaceBoxFindings {
  static constexpr std::size_t most = HalfspaceBoxRows::most;
  bool known[most];  ///< else the manifold is to be found by `append_halfspace_box`
  alignas(64) double distance[most], on_halfspace[3][most], on_box[3][most];
  double face[most];  ///< the one whose corners follow: its name, shifted for the corner's number; a whole number
  double depth[4][most], point[4][3][most];
  std::uint8_t corners[most];  ///< bit i: corner i is a contact
};

/// Signed distance and manifold of `count` pairs at once, a pair a lane; the same bits as one by one.
void find_on_halfspaces(const HalfspaceBoxRows& pairs, std::size_t count, double margin, HalfspaceBoxFindings& found);

}  // namespace tandem
