// What searches that tell what they find, one after the other, have in common.
#pragma once
#include <cstdint>
#include <functional>

#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Why a search ended.
enum class SearchEnd : std::uint8_t {
  done,        ///< all was visited
  by_visitor,  ///< it returned false
  stopped,     ///< the limit was reached first
};

/// How a search is made.
struct SearchOptions {
  /// Ends the search (work_limit.h); null: none.
  const WorkLimit* limit = nullptr;
  /// How much of the search is done, (0, 1], rising, some hundred times at most, on the calling thread, 1 at the end of
  /// a search that is done; empty: nobody asks.
  std::function<void(double part)> progress{};
};

}  // namespace tandem
