#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pair_solver.h"
#include "workload.h"

namespace tandem::bench {

/// How right a contestant's answers are. Errors are relative to the size of the pair's larger shape, beyond what the
/// truth itself is certain to. A wrong verdict's error is how far from touching the pair is.
struct Accuracy {
  double error_p50 = 0, error_p99 = 0, error_max = 0;
  std::size_t wrong = 0;       ///< verdicts, of pairs that are farther than 1e-15 of their size from touching
  std::size_t failed = 0;      ///< exceptions, error codes, NaN; not among the errors
  std::size_t normals = 0;     ///< normals more than 1e-3 off (or in reverse) where the truth has only one
  std::size_t unmeasured = 0;  ///< Request::distance: pairs told to miss without a distance
  std::uint64_t hash = 0xcbf29ce484222325u;  ///< of verdicts and distances, bit by bit (FNV-1a)
  std::size_t worst = 0;  ///< number of the pair that failed, else has the wrong verdict or the error that is largest

  void add_to_hash(std::uint64_t word) { hash = (hash ^ word) * 0x100000001b3u; }
  /// Of those that were judged.
  void set_errors(std::vector<double> errors);

  /// Answered all that was asked: no failure, no wrong verdict, no error above 1e-9 of the size.
  bool right() const { return failed == 0 && unmeasured == 0 && wrong == 0 && error_max <= 1e-9; }
};

Accuracy judge(const Workload& work, Request request, std::span<const Found> found);

/// A record for `tandem query` with the truth beside it.
nlohmann::json query_record(const Workload& work, Request request, std::size_t pair);

/// A record without the truth for the pair of such a record's id, in a row of `n` queries; empty for an id that is of
/// no convex pair.
std::optional<nlohmann::json> named_query_record(std::string_view id, std::string_view request, std::size_t n);

/// The members that a row has of it.
nlohmann::json to_json(const Accuracy& accuracy);

}  // namespace tandem::bench
