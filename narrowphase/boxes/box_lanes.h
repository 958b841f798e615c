#pragma once
#include <cstddef>
#include <cstdint>

#include "boxes/answer_rows.h"
#include "boxes/box_box.h"
#include "closed_forms/closed_forms.h"
#include "manifold/rectangle_clip.h"

namespace tandem {

/// Posed boxes by pairs, a pair a column: poses as columns of the rotation, then the translation; half sizes; sense -1
/// where who asks has them in the other order, else 1.
struct BoxPairRows {
  static constexpr std::size_t most = 96;
  alignas(64) double pose_a[12][most], pose_b[12][most], half_a[3][most], half_b[3][most], sense[most];
};

/// What `overlap_boxes` knows of a pair.
struct BoxFinding {
  enum : std::int64_t {
    unknown,  ///< less than all that follows
    apart,    ///< farther than the margin
    axis,     ///< `answer`
    faces,    ///< and two faces that lie over each other, of which more than a corner may touch
    point,    ///< the normal and the one point of the manifold, in the world
  };
};

/// What is found, a pair a column.
struct BoxFindingRows {
  static constexpr std::size_t most = BoxPairRows::most;
  alignas(64) std::int64_t finding[most];                               ///< BoxFinding
  double distance[most];                                                ///< signed
  double axis[most], edges_cosine[most], facing[most];                  ///< as in BoxAnswer; the axis a whole number
  double normal_in_a[3][most], in_a_of_a[3][most], in_a_of_b[3][most];  ///< LocalAnswer's; points of edges only
  // In the order of who asks.
  AnswerRows<most> answers;    ///< with the edges' points, or those halfway to either side of the one contact
  ContactRows<most> contacts;  ///< the one contact; its normal is the pair's, whatever else there is
  RectanglePairRows faces;

  /// As box_box_overlap gives it, in the rows' order; finding `axis`.
  BoxAnswer answer(std::size_t column) const;
};

/// box_box_overlap of `count` pairs at once, a pair a lane, with the same bits; the manifold, too, where it is the
/// point of two edges or a corner well over the other's face.
void overlap_boxes(const BoxPairRows& pairs, std::size_t count, double margin, BoxFindingRows& found);

}  // namespace tandem
