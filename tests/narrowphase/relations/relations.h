// Relations that answers of the narrow phase must keep, whatever the right answer is: no oracle is needed.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "posed_pair.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::relations {

/// What is answered to all requests for a pair.
struct Answers {
  bool collide = false;
  PairAnswer distance, contacts, near;    ///< near: contacts with the pair's margin
  std::vector<Contact> touching, within;  ///< of `contacts`, of `near`
};

/// A pair as it is judged: its answers are shared by the relations.
struct Case {
  const PosedPair& pair;
  const Shape& a;
  const Shape& b;
  const Answers& answers;
  double unit;  ///< of relative errors, metres
};

struct Relation {
  std::string_view name;
  std::string_view says;  ///< in one line
  /// Does the relation say anything of such shapes?
  bool (*covers)(const PosedPair& pair);
  /// Empty, or what contradicts the relation. `random` draws what the relation needs.
  std::string (*check)(const Case& c, Random& random);
};

std::span<const Relation> relations();

Answers answer(const PosedPair& pair);
Answers answer(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin);

/// Empty, or what contradicts the relation. Throws std::invalid_argument where a shape of the pair is refused.
std::string check(const Relation& relation, const PosedPair& pair);

/// A pair that contradicts the relation too, with fewer triangles, fewer vertices and rounder numbers.
PosedPair minimal(const Relation& relation, PosedPair pair);

}  // namespace tandem::relations
