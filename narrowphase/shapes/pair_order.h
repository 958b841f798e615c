// The canonical order of two shapes in a query, and the exchange of A and B in an answer.
#pragma once
#include <vector>

#include "shapes/convex_view.h"
#include "tandem/narrowphase/answer.h"

namespace tandem {

/// A generic direction: of two equal shapes the one farther back along it comes first.
constexpr double reversal[3] = {0.5377, 0.3412, 0.7711};
/// True if B comes before A. Two bodies of one kind are solved in an order that depends on their content, so that the
/// answer is the same, bit for bit, whichever is named first. `parameters` compares the shapes: < 0 if A comes first, 0
/// if they are equal; then the poses decide.
bool reversed(double parameters, const Pose& pose_a, const Pose& pose_b);
bool boxes_reversed(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b);

/// The rank of a kind: planes, half-spaces, then spheres come first, since their closed forms are written for this
/// order only.
constexpr int rank(ShapeKind kind) {
  if (kind == ShapeKind::plane) return -1;
  if (kind == ShapeKind::halfspace) return 0;
  return kind == ShapeKind::sphere ? 1 : 2 + static_cast<int>(kind);
}

/// The order of two shapes of a kind by parameters and poses: exchanged arguments are then solved alike, with the same
/// bits.
bool comes_after(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b);

/// Exchanges A and B in the answer and in the contacts from `first` on.
void swap_answer(PairAnswer& answer, std::vector<Contact>* contacts, std::size_t first);

}  // namespace tandem
