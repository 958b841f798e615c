// Objects shared by threads of Python: releasing the GIL, and locking.
#pragma once
#include <pybind11/pybind11.h>

#include <mutex>
#include <optional>
#include <shared_mutex>
#include <stdexcept>
#include <utility>

namespace tandem::python {

/// Releases the GIL while it lives; also where the caller has released it before.
class WithoutGil {
 public:
  WithoutGil() {
    if (PyGILState_Check() != 0) released_.emplace();
  }

 private:
  std::optional<pybind11::gil_scoped_release> released_;
};

/// The objects that are being read by the calls to which a thread's progress functions belong: changing one of them
/// would wait for itself.
class LookedAt {
 public:
  LookedAt(const void* object, const LookedAt* outer) : object_(object), outer_(outer), before_(of_thread()) {
    of_thread() = this;
  }
  ~LookedAt() { of_thread() = before_; }
  LookedAt(const LookedAt&) = delete;
  LookedAt& operator=(const LookedAt&) = delete;

  /// The objects in use by the progress function that runs on this thread; null outside of one.
  static const LookedAt*& of_thread() {
    static thread_local const LookedAt* innermost = nullptr;
    return innermost;
  }
  static bool has(const void* object) {
    const LookedAt* at = of_thread();
    while (at != nullptr && at->object_ != object) at = at->outer_;
    return at != nullptr;
  }

 private:
  const void* object_;
  const LookedAt *outer_, *before_;  // those of the call around this one; those that the thread had before
};

/// An object that several threads of Python may use: since C++ works without the GIL, one thread must not change what
/// another reads. Both calls run `work` without the GIL, so it may not touch Python objects.
template <class Object>
class SharedUse {
 public:
  template <class... Arguments>
  explicit SharedUse(Arguments&&... arguments) : object_(std::forward<Arguments>(arguments)...) {}

  /// Runs work that reads, concurrently with others.
  template <class Work>
  auto read(Work&& work) const {
    const WithoutGil released;
    std::shared_lock lock(mutex_, std::defer_lock);
    if (!LookedAt::has(this)) lock.lock();
    return work(object_);
  }
  /// Runs work that changes, alone. Throws std::runtime_error from a progress function of a call that reads it.
  template <class Work>
  auto change(Work&& work) {
    if (LookedAt::has(this))
      throw std::runtime_error(
          "a progress function cannot change what its own call looks at: it would wait for itself");
    const WithoutGil released;
    const std::unique_lock lock(mutex_);
    return work(object_);
  }

 private:
  Object object_;
  mutable std::shared_mutex mutex_;
};

}  // namespace tandem::python
