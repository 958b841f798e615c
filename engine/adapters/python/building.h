// Progress and timeout of building meshes from Python.
#pragma once
#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include "all_threads.h"
#include "shared_use.h"
#include "tandem/narrowphase/build_options.h"
#include "timeout.h"

namespace tandem::python {

/// Throws std::invalid_argument "WHAT: ..." unless the argument is callable or None.
inline void require_callable(const pybind11::object& callback, const char* what) {
  if (!callback.is_none() && PyCallable_Check(callback.ptr()) == 0)
    throw std::invalid_argument(std::string(what) + ": " + std::string(pybind11::str(pybind11::type::of(callback))) +
                                ", allowed: a function, or None");
}

/// A Python function that is told the progress of work, as C++ calls it: from any thread, with the GIL. An exception it
/// raises ends the work and is raised there. None: empty. The callback must outlive it, since copies are made without
/// the GIL. `looked_at`: the SharedUse that the call reads, if any.
template <class... Numbers>
std::function<void(Numbers...)> progress_of(const pybind11::object& callback, const void* looked_at = nullptr) {
  require_callable(callback, "progress");
  if (callback.is_none()) return {};
  return [&callback, looked_at, outer = LookedAt::of_thread()](Numbers... numbers) {
    const LookedAt here(looked_at, outer);
    const pybind11::gil_scoped_acquire held;
    callback(numbers...);
  };
}

/// Options for building a mesh's hierarchy: on all threads, with Python's progress function. The callback must outlive
/// it.
class Building {
 public:
  Building(const pybind11::object& progress, std::optional<double> timeout) : limit_(limit_after(timeout)) {
    options_.parts = on_all_threads;
    options_.progress = progress_of<double>(progress);
    if (timeout) options_.limit = &limit_;
  }
  Building(const Building&) = delete;
  Building& operator=(const Building&) = delete;
  const BuildOptions& options() const { return options_; }

 private:
  WorkLimit limit_;
  BuildOptions options_;
};

}  // namespace tandem::python
