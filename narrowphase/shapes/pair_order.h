// The order in which two bodies are solved, and what changes in the answer when they are exchanged.
#pragma once
#include <vector>

#include "shapes/convex_view.h"
#include "tandem/narrowphase/answer.h"

namespace tandem {

/// Along this direction, which is in no way special, A comes first of two that are alike.
constexpr double reversal[3] = {0.5377, 0.3412, 0.7711};
/// Does B come before A? Two bodies of one kind are solved in an order that their content decides, so that the answer
/// is the same, bit for bit, whichever is named first. `parameters` compares the shapes: < 0 if A's come first, 0 if
/// they are alike; then the poses decide.
bool reversed(double parameters, const Pose& pose_a, const Pose& pose_b);
bool boxes_reversed(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b);

/// Planes, half-spaces, then spheres, come first: their closed forms are written from their side only.
constexpr int rank(ShapeKind kind) {
  if (kind == ShapeKind::plane) return -1;
  if (kind == ShapeKind::halfspace) return 0;
  return kind == ShapeKind::sphere ? 1 : 2 + static_cast<int>(kind);
}

/// An order of two of a kind by what they are and where they stand: exchanged arguments then are solved alike, and
/// answer the same to the last bit.
bool comes_after(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b);

/// The answer and the contacts from `first` on, with A and B exchanged.
void swap_answer(PairAnswer& answer, std::vector<Contact>* contacts, std::size_t first);

}  // namespace tandem
