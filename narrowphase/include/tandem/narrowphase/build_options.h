#pragma once
#include <functional>

#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// How a mesh is made ready for queries. What is built depends on none of it.
struct BuildOptions {
  /// Shares the work between threads; empty: the caller does it alone.
  PartRunner parts{};
  /// Ends the work (work_limit.h): WorkStopped is thrown and nothing is left of it. Looked at before and after each
  /// pass over some thousand triangles. Null: none.
  const WorkLimit* limit = nullptr;
  /// How much of the work is done, in (0, 1], rising, some hundred times at most, 1 at the end; from the threads that
  /// work, one at a time. What it throws ends the work and is thrown. Empty: nobody asks.
  std::function<void(double part)> progress{};
};

}  // namespace tandem
