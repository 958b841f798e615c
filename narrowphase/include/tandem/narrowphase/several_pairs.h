#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// Takes answers one after the other.
class AnswerSink {
 public:
  virtual ~AnswerSink() = default;
  /// Room for the answer of the pair of that number; its contacts will be appended next.
  virtual PairAnswer& begin(std::size_t pair) = 0;
  /// The answer and its contacts are there.
  virtual void end() = 0;
};

/// A sphere where it is, in the world: side by side what is read of it, where a shape and a pose are two places in
/// memory.
struct PlacedSphere {
  Vec3 centre;
  double radius;
};

/// Those of a pair of placed shapes that are spheres; null: another shape, or one to be made from shape and pose.
struct PlacedSpheres {
  const PlacedSphere* a = nullptr;
  const PlacedSphere* b = nullptr;
};

/// Where answers with a contact each are written, one after the other; as they come from their constructors, and so
/// many as there are pairs.
struct AnswerPlaces {
  PairAnswer* answers;
  std::size_t stride;  ///< bytes from an answer to the next: they may be part of something larger
  Contact* contacts;
  std::uint32_t* pairs;  ///< the numbers of the pairs that were answered
};

/// How many of the first pairs are done with, and how many of these were worth an answer.
struct SpheresSolved {
  std::size_t pairs = 0, answers = 0;
};

/// Solves several pairs in turn with Request::contacts: the same bits as one by one (`NarrowPhase::solve`), but spheres
/// and boxes, each with its like and with half-spaces, several at a time, a pair a lane. Const and safe from any number
/// of threads.
class SeveralPairs {
 public:
  /// Throws as NarrowPhase does.
  explicit SeveralPairs(const NarrowPhaseOptions& options = {})
      : one_by_one_(options), margin_(options.margin), by_kind_(options.solver.empty()) {}

  /// Answers come in the order of the pairs; some that are farther apart than the margin are passed over. Contacts are
  /// appended.
  /// Throws std::invalid_argument for a pair that NarrowPhase::refuses names.
  /// `spheres`: none, or one element a pair; what is given there is read instead of the pair's shape and pose.
  void solve(std::span<const PlacedPair> pairs, std::vector<Contact>& contacts, AnswerSink& answers,
             std::span<const PlacedSpheres> spheres = {}) const;

  /// Solves pairs of spheres, none null and every radius finite, as far as pairs are solved together: up to the
  /// first one that rounding decides, which `solve` has a solver for.
  SpheresSolved solve_spheres(std::span<const PlacedSpheres> pairs, const AnswerPlaces& to) const;

  static constexpr std::size_t most_screened = 32;
  /// Screens at most so many pairs of spheres, none null: bit i is set unless pair i is farther apart than the margin.
  /// What has an infinite radius is near all.
  std::uint32_t near(std::span<const PlacedSpheres> pairs) const;

 private:
  NarrowPhase one_by_one_;
  double margin_;
  bool by_kind_;  // no solver is forced
};

}  // namespace tandem
