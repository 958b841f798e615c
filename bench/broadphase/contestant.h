// Contestants of the broad-phase bench: a broad phase each.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem::bench {

using Clock = std::chrono::steady_clock;

/// The pairs that a contestant finds, with the time at which the first batch of them was available.
class PairList {
 public:
  static constexpr std::size_t batch = 256;

  void clear() {
    pairs_.clear();
    first_batch_ = {};
  }
  void put(std::uint32_t a, std::uint32_t b) {
    pairs_.push_back(a < b ? Pair{a, b} : Pair{b, a});
    if (pairs_.size() == batch) first_batch_ = Clock::now();
  }
  /// Takes a whole batch, which was full at `since`.
  void put(const Pair* pairs, std::size_t count, Clock::time_point since) {
    if (pairs_.empty() || since < first_batch_) first_batch_ = since;
    pairs_.insert(pairs_.end(), pairs, pairs + count);
  }
  std::vector<Pair>& pairs() { return pairs_; }
  /// The time at which the first batch was full; zero when there was none.
  Clock::time_point first_batch() const { return first_batch_; }

 private:
  std::vector<Pair> pairs_;
  Clock::time_point first_batch_{};
};

/// A broad phase in a race. A step is: take the new boxes, update, report every overlapping pair.
class BoxContestant {
 public:
  virtual ~BoxContestant() = default;
  virtual std::string name() const = 0;
  virtual int threads() const { return 1; }
  /// False for a contestant that reports pairs twice, or pairs of boxes larger than the given ones.
  virtual bool exact() const { return true; }
  /// Runs a step; appends the pairs to `out`. An empty box (lo > hi) is a body that is absent.
  virtual void step(const BoxArray& boxes, PairList& out) = 0;
  /// Sets the filter of the following steps. False for a contestant that reports forbidden pairs, too.
  virtual bool filter(const PairFilter&) { return false; }
  /// Tells which boxes may have changed since the step before, one byte each; before every step but the first, where
  /// known.
  virtual void changes(std::span<const std::uint8_t>) {}
  /// Bytes held between steps; 0 if unknown.
  virtual std::size_t memory() const { return 0; }
  /// The method chosen, for a contestant that chooses.
  virtual std::string note() const { return {}; }
};

using Contestants = std::vector<std::unique_ptr<BoxContestant>>;

std::unique_ptr<BoxContestant> tandem_contestant(BroadPhaseKind kind, int threads);
std::unique_ptr<BoxContestant> fcl_contestant();
// Only where the library was found at build time.
std::unique_ptr<BoxContestant> embree_contestant(bool refit, int threads);
std::unique_ptr<BoxContestant> bullet_contestant();
std::unique_ptr<BoxContestant> cgal_contestant();

}  // namespace tandem::bench
