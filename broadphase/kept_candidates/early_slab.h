// The first pairs of a step, found before the rest of the broad phase is prepared.
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/column_pairs.h"
#include "storage/unfiltered_sink.h"
#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

/// The early pairs of a step, found before the rest of the broad phase is prepared so that the first batches can leave:
/// pairs whose intersection begins, on one axis, within a thin slab. Their boxes are found by one scan along two
/// arrays.
class EarlySlab {
 public:
  /// Starts a step without a slab.
  void leave_out() { state_.store(State::none, std::memory_order_relaxed); }
  /// Starts a step: chooses a slab of some hundred boxes from a sample of them, or none where there are few boxes in
  /// all or a thin slab would hold many. `boxes` must outlive the step. By one thread, as `leave_out`.
  void choose(const BoxArray& boxes, const std::vector<Aabb>& sample);

  /// True if there are early pairs; the first call searches for their boxes. Depends on the boxes only. Threads may
  /// call it at the same time: one searches, the others wait.
  bool taken();
  /// Puts the early pairs into the sink, each once.
  void emit(PairSink& sink);

  /// After taken(): true if a pair of boxes with these lower bounds on the axis is an early one.
  bool holds(float lo_a, float lo_b) const {
    const float lo = std::max(lo_a, lo_b);
    return begin_ <= lo && lo < end_;
  }
  std::size_t axis() const { return axis_; }
  float begin() const { return begin_; }
  float end() const { return end_; }
  std::size_t memory() const;

 private:
  enum class State : std::uint8_t { none, chosen, searching, taken };

  bool search();

  const BoxArray* boxes_ = nullptr;
  std::atomic<State> state_{State::none};
  std::size_t axis_ = 0, along_ = 0, most_ = 0;
  float begin_ = 0, end_ = 0;
  std::vector<std::uint32_t> found_;
  std::vector<ColumnRecord> records_;
  ColumnScratch scratch_;
};

/// A sink that passes on all pairs but the early ones. To be flushed at the end.
class LaterPairs final : public UnfilteredSink<256> {
 public:
  LaterPairs(const EarlySlab& slab, const BoxArray& boxes, PairSink& sink)
      : slab_(slab), lo_(boxes.lo(static_cast<int>(slab.axis()))), sink_(sink) {}

 private:
  void take(std::span<const Pair> pairs) override {
    for (const Pair pair : pairs)
      if (!slab_.holds(lo_[pair.a], lo_[pair.b])) sink_.put(pair.a, pair.b);
  }
  const EarlySlab& slab_;
  const float* lo_;
  PairSink& sink_;
};

}  // namespace tandem
