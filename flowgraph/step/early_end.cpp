// Reasons to end a step early.
#include "step/early_end.h"

#include <utility>

namespace tandem {

void EarlyEnd::begin(std::stop_token stop, std::function<bool()> host_cancelled) {
  stop_ = std::move(stop);
  host_cancelled_ = std::move(host_cancelled);
  found_.store(false, std::memory_order_relaxed);
  error_ = nullptr;
}

void EarlyEnd::capture() noexcept {
  const std::scoped_lock lock(mutex_);
  if (!error_) error_ = std::current_exception();
  found_.store(true, std::memory_order_relaxed);
}

void EarlyEnd::rethrow() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

}  // namespace tandem
