// Runners of parts in various orders, to show that results do not depend on it.
#pragma once
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

inline const PartRunner backwards = [](std::size_t parts, const std::function<void(std::size_t)>& part) {
  for (std::size_t k = parts; k-- > 0;) part(k);
};

}  // namespace tandem
