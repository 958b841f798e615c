// Several pairs of boxes at once, a pair a lane.
#pragma once
#include <cstddef>
#include <cstdint>

#include "boxes/answer_rows.h"
#include "boxes/box_box.h"
#include "closed_forms/closed_forms.h"
#include "manifold/rectangle_clip.h"

namespace tandem {

/// Posed boxes by pairs, a pair a column: poses as columns of the rotation, then the translation; half sizes; sense: -1
/// where the caller has the boxes in the other order, else 1.
struct BoxPairRows {
  static constexpr std::size_t most = 96;
  alignas(64) double pose_a[12][most], pose_b[12][most], half_a[3][most], half_b[3][most], sense[most];
};

/// The state of a pair after `overlap_boxes`, from the least to the most complete.
struct BoxFinding {
  enum : std::int64_t {
    unknown,  ///< nothing is known
    apart,    ///< farther than the margin
    axis,     ///< `answer` is set
    faces,    ///< also two overlapping faces, of which more than a corner may touch
    point,    ///< also the normal and the only point of the manifold, in the world
  };
};

/// Results, a pair a column.
struct BoxFindingRows {
  static constexpr std::size_t most = BoxPairRows::most;
  alignas(64) std::int64_t finding[most];                               ///< BoxFinding
  double distance[most];                                                ///< signed
  double axis[most], edges_cosine[most], facing[most];                  ///< as in BoxAnswer; the axis an integer
  /// As in LocalAnswer; the points only for edge axes.
  double normal_in_a[3][most], in_a_of_a[3][most], in_a_of_b[3][most];
  // In the caller's order of the boxes.
  AnswerRows<most> answers;    ///< with the edges' points, or points to either side of the one contact
  ContactRows<most> contacts;  ///< the one contact; its normal is the pair's in any case
  RectanglePairRows faces;

  /// The answer as box_box_overlap gives it, in the rows' order; for finding `axis`.
  BoxAnswer answer(std::size_t column) const;
};

/// box_box_overlap for `count` pairs at once, a pair a lane, with the same bits; also the manifold where it is the
/// point of two edges, or a corner well inside the other's face.
void overlap_boxes(const BoxPairRows& pairs, std::size_t count, double margin, BoxFindingRows& found);

}  // namespace tandem
