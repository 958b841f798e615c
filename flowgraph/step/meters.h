// Measurements of a step.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <string_view>

#include "step/clock.h"
#include "tandem/flowgraph/report.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem {

/// Measurements of a step: busy times of its phases, when they ended, serial times, and counts; slices for the
/// timeline.
class Meters {
 public:
  enum Phase : std::uint8_t { update, broad, narrow, join };

  void begin(Timeline* timeline);

  /// Adds to the busy time of a phase, for one thread.
  void add(Phase phase, Clock::duration time) { busy_[phase].ns.fetch_add(to_ns(time), std::memory_order_relaxed); }
  /// Adds to the time of the narrow phase that went to heavy pairs.
  void add_heavy(Clock::duration time, std::size_t pairs);
  /// Adds to the serial time of a phase, or of what precedes the first; by one thread at a time. `opening`: the time
  /// opened a stage and is no block's.
  void add_serial(Phase phase, Clock::duration time, bool opening);
  void add_begin(Clock::duration time);

  void update_ended(Clock::time_point now) { update_end_ = now - start_; }
  void shared_stage_began(Clock::time_point now) { shared_start_ = now; }
  void broad_ended() { broad_end_ = Clock::now() - shared_start_; }
  void narrow_ended(Clock::time_point now) { narrow_end_ = now - shared_start_; }

  void count_candidates(std::size_t pairs) { candidates_.fetch_add(pairs, std::memory_order_relaxed); }
  void saw_inexact() { inexact_.store(true, std::memory_order_relaxed); }
  /// Counts the batches that wait; may throw.
  void count_queue(std::size_t length);
  /// Writes a slice into the timeline, if there is one; may throw.
  void slice(std::string_view name, Clock::time_point begin, Clock::time_point end, std::uint64_t id,
             std::uint64_t pairs = 0, bool heavy = false);

  /// Time that the calling thread has spent on batches, to be subtracted from a tile in which a full queue made it
  /// narrow some.
  static Clock::duration& narrowed_by_this_thread();

  Clock::time_point start() const { return start_; }
  /// The busy time so far, all phases.
  double work_ms() const;
  /// Writes the report, at the step's end.
  void write(ExecutionReport& report) const;
  void end() { ++step_; }

 private:
  struct alignas(64) Busy {
    std::atomic<std::int64_t> ns{0};
  };
  double busy_ms(Phase phase) const { return to_ms(busy_[phase].ns.load(std::memory_order_relaxed)); }

  Timeline* timeline_ = nullptr;
  std::uint64_t step_ = 0;
  Clock::time_point start_, shared_start_;
  // Written only by the thread that opens a stage, has its only block, or finishes the last tile.
  std::array<Clock::duration, 4> serial_{};
  Clock::duration begin_{}, opening_{}, update_end_{}, broad_end_{}, narrow_end_{};

  std::array<Busy, 4> busy_;
  alignas(64) std::atomic<std::int64_t> heavy_ns_{0};
  std::atomic<std::uint64_t> heavy_pairs_{0}, candidates_{0};
  std::atomic<std::size_t> queue_high_water_{0};
  std::atomic<bool> inexact_{false};
};

}  // namespace tandem
