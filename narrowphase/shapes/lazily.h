// A value that is made when it is first asked for.
#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Puts the value there, if none is yet; returns the one that is there.
template <class Value>
const Value& publish(std::atomic<const Value*>& place, Value&& value) {
  auto fresh = std::make_unique<const Value>(std::move(value));
  const Value* there = nullptr;
  if (!place.compare_exchange_strong(there, fresh.get(), std::memory_order_acq_rel)) return *there;
  return *fresh.release();
}

/// Made by the first who asks, from any of several threads; who asks meanwhile waits, up to a limit of its own. No lock
/// is held while it is made. Where it is made of another such value, a limit's function must not ask for either from
/// another thread than the one that makes it: the two would wait for each other. A copy makes its own anew. Not to be
/// moved or assigned to while another thread asks.
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

  /// `make(limit)` is a Value; what it throws is thrown, and the next who asks makes it. Who asks while it makes it
  /// itself, from within the limit's function, makes it without a limit.
  template <class Make>
  const Value& get(const WorkLimit* limit, Make&& make) const {
    using namespace std::chrono_literals;
    const std::thread::id self = std::this_thread::get_id();
    std::chrono::microseconds pause = 1us;
    for (;;) {
      if (const Value* made = made_.load(std::memory_order_acquire)) return *made;
      std::thread::id maker;  // nobody
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
  /// Null if nobody has asked.
  const Value* made() const { return made_.load(std::memory_order_acquire); }

 private:
  static constexpr std::chrono::microseconds between_limits{32};  // of one who waits, between two looks at its limit
  static constexpr std::chrono::microseconds longest_pause{1000};

  struct Leave {
    std::atomic<std::thread::id>& maker;
    ~Leave() { maker.store({}, std::memory_order_release); }
  };

  mutable std::atomic<const Value*> made_{nullptr};
  mutable std::atomic<std::thread::id> maker_{};
};

/// A value made once, small and quickly made: nobody waits, and of two threads that make it at once the second throws
/// its own away.
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
