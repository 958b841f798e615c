// Values that are computed at their first use.
#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Stores the value, if none is stored yet; returns the stored one.
template <class Value>
const Value& publish(std::atomic<const Value*>& place, Value&& value) {
  auto fresh = std::make_unique<const Value>(std::move(value));
  const Value* there = nullptr;
  if (!place.compare_exchange_strong(there, fresh.get(), std::memory_order_acq_rel)) return *there;
  return *fresh.release();
}

/// A value computed at its first use, by the first of several threads that asks; others wait, up to their own limits.
/// No lock is held while it is computed. If it is computed from another such value, a limit's function must not ask for
/// either from another thread than the one that computes it: the two would wait for each other. A copy computes its
/// own. Not to be moved or assigned while another thread asks.
template <class Value>
class Lazily {
 public:
  Lazily() = default;
  Lazily(const Lazily&) {}
  Lazily(Lazily&& other) noexcept : made_(other.made_.exchange(nullptr)) {}
  Lazily& operator=(const Lazily& other) {
    if (this != &other) clear();
    return *this;
  }
  Lazily& operator=(Lazily&& other) noexcept {
    if (this != &other) delete made_.exchange(other.made_.exchange(nullptr));
    return *this;
  }
  ~Lazily() { delete made_.load(); }

  void clear() { delete made_.exchange(nullptr); }

  /// `make(limit)` returns a Value; an exception is rethrown, and the next thread that asks computes it. A thread that
  /// asks while computing it itself, from within the limit's function, computes it without a limit.
  template <class Make>
  const Value& get(const WorkLimit* limit, Make&& make) const {
    using namespace std::chrono_literals;
    const std::thread::id self = std::this_thread::get_id();
    std::chrono::microseconds pause = 1us;
    for (;;) {
      if (const Value* made = made_.load(std::memory_order_acquire)) return *made;
      std::thread::id maker;  // no thread
      if (maker_.compare_exchange_strong(maker, self, std::memory_order_acq_rel)) break;
      if (maker == self) return publish(made_, make(nullptr));
      if (limit != nullptr && limit->reached()) throw WorkStopped();
      std::this_thread::sleep_for(pause);
      pause = std::min(2 * pause, limit != nullptr ? between_limits : longest_pause);
    }
    const Leave leave{maker_};
    if (const Value* made = made_.load(std::memory_order_acquire)) return *made;
    return publish(made_, make(limit));
  }
  /// Null if it has not been computed.
  const Value* made() const { return made_.load(std::memory_order_acquire); }

 private:
  static constexpr std::chrono::microseconds between_limits{32};  // interval at which a waiting thread checks its limit
  static constexpr std::chrono::microseconds longest_pause{1000};

  struct Leave {
    std::atomic<std::thread::id>& maker;
    ~Leave() { maker.store({}, std::memory_order_release); }
  };

  mutable std::atomic<const Value*> made_{nullptr};
  mutable std::atomic<std::thread::id> maker_{};
};

/// A small value, quickly computed, at its first use: no thread waits, and of two threads that compute it at once the
/// second discards its result.
template <class Value>
class MadeOnce {
 public:
  MadeOnce() = default;
  MadeOnce(const MadeOnce&) = delete;
  MadeOnce& operator=(const MadeOnce&) = delete;
  ~MadeOnce() { delete made_.load(); }

  template <class Make>
  const Value& get(Make&& make) const {
    if (const Value* made = made_.load(std::memory_order_acquire)) return *made;
    return publish(made_, make());
  }
  bool is_made() const { return made_.load(std::memory_order_acquire) != nullptr; }

 private:
  mutable std::atomic<const Value*> made_{nullptr};
};

}  // namespace tandem
