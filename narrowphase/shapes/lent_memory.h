// The memory resource of a query.
#pragma once
#include <memory_resource>

#include "tandem/narrowphase/options.h"

namespace tandem {

/// The memory resource of a query beyond its buffer on the stack.
inline std::pmr::memory_resource* lent_memory(const NarrowPhaseOptions& options) {
  return options.memory != nullptr ? options.memory : std::pmr::get_default_resource();
}

}  // namespace tandem
