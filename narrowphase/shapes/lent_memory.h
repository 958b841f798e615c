#pragma once
#include <memory_resource>

#include "tandem/narrowphase/options.h"

namespace tandem {

/// What a query takes memory from where its own on the stack does not suffice.
inline std::pmr::memory_resource* lent_memory(const NarrowPhaseOptions& options) {
  return options.memory != nullptr ? options.memory : std::pmr::get_default_resource();
}

}  // namespace tandem
