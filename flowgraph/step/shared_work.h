// Work within a batch that several threads share.
#pragma once
#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <vector>

namespace tandem {

class SharedParts;

/// Work within a batch that its thread shares, part by part, with threads that have nothing else to do.
class SharedWork {
 public:
  using Part = std::function<void(std::size_t)>;

  /// Runs part(0) ... part(parts - 1) on the calling thread and those that help; throws the first exception of a part,
  /// after the last one has ended. call() wakes the helpers.
  void share(std::size_t parts, const Part& part, const std::function<void()>& call);
  bool any() const { return count_.load(std::memory_order_relaxed) != 0; }
  /// Runs parts of some thread's shared work; false if there are none.
  bool help();

 private:
  alignas(64) std::atomic<int> count_{0};
  std::mutex mutex_;
  std::vector<SharedParts*> all_;  // batches with shared work in progress
};

}  // namespace tandem
