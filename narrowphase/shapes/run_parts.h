#pragma once
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// The caller does all of it where there is no runner.
inline void run_parts(const PartRunner& runner, std::size_t parts, const std::function<void(std::size_t)>& part) {
  if (runner) return runner(parts, part);
  for (std::size_t k = 0; k < parts; ++k) part(k);
}

}  // namespace tandem
