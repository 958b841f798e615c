#pragma once
#include <cstddef>
#include <cstdint>

#include "closed_forms.h"
#include "rectangle_clip.h"

namespace tandem {

/// Posed boxes by pairs, a pair a column: poses as columns of the rotation, then the translation; half sizes.
struct BoxPairRows {
  static constexpr std::size_t most = 32;
  alignas(64) double pose_a[12][most], pose_b[12][most], half_a[3][most], half_b[3][most];

  void set(std::size_t column, const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b);
};

/// What `overlap_boxes` knows of a pair.
enum class BoxFinding : std::uint8_t {
  unknown,  ///< less than all that follows
  apart,    ///< farther than the margin
  axis,     ///< `answer`
  faces,    ///< and two faces that lie over each other, of which more than a corner may touch
  point,    ///< the normal and the one point of the manifold, in the world
};

/// What is found, a pair a column.
struct BoxFindingRows {
  static constexpr std::size_t most = BoxPairRows::most;
  BoxFinding finding[most];
  alignas(64) double distance[most];                                     ///< signed
  double axis[most], edges_cosine[most], facing[most];                   ///< as in BoxAnswer; the axis a whole number
  double normal_in_a[3][most], in_a_of_a[3][most], in_a_of_b[3][most];   ///< LocalAnswer's; points of edges only
  double normal[3][most], on_a[3][most], on_b[3][most], point[3][most];  ///< in the world
  double depth[most], feature[most];                                     ///< of the point; a whole number
  RectanglePairRows faces;

  /// As box_box_overlap gives it; finding `axis`.
  BoxAnswer answer(std::size_t column) const;
};

/// box_box_overlap of `count` pairs at once, a pair a lane, with the same bits; the manifold, too, where it is the
/// point of two edges or a corner well over the other's face.
void overlap_boxes(const BoxPairRows& pairs, std::size_t count, double margin, BoxFindingRows& found);

}  // namespace tandem
