// Sorting that observes a limit.
#pragma once
#include <algorithm>
#include <cstddef>

#include "shapes/work_meter.h"

namespace tandem {

/// Sorts; checks the limit of the meter, if any, meanwhile.
template <class Iterator, class Before>
void sort_metered(WorkMeter& meter, Iterator begin, Iterator end, const Before& before) {
  constexpr std::ptrdiff_t many = 512;
  constexpr unsigned at_once = 16;  // comparisons for a unit of work
  if (end - begin < many || !meter.has_limit()) return std::sort(begin, end, before);
  unsigned compared = 0;
  std::sort(begin, end, [&](const auto& x, const auto& y) {
    if (++compared % at_once == 0) meter.spend();
    return before(x, y);
  });
}

}  // namespace tandem
