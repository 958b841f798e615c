// The accuracy of a contestant's answers.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pair_solver.h"
#include "workload.h"

namespace tandem::bench {

/// The accuracy of a contestant's answers. Errors are relative to the size of the pair's larger shape, and count beyond
/// the certified error of the reference. The error of a wrong verdict is the pair's distance from touching.
struct Accuracy {
  double error_p50 = 0, error_p99 = 0, error_max = 0;
  std::size_t wrong = 0;       ///< wrong verdicts, of pairs that are farther than 1e-15 of their size from touching
  std::size_t failed = 0;      ///< exceptions, error codes, NaN; not among the errors
  std::size_t normals = 0;     ///< normals more than 1e-3 off (or reversed) where the reference has only one
  std::size_t unmeasured = 0;  ///< Request::distance: pairs reported as separated without a distance
  std::uint64_t hash = 0xcbf29ce484222325u;  ///< of verdicts and distances, bit by bit (FNV-1a)
  std::size_t worst = 0;  ///< number of the pair that failed, or else has the wrong verdict or the largest error

  void add_to_hash(std::uint64_t word) { hash = (hash ^ word) * 0x100000001b3u; }
  /// Sets the quantiles from the errors of the pairs that were judged.
  void set_errors(std::vector<double> errors);

  /// True if all queries are answered: no failure, no wrong verdict, no error above 1e-9 of the size.
  bool right() const { return failed == 0 && unmeasured == 0 && wrong == 0 && error_max <= 1e-9; }
};

Accuracy judge(const Workload& work, Request request, std::span<const Found> found);

/// A record for `tandem query`, with the reference's answer.
nlohmann::json query_record(const Workload& work, Request request, std::size_t pair);

/// A record for the pair that such a record's id names, without the reference's answer, in an array of `n` queries;
/// empty for an id that names no convex pair.
std::optional<nlohmann::json> named_query_record(std::string_view id, std::string_view request, std::size_t n);

/// The members of a result row.
nlohmann::json to_json(const Accuracy& accuracy);

}  // namespace tandem::bench
