#pragma once
#include <pybind11/pybind11.h>

#include <mutex>
#include <optional>
#include <shared_mutex>
#include <utility>

namespace tandem::python {

/// Lets other threads of Python run, until it ends; also where the caller has released the GIL before.
class WithoutGil {
 public:
  WithoutGil() {
    if (PyGILState_Check() != 0) released_.emplace();
  }

 private:
  std::optional<pybind11::gil_scoped_release> released_;
};

/// An object that several of Python's threads may hold: as C++ works without the GIL, one thread must not change what
/// another reads. Both calls run `work` without the GIL, so it may not touch Python's objects.
template <class Object>
class SharedUse {
 public:
  template <class... Arguments>
  explicit SharedUse(Arguments&&... arguments) : object_(std::forward<Arguments>(arguments)...) {}

  /// Together with others that read.
  template <class Work>
  auto read(Work&& work) const {
    const WithoutGil released;
    const std::shared_lock lock(mutex_);
    return work(object_);
  }
  /// Alone.
  template <class Work>
  auto change(Work&& work) {
    const WithoutGil released;
    const std::unique_lock lock(mutex_);
    return work(object_);
  }

 private:
  Object object_;
  mutable std::shared_mutex mutex_;
};

}  // namespace tandem::python
