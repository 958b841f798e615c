// The number of pairs of a batch, from the cost of a pair in the last step.
#include "step/batch_size.h"

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace tandem {

void BatchSize::learn(const ExecutionReport& report) {
  // A batch costs half a microsecond if another thread narrows it than found its pairs. Long steps have larger batches,
  // as long as the last of them is a small fraction of a thread's share.
  constexpr double least_ms = std::chrono::duration<double, std::milli>(shortest_batch).count();
  const double target_ms = std::clamp(report.narrow_ms / (100.0 * report.threads), least_ms, 8 * least_ms);
  size_.threads = static_cast<std::size_t>(report.threads);
  size_.time = std::chrono::nanoseconds(static_cast<std::int64_t>(1e6 * target_ms));
  const auto pairs_for = [this, target_ms](double ms, std::uint64_t pairs) {
    const double wanted = ms > 0 ? target_ms * static_cast<double>(pairs) / ms : static_cast<double>(most_);
    return static_cast<std::size_t>(std::clamp(wanted, 1.0, static_cast<double>(most_)));
  };
  if (report.candidate_pairs != 0) size_.most = pairs_for(report.narrow_ms, report.candidate_pairs);
  if (report.heavy_ms > 0) size_.heavy = pairs_for(report.heavy_ms, report.heavy_pairs);
}

}  // namespace tandem
