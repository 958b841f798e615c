#pragma once
#include <functional>
#include <vector>

namespace tandem::bench {

/// Which of the queries 0..n-1 end the process (an assertion, a bad access) or take more than 10 ms: nonzero. They are
/// tried in child processes, silently. Call it while no other thread holds a lock that `query` needs.
std::vector<char> deadly_queries(std::size_t n, const std::function<void(std::size_t)>& query);

}  // namespace tandem::bench
