// Relations between answers of the narrow phase that hold whatever the right answer is: they need no oracle.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "posed_pair.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::relations {

/// The answers for a pair to all requests.
struct Answers {
  bool collide = false;
  PairAnswer distance, contacts, near;    ///< near: contacts with the pair's margin
  std::vector<Contact> touching, within;  ///< of `contacts`, of `near`
};

/// A pair with the answers that its relations share.
struct Case {
  const PosedPair& pair;
  const Shape& a;
  const Shape& b;
  const Answers& answers;
  double unit;  ///< of relative errors, metres
};

struct Relation {
  std::string_view name;
  std::string_view says;  ///< description, one line
  /// True if the relation applies to such shapes.
  bool (*covers)(const PosedPair& pair);
  /// Returns an empty string, or the contradiction. `random` draws what the relation needs.
  std::string (*check)(const Case& c, Random& random);
};

std::span<const Relation> relations();

Answers answer(const PosedPair& pair);
Answers answer(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin);

/// Returns an empty string, or the contradiction. Throws std::invalid_argument if a shape of the pair is refused.
std::string check(const Relation& relation, const PosedPair& pair);

/// A pair that still contradicts the relation, with fewer triangles, fewer vertices and rounder numbers.
PosedPair minimal(const Relation& relation, PosedPair pair);

}  // namespace tandem::relations
