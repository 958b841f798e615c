// Queries of many pairs at once.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// Receives answers one after the other.
class AnswerSink {
 public:
  virtual ~AnswerSink() = default;
  /// Returns a place for the answer of this pair, whose contacts are appended next.
  virtual PairAnswer& begin(std::size_t pair) = 0;
  /// The answer and its contacts are complete.
  virtual void end() = 0;
};

/// A sphere in the world: radius and centre in one place, where a shape and a pose are two places in memory.
struct PlacedSphere {
  Vec3 centre;
  double radius;
};

/// The two shapes of a pair that are spheres; null: another shape, or one to be read from shape and pose.
struct PlacedSpheres {
  const PlacedSphere* a = nullptr;
  const PlacedSphere* b = nullptr;
};

/// Memory for answers with a contact each, one after the other; default-constructed, and as many as there are pairs.
struct AnswerPlaces {
  PairAnswer* answers;
  std::size_t stride;  ///< bytes from one answer to the next: they may be members of larger objects
  Contact* contacts;
  std::uint32_t* pairs;  ///< the numbers of the pairs that were answered
};

/// The number of leading pairs that are done, and the number of these that have an answer.
struct SpheresSolved {
  std::size_t pairs = 0, answers = 0;
};

/// Solves several pairs with Request::contacts: the same bits as one by one (`NarrowPhase::solve`), but spheres and
/// boxes, each with their own kind and with half-spaces, several at a time, a pair a lane. Const and safe from any
/// number of threads.
class SeveralPairs {
 public:
  /// Throws as NarrowPhase does.
  explicit SeveralPairs(const NarrowPhaseOptions& options = {})
      : one_by_one_(options), margin_(options.margin), by_kind_(options.solver.empty()) {}

  /// Answers come in the order of the pairs; pairs farther apart than the margin may be skipped. Contacts are appended.
  /// Throws std::invalid_argument for a pair that NarrowPhase::refuses names. `spheres`: empty, or one element a pair,
  /// whose spheres are used instead of the pair's shape and pose.
  void solve(std::span<const PlacedPair> pairs, std::vector<Contact>& contacts, AnswerSink& answers,
             std::span<const PlacedSpheres> spheres = {}) const;

  /// Solves pairs of spheres, none null and every radius finite, up to the first pair that rounding decides, which must
  /// go to `solve`.
  SpheresSolved solve_spheres(std::span<const PlacedSpheres> pairs, const AnswerPlaces& to) const;

  static constexpr std::size_t most_screened = 32;
  /// Screens at most so many pairs of spheres, none null: bit i is set unless pair i is farther apart than the margin.
  /// A sphere of infinite radius is near all.
  std::uint32_t near(std::span<const PlacedSpheres> pairs) const;

 private:
  NarrowPhase one_by_one_;
  double margin_;
  bool by_kind_;  // no solver is forced
};

}  // namespace tandem
