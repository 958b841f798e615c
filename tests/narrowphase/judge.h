#pragma once
#include <string>

#include "pair_classes.h"
#include "reference.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::test {

/// What is accepted, relative to the pair's size.
struct Bounds64 {
  double distance;  ///< of the signed distance, and of the separation along the normal
  double points;    ///< of the witness points from the surfaces and from each other
};
Bounds64 accepted(const Shape& a, const Shape& b);

/// How far the coordinates between the shapes reach: the translation between them, and how far their points lie from
/// their own origins beyond their size.
double reach(const reference::PosedPair& pair);

/// What world coordinates round to, in metres.
double rounding(const reference::PosedPair& pair);

/// The pair as a record for `tandem query`, every number to its last bit, in one line.
std::string record(const reference::PosedPair& pair);

/// Empty, or what is wrong with the answers to the requests, one line each: distance and verdict against the truth,
/// normal and points against their meaning, contacts, and the answers with A and B exchanged.
std::string judge(const NarrowPhase& solver, const reference::PosedPair& pair, const reference::Truth& truth);

}  // namespace tandem::test
