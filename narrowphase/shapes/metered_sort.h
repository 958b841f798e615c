#pragma once
#include <algorithm>
#include <cstddef>

#include "shapes/work_meter.h"

namespace tandem {

/// Sorts; of so many that it takes a millisecond the limit is looked at meanwhile.
template <class Iterator, class Before>
void sort_metered(WorkMeter& meter, Iterator begin, Iterator end, const Before& before) {
  constexpr std::ptrdiff_t many = 8192;
  if (end - begin < many) return std::sort(begin, end, before);
  std::sort(begin, end, [&](const auto& x, const auto& y) {
    meter.spend();
    return before(x, y);
  });
}

}  // namespace tandem
