#pragma once
#include <cstddef>
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

/// Solves several pairs in turn with Request::contacts: the same bits as one by one (`NarrowPhase::solve`), but boxes
/// with boxes and with half-spaces several at a time, a pair a lane. Const and safe from any number of threads.
class SeveralPairs {
 public:
  /// Throws as NarrowPhase does.
  explicit SeveralPairs(const NarrowPhaseOptions& options = {})
      : one_by_one_(options), margin_(options.margin), by_kind_(options.solver.empty()) {}

  /// Answers come in the order of the pairs; some that are farther apart than the margin are passed over. Contacts are
  /// appended.
  void solve(std::span<const PlacedPair> pairs, std::vector<Contact>& contacts, AnswerSink& answers) const;

 private:
  NarrowPhase one_by_one_;
  double margin_;
  bool by_kind_;  // no solver is forced
};

}  // namespace tandem
