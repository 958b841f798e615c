// Workers of oneTBB that spin between two steps, so that the next step finds them awake.
#include "executors/awake_workers.h"

#include <algorithm>
#include <thread>

#include "step/pause.h"

namespace tandem {

AwakeWorkers::AwakeWorkers(double microseconds)
    : time_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double, std::micro>(microseconds))) {}

void AwakeWorkers::end() {
  dismiss();
  for (Group& group : groups_) group.arena.execute([&] { group.tasks.wait(); });
}

AwakeWorkers::Group& AwakeWorkers::group_of(tbb::task_arena& arena) {
  const auto known = std::ranges::find_if(groups_, [&](const Group& group) { return &group.arena == &arena; });
  return known != groups_.end() ? *known : groups_.emplace_back(arena);
}

void AwakeWorkers::keep(tbb::task_arena& arena, int workers) noexcept {
  if (time_ == Clock::duration::zero() || workers == 0) return;
  const std::uint64_t step = step_.load(std::memory_order_relaxed);
  const Clock::time_point end = Clock::now() + time_;
  try {
    Group& group = group_of(arena);
    arena.execute([&] {
      for (int i = 0; i < workers; ++i) group.tasks.run([this, step, end] { stay(step, end); });
    });
  } catch (...) {  // Without memory for a task workers fall asleep, and the step's answer is there.
  }
}

void AwakeWorkers::stay(std::uint64_t step, Clock::time_point end) noexcept {
  constexpr int pauses = 32;  // A microsecond or two between readings of the clock.
  const Clock::time_point begin = Clock::now();
  Clock::time_point now = begin;
  for (; step_.load(std::memory_order_acquire) == step && now < end; now = Clock::now()) {
    for (int i = 0; i < pauses && step_.load(std::memory_order_relaxed) == step; ++i) pause();
    std::this_thread::yield();  // Yields to threads of the host that wait for this core.
  }
  spun_ns_.fetch_add(to_ns(now - begin), std::memory_order_relaxed);
}

}  // namespace tandem
