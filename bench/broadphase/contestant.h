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

/// Pairs as a contestant finds them, with the moment when the first batch of them was there.
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
  /// Takes a whole batch; `since` is when it was full.
  void put(const Pair* pairs, std::size_t count, Clock::time_point since) {
    if (pairs_.empty() || since < first_batch_) first_batch_ = since;
    pairs_.insert(pairs_.end(), pairs, pairs + count);
  }
  std::vector<Pair>& pairs() { return pairs_; }
  /// When the first batch was full; zero when there was none.
  Clock::time_point first_batch() const { return first_batch_; }

 private:
  std::vector<Pair> pairs_;
  Clock::time_point first_batch_{};
};

/// One broad phase in a race. A step is: take the new boxes, update, report every overlapping pair.
class BoxContestant {
 public:
  virtual ~BoxContestant() = default;
  virtual std::string name() const = 0;
  virtual int threads() const { return 1; }
  /// False for one that reports pairs twice, or pairs of boxes larger than the given ones.
  virtual bool exact() const { return true; }
  /// Appends to `out`. An empty box (lo > hi) is a body that is not there.
  virtual void step(const BoxArray& boxes, PairList& out) = 0;
  /// The filter of the steps that follow. False for one that finds what is forbidden too.
  virtual bool filter(const PairFilter&) { return false; }
  /// Which boxes are not as in the step before, one byte each; told before every step but the first, where it is known.
  virtual void changes(std::span<const std::uint8_t>) {}
  /// Bytes held between steps; 0 where that is not known.
  virtual std::size_t memory() const { return 0; }
  /// What it chose, if it chooses.
  virtual std::string note() const { return {}; }
};

using Contestants = std::vector<std::unique_ptr<BoxContestant>>;

std::unique_ptr<BoxContestant> tandem_contestant(BroadPhaseKind kind, int threads);
std::unique_ptr<BoxContestant> fcl_contestant();
// Where the library was there at build time.
std::unique_ptr<BoxContestant> embree_contestant(bool refit, int threads);
std::unique_ptr<BoxContestant> bullet_contestant();
std::unique_ptr<BoxContestant> cgal_contestant();

}  // namespace tandem::bench
