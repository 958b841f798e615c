// Samples, rows and files of bench results.
#include "results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tandem::bench {

double Samples::quantile(double q) const {
  if (values_.empty()) return 0;
  std::vector<double> values = values_;
  const double rank = q * static_cast<double>(values.size() - 1), below = std::floor(rank);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(below);
  std::nth_element(values.begin(), at, values.end());
  if (rank == below) return *at;
  return std::lerp(*at, *std::min_element(at + 1, values.end()), rank - below);
}

double Samples::sum() const { return std::accumulate(values_.begin(), values_.end(), 0.0); }

std::string hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

nlohmann::json to_json(const Findings& findings) {
  nlohmann::json out{{"version", results_version}, {"machine", machine()}, {"rows", nlohmann::json::array()}};
  for (const Row& row : findings.rows) {
    nlohmann::json line{{"bench", row.bench},
                        {"workload", row.workload},
                        {"contestant", row.contestant},
                        {"threads", row.threads},
                        {"n", row.n},
                        {"samples", row.time.size()},
                        {"median_ns", row.time.median()},
                        {"p10_ns", row.time.quantile(0.1)},
                        {"p90_ns", row.time.quantile(0.9)},
                        {"hash", hex(row.hash)}};
    line.update(row.more);
    out["rows"].push_back(std::move(line));
  }
  out.update(findings.more);
  return out;
}

}  // namespace tandem::bench
