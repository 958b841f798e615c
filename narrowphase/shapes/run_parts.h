// Loops over parts of an array, on the threads of a runner.
#pragma once
#include <algorithm>

#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// Runs the parts; without a runner the caller does all.
inline void run_parts(const PartRunner& runner, std::size_t parts, const std::function<void(std::size_t)>& part) {
  if (runner && parts > 1) return runner(parts, part);
  for (std::size_t k = 0; k < parts; ++k) part(k);
}

/// The number of ranges of at most `most` elements in an array of `count`.
inline std::size_t chunks(std::size_t count, std::size_t most) { return (count + most - 1) / most; }

/// Vertices or triangles that a thread takes at a time: some tens of microseconds of work.
inline constexpr std::size_t elements_per_chunk = 16'384;

/// Calls work(k, begin, end) for each range k of the array.
template <class Work>
void run_chunks(const PartRunner& runner, std::size_t count, std::size_t most, const Work& work) {
  run_parts(runner, chunks(count, most), [&](std::size_t k) { work(k, k * most, std::min(count, (k + 1) * most)); });
}

}  // namespace tandem
