// Early end of a step.
#pragma once
#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>

namespace tandem {

/// The reason why the rest of a step is counted off without being run: the first exception, a stop request, or the
/// host's cancellation.
class EarlyEnd {
 public:
  /// `host_cancelled` may be empty.
  void begin(std::stop_token stop, std::function<bool()> host_cancelled);

  /// True if a reason was found so far.
  bool found() const { return found_.load(std::memory_order_relaxed); }
  /// The same, after polling the stop request and the host; called by the thread that is about to run a block.
  bool check() {
    if (!found() && (stop_.stop_requested() || (host_cancelled_ && host_cancelled_())))
      found_.store(true, std::memory_order_relaxed);
    return found();
  }
  /// Keeps the exception being handled, if it is the first.
  void capture() noexcept;
  /// Runs the body and keeps what it throws; false if it threw.
  template <class Body>
  bool guard(Body&& body) noexcept {
    try {
      body();
      return true;
    } catch (...) {
      capture();
      return false;
    }
  }
  /// Throws the kept exception, once; at the step's end, by one thread.
  void rethrow();

 private:
  std::atomic<bool> found_{false};
  std::stop_token stop_;
  std::function<bool()> host_cancelled_;
  std::mutex mutex_;
  std::exception_ptr error_;
};

}  // namespace tandem
