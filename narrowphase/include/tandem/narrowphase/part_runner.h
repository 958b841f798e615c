// The interface by which work is distributed over a caller's threads.
#pragma once
#include <cstddef>
#include <functional>

namespace tandem {

/// A function that runs part(0) ... part(parts - 1), on one thread or several, returns when all are done, and throws
/// what a part threw. A part may run others. With oneTBB: tbb::parallel_for(std::size_t(0), parts, part).
using PartRunner = std::function<void(std::size_t parts, const std::function<void(std::size_t)>& part)>;

}  // namespace tandem
