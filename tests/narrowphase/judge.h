// Judges answers by the reference and by their documentation.
#pragma once
#include <string>

#include "pair_classes.h"
#include "reference.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::test {

/// The permitted errors, relative to the pair's size.
struct Bounds64 {
  double distance;  ///< of the signed distance, and of the separation along the normal
  double points;    ///< of the witness points from the surfaces and from each other
};
Bounds64 accepted(const Shape& a, const Shape& b);

/// The extent of the coordinates: the translation between the shapes, and the distance of their points from their own
/// origins beyond their size.
double reach(const reference::PosedPair& pair);

/// The rounding of world coordinates, in metres.
double rounding(const reference::PosedPair& pair);

/// The pair as a record for `tandem query`, every number to its last bit, in one line.
std::string record(const reference::PosedPair& pair);

/// The errors of the answers, one line each; empty if there are none: distance and verdict compared with the reference,
/// normal and points with their meaning, contacts, and the answers with A and B exchanged.
std::string judge(const NarrowPhase& solver, const reference::PosedPair& pair, const reference::Truth& truth);

}  // namespace tandem::test
