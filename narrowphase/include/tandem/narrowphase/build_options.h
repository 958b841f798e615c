// Options for building a mesh's hierarchy.
#pragma once
#include <functional>

#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Options for building a mesh's hierarchy. The result does not depend on them.
struct BuildOptions {
  /// Distributes the work over threads; empty: the caller does all of it.
  PartRunner parts{};
  /// Ends the work (work_limit.h): WorkStopped is thrown, and no result is kept. Checked before and after each pass
  /// over some thousand triangles. Null: none.
  const WorkLimit* limit = nullptr;
  /// Reports the fraction of the work done, in (0, 1], increasing, at most some hundred times, 1 at the end; called on
  /// the working threads, one at a time. An exception ends the work and is rethrown. Empty: no reports.
  std::function<void(double part)> progress{};
};

}  // namespace tandem
