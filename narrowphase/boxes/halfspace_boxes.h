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
  double sense;  ///< -1 where who asks has the box first, else 1
};

/// Half-spaces and posed boxes by pairs.
struct HalfspaceBoxList {
  static constexpr std::size_t most = 96;
  const PlacedHalfspace* halfspace[most];
  const Pose* pose[most];
  const HalfSize* half[most];
  std::size_t count = 0;
};

/// What is found, a pair a column, all in the world, in the order of who asks.
struct HalfspaceBoxFindings {
  static constexpr std::size_t most = HalfspaceBoxList::most;
  bool known[most];            ///< else the manifold is to be found by `append_halfspace_box`
  std::uint8_t corners[most];  ///< bit i: corner i is a contact
  alignas(64) double distance[most];
  AnswerRows<most> answers;
  ContactRows<most> contacts[4];  ///< of a face's corners
};

/// Signed distance and manifold of several pairs at once, a pair a lane; the same bits as one by one.
void find_on_halfspaces(const HalfspaceBoxList& pairs, double margin, HalfspaceBoxFindings& found);

}  // namespace tandem
