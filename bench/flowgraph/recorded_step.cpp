#include "recorded_step.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <stdexcept>

namespace tandem::bench {
namespace {

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

void keep_less(double& kept, double other) { kept = std::min(kept, other); }

void keep_less(std::vector<RecordedStep::Blocks>& kept, const std::vector<RecordedStep::Blocks>& other) {
  for (std::size_t stage = 0; stage < kept.size(); ++stage)
    for (std::size_t block = 0; block < kept[stage].size(); ++block)
      keep_less(kept[stage][block], other.at(stage).at(block));
}

}  // namespace

double RecordedStep::narrow_until(double pair) const {
  const auto mark = std::lower_bound(pair_marks_.begin(), pair_marks_.end(), pair,
                                     [](std::uint64_t m, double p) { return static_cast<double>(m) < p; });
  if (mark == pair_marks_.end()) return narrow_marks_.empty() ? 0 : narrow_marks_.back();
  const auto i = static_cast<std::size_t>(mark - pair_marks_.begin());
  const double first = i == 0 ? 0 : static_cast<double>(pair_marks_[i - 1]);
  const double before = i == 0 ? 0 : narrow_marks_[i - 1];
  return before + batch_ns_[i] * (pair - first) / (static_cast<double>(pair_marks_[i]) - first);
}

double RecordedStep::work_ns() const {
  double all = begin_ns + (narrow_marks_.empty() ? 0 : narrow_marks_.back());
  for (const Blocks& stage : before) all += sum(stage);
  for (const Tile& tile : tiles) all += tile.ns;
  for (const Blocks& stage : after) all += sum(stage);
  return all;
}

std::size_t RecordedStep::tasks() const {
  std::size_t all = tiles.size() + batch_ns_.size();
  for (const Blocks& stage : before) all += stage.size();
  for (const Blocks& stage : after) all += stage.size();
  return all;
}

RecordedStep read_step(const std::vector<Timeline::Slice>& slices) {
  RecordedStep step;
  std::uint64_t pairs = 0;
  for (const Timeline::Slice& slice : slices) {
    const double ns = std::chrono::duration<double, std::nano>(slice.end - slice.begin).count();
    // A single thread takes a stage's blocks in their order, so that block 0 begins a stage.
    const auto add = [&](std::vector<RecordedStep::Blocks>& stages) {
      if (slice.id == 0) stages.emplace_back();
      stages.back().push_back(ns);
    };
    if (slice.name == "begin") {
      step.begin_ns = ns;
    } else if (slice.name == "broad") {
      step.tiles.push_back({ns, slice.pairs});
    } else if (slice.name == "narrow") {
      pairs += slice.pairs;
      step.pair_marks_.push_back(pairs);
      step.batch_ns_.push_back(ns);
    } else {
      add(slice.name == "join" ? step.after : step.before);
    }
  }
  step.narrow_marks_.resize(step.batch_ns_.size());
  std::partial_sum(step.batch_ns_.begin(), step.batch_ns_.end(), step.narrow_marks_.begin());
  return step;
}

RecordedStep fastest(const std::vector<RecordedStep>& runs) {
  if (runs.empty()) throw std::logic_error("no run of the step was recorded");
  RecordedStep best = runs.front();
  for (const RecordedStep& run : runs) {
    if (run.pair_marks_ != best.pair_marks_ || run.tiles.size() != best.tiles.size())
      throw std::logic_error("two runs of one step differ in their work");
    keep_less(best.begin_ns, run.begin_ns);
    keep_less(best.before, run.before);
    keep_less(best.after, run.after);
    for (std::size_t i = 0; i < best.tiles.size(); ++i) keep_less(best.tiles[i].ns, run.tiles[i].ns);
    for (std::size_t i = 0; i < best.batch_ns_.size(); ++i) keep_less(best.batch_ns_[i], run.batch_ns_[i]);
  }
  std::partial_sum(best.batch_ns_.begin(), best.batch_ns_.end(), best.narrow_marks_.begin());
  return best;
}

}  // namespace tandem::bench
