// Memory that calls from many threads use again.
#pragma once
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace tandem {

/// As many things as were ever in use at once, each lent to one call at a time: also to one that a callback of another
/// begins on the same thread, which memory of the thread would not stand.
template <class Thing>
class Pool {
 public:
  class Lease {
   public:
    explicit Lease(Pool& pool) : pool_(pool), thing_(pool.take()) {}
    ~Lease() { pool_.give_back(std::move(thing_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;

    Thing& operator*() const { return *thing_; }
    Thing* operator->() const { return thing_.get(); }

   private:
    Pool& pool_;
    std::unique_ptr<Thing> thing_;
  };

  /// Bytes of what is not lent; `bytes(thing)` is what a thing holds beside itself.
  template <class Bytes>
  std::size_t memory(const Bytes& bytes) const {
    const std::lock_guard lock(mutex_);
    std::size_t total = idle_.capacity() * sizeof(idle_[0]);
    for (const std::unique_ptr<Thing>& thing : idle_) total += sizeof(Thing) + bytes(*thing);
    return total;
  }

 private:
  std::unique_ptr<Thing> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) {
      idle_.reserve(++made_);  // so that giving back never fails
      return std::make_unique<Thing>();
    }
    std::unique_ptr<Thing> thing = std::move(idle_.back());
    idle_.pop_back();
    return thing;
  }
  void give_back(std::unique_ptr<Thing> thing) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(thing));
  }

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Thing>> idle_;
  std::size_t made_ = 0;
};

}  // namespace tandem
