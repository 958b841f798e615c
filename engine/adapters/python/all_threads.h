// Distribution of work over the caller's threads.
#pragma once
#include <tbb/parallel_for.h>

#include <cstddef>
#include <functional>

namespace tandem::python {

/// A PartRunner that distributes the work over the threads of the caller's arena.
inline void on_all_threads(std::size_t parts, const std::function<void(std::size_t)>& part) {
  tbb::parallel_for(std::size_t{0}, parts, part);
}

}  // namespace tandem::python
