// A value that is made when it is first asked for.
#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

namespace tandem {

/// Made by the first who asks, from any of several threads; who asks meanwhile waits. A copy makes its own anew. Not to
/// be moved or assigned to while another thread asks.
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

  /// `make()` is a Value; what it throws is thrown, and the next who asks makes it.
  template <class Make>
  const Value& get(Make&& make) const {
    if (const Value* made = made_.load(std::memory_order_acquire)) return *made;
    const std::scoped_lock lock(mutex_);
    if (const Value* made = made_.load(std::memory_order_acquire)) return *made;
    auto fresh = std::make_unique<const Value>(make());
    made_.store(fresh.get(), std::memory_order_release);
    return *fresh.release();
  }
  /// Null if nobody has asked.
  const Value* made() const { return made_.load(std::memory_order_acquire); }

 private:
  mutable std::atomic<const Value*> made_{nullptr};
  mutable std::mutex mutex_;
};

/// The same for what takes little room and time to make: nobody waits, and of two who make it at once the second throws
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
    auto fresh = std::make_unique<const Value>(make());
    const Value* there = nullptr;
    if (!made_.compare_exchange_strong(there, fresh.get(), std::memory_order_acq_rel)) return *there;
    return *fresh.release();
  }
  bool is_made() const { return made_.load(std::memory_order_acquire) != nullptr; }

 private:
  mutable std::atomic<const Value*> made_{nullptr};
};

}  // namespace tandem
