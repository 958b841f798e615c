// A pool of working memory for concurrent calls.
#pragma once
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace tandem::detail {

/// A pool of working memory for calls that may run at the same time: as many objects as were ever in use at once, kept
/// for later calls. An object is lent to one call at a time, also where a callback of a call begins another one on the
/// same thread, which thread-local memory would not allow.
template <class T>
class ScratchPool {
 public:
  /// A loan of an object, given back by the destructor.
  class Lease {
   public:
    explicit Lease(ScratchPool& pool) : pool_(pool), object_(pool.take()) {}
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    ~Lease() { pool_.give_back(std::move(object_)); }

    T& operator*() const { return *object_; }
    T* operator->() const { return object_.get(); }

   private:
    ScratchPool& pool_;
    std::unique_ptr<T> object_;
  };

  /// Bytes held by objects that are not in use; `bytes(object)` returns an object's own heap memory.
  template <class Bytes>
  std::size_t memory(const Bytes& bytes) const {
    const std::lock_guard lock(mutex_);
    std::size_t total = free_.capacity() * sizeof(free_[0]);
    for (const std::unique_ptr<T>& object : free_) total += sizeof(T) + bytes(*object);
    return total;
  }
  /// The same, where T::memory() returns an object's heap memory.
  std::size_t memory() const {
    return memory([](const T& object) { return object.memory(); });
  }

 private:
  std::unique_ptr<T> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) {
      free_.reserve(++made_);  // so that giving back allocates nothing
      return std::make_unique<T>();
    }
    std::unique_ptr<T> object = std::move(free_.back());
    free_.pop_back();
    return object;
  }
  void give_back(std::unique_ptr<T> object) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(object));
  }

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
  std::size_t made_ = 0;
};

}  // namespace tandem::detail
