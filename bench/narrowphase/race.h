// Times contestants in turn.
#pragma once
#include <functional>
#include <vector>

#include "results.h"

namespace tandem::bench {

struct Runner {
  std::function<void()> pass;
  std::function<std::size_t()> queries;  ///< answered by the last pass
};

/// Times passes over one array of queries, the runners in turn in this thread, each round in another order: ns a query
/// of the thread's processor time, which a busy machine lengthens less than wall time. A sample is as many passes as
/// fill 100 us, after one that is not measured; slow runners get fewer rounds. A runner that answers nothing has no
/// samples.
std::vector<Samples> race(const std::vector<Runner>& runners, int rounds);

}  // namespace tandem::bench
