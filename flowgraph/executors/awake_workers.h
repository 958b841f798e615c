// Worker threads that spin between steps.
#pragma once
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <atomic>
#include <cstdint>
#include <list>

#include "step/clock.h"

namespace tandem {

/// Keeps workers of oneTBB awake between two steps: tasks in the step's arenas spin until the next step has work or
/// their time is over. A worker without a task falls asleep soon, and to wake it takes as long as a short step. Threads
/// remain the scheduler's: where it grants an arena no worker, the caller ends the tasks.
class AwakeWorkers {
 public:
  /// `microseconds`: the longest time that workers stay awake after a step; 0: they do not.
  explicit AwakeWorkers(double microseconds);
  ~AwakeWorkers() { end(); }
  AwakeWorkers(const AwakeWorkers&) = delete;
  AwakeWorkers& operator=(const AwakeWorkers&) = delete;

  /// After a step: keeps so many workers of the arena, which must outlive this object, awake from now on.
  void keep(tbb::task_arena& arena, int workers) noexcept;
  /// Sends the workers that are awake to the other tasks of their arena, which the next step has put there.
  void dismiss() { step_.fetch_add(1, std::memory_order_release); }
  /// Ends all spinning tasks; before an arena of theirs is made anew, since nobody would run the tasks left in the old
  /// one.
  void end();
  /// Milliseconds that workers spent awake since the last call, by the tasks that have ended.
  double take_ms() { return to_ms(spun_ns_.exchange(0, std::memory_order_relaxed)); }

 private:
  /// The spinning tasks of one arena; they are waited for in it.
  struct Group {
    explicit Group(tbb::task_arena& own) : arena(own) {}
    tbb::task_arena& arena;
    // An isolated context: the caller's may be cancelled, or end, before these tasks do.
    tbb::task_group_context context{tbb::task_group_context::isolated};
    tbb::task_group tasks{context};
  };

  Group& group_of(tbb::task_arena& arena);
  void stay(std::uint64_t step, Clock::time_point end) noexcept;

  Clock::duration time_;
  std::atomic<std::uint64_t> step_{0};
  alignas(64) std::atomic<std::int64_t> spun_ns_{0};
  std::list<Group> groups_;  // one for each arena
};

}  // namespace tandem
