// Work within a batch that several threads share, part by part.
#include "step/shared_work.h"

#include <algorithm>
#include <exception>

#include "step/pause.h"

namespace tandem {

/// The parts of one batch's work: each thread takes the next one until there is none.
class SharedParts {
 public:
  SharedParts(std::size_t parts, const SharedWork::Part& part) : parts_(parts), part_(part) {}
  bool all_taken() const { return next_.load(std::memory_order_relaxed) >= parts_; }

  /// Runs a part; keeps its exception, after which the remaining parts are not run.
  void work() noexcept {
    for (std::size_t part; (part = next_.fetch_add(1, std::memory_order_relaxed)) < parts_;) {
      try {
        part_(part);
      } catch (...) {
        const std::scoped_lock lock(mutex_);
        if (!error_) error_ = std::current_exception();
        next_.store(parts_, std::memory_order_relaxed);
      }
    }
  }

  /// Returns after the last helper has left.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

  std::atomic<int> helpers{0};  ///< helpers that have not left yet

 private:
  std::size_t parts_;
  const SharedWork::Part& part_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::exception_ptr error_;
};

void SharedWork::share(std::size_t parts, const Part& part, const std::function<void()>& call) {
  SharedParts own(parts, part);
  {
    const std::scoped_lock lock(mutex_);
    all_.push_back(&own);
    count_.fetch_add(1, std::memory_order_relaxed);
  }
  call();
  own.work();
  {
    const std::scoped_lock lock(mutex_);
    std::erase(all_, &own);
    count_.fetch_sub(1, std::memory_order_relaxed);
  }
  while (own.helpers.load(std::memory_order_acquire) != 0) pause();
  own.rethrow();
}

bool SharedWork::help() {
  if (!any()) return false;
  SharedParts* some = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    const auto at =
        std::find_if(all_.begin(), all_.end(), [](const SharedParts* parts) { return !parts->all_taken(); });
    if (at == all_.end()) return false;
    some = *at;
    some->helpers.fetch_add(1, std::memory_order_relaxed);
  }
  some->work();
  some->helpers.fetch_sub(1, std::memory_order_release);
  return true;
}

}  // namespace tandem
