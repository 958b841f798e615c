// Several pairs of a half-space and a box at once, a pair a lane.
#pragma once
#include <cstddef>
#include <cstdint>

#include "boxes/answer_rows.h"
#include "boxes/box_axes.h"

namespace tandem {

/// A half-space in the world: normal . (x - origin) <= offset.
struct PlacedHalfspace {
  Vec3 normal;
  double offset;
  Vec3 origin;
  double sense;  ///< -1 where the caller has the box first, else 1
};

/// Half-spaces and posed boxes by pairs.
struct HalfspaceBoxList {
  static constexpr std::size_t most = 96;
  const PlacedHalfspace* halfspace[most];
  const Pose* pose[most];
  const HalfSize* half[most];
  std::size_t count = 0;
};

/// Results, a pair a column, in the world, in the caller's order.
struct HalfspaceBoxFindings {
  static constexpr std::size_t most = HalfspaceBoxList::most;
  bool known[most];            ///< false: use `append_halfspace_box` for the manifold
  std::uint8_t corners[most];  ///< bit i: corner i is a contact
  alignas(64) double distance[most];
  AnswerRows<most> answers;
  ContactRows<most> contacts[4];  ///< of the corners of a face
};

/// Signed distances and manifolds of several pairs at once, a pair a lane; the same bits as one by one.
void find_on_halfspaces(const HalfspaceBoxList& pairs, double margin, HalfspaceBoxFindings& found);

}  // namespace tandem
