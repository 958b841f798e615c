// Samples, rows and files of bench results (docs/result-format.md).
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::bench {

/// Times of one contestant, in ns.
class Samples {
 public:
  void add(double ns) { values_.push_back(ns); }
  std::size_t size() const { return values_.size(); }
  double operator[](std::size_t i) const { return values_[i]; }  ///< in the order added
  /// The quantile q in [0, 1], interpolated between two samples; 0 without samples.
  double quantile(double q) const;
  double median() const { return quantile(0.5); }
  double sum() const;
  double mean() const { return values_.empty() ? 0 : sum() / static_cast<double>(values_.size()); }

 private:
  std::vector<double> values_;
};

/// A row of a result: a contestant on a workload.
struct Row {
  std::string bench, workload, contestant;
  int threads = 1;
  std::uint64_t n = 0;  ///< bodies
  Samples time;
  std::uint64_t hash = 0;                          ///< of the answer
  nlohmann::json more = nlohmann::json::object();  ///< further members
};

/// The version of the result format (docs/result-format.md); files without a version are of this one.
inline constexpr std::uint32_t results_version = 1;

/// The findings of a bench.
struct Findings {
  Findings(std::vector<Row> own_rows, nlohmann::json own_more = nlohmann::json::object())
      : rows(std::move(own_rows)), more(std::move(own_more)) {}
  std::vector<Row> rows;
  nlohmann::json more;  ///< further top-level members
};

/// {"version": 1, "machine": ..., "rows": [...], further members}, a row a contestant, workload, size and thread count.
nlohmann::json to_json(const Findings& findings);

/// CPU, cores, memory, compiler, flags and the versions of every library.
nlohmann::json machine();

std::string hex(std::uint64_t value);

}  // namespace tandem::bench
