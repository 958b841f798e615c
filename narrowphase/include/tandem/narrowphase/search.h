// Common options and results of searches that report what they find item by item.
#pragma once
#include <cstdint>
#include <functional>

#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Why a search ended.
enum class SearchEnd : std::uint8_t {
  done,        ///< all was visited
  by_visitor,  ///< the visitor returned false
  stopped,     ///< the limit was reached first
};

/// Options of a search.
struct SearchOptions {
  /// Ends the search (work_limit.h); null: none.
  const WorkLimit* limit = nullptr;
  /// Reports the fraction of the search done, (0, 1], increasing, at most some hundred times, on the calling thread, 1
  /// at the end of a complete search; empty: no reports.
  std::function<void(double part)> progress{};
};

}  // namespace tandem
