// Threads that start one job at the same time.
#pragma once
#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace tandem::bench {

/// Threads that begin the same job at the same time: the caller and copies - 1 others, which sleep between two jobs.
/// None begins before all are awake.
class AtOnce {
 public:
  explicit AtOnce(int copies);
  ~AtOnce();
  AtOnce(const AtOnce&) = delete;
  AtOnce& operator=(const AtOnce&) = delete;

  /// Runs job(i) for i in [0, copies), each on its own thread; returns when all have ended. The job must not throw.
  void run(const std::function<void(int)>& job);

 private:
  void meet();

  const int copies_;
  const std::function<void(int)>* job_ = nullptr;
  std::atomic<std::uint32_t> turn_{0};
  std::atomic<int> awake_{0}, left_{0};
  std::atomic<bool> leaving_{false};
  std::vector<std::jthread> others_;
};

/// The name of a contestant in several copies: "2 copies".
std::string copies_name(int copies);

}  // namespace tandem::bench
