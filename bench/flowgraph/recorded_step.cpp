#include "recorded_step.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <stdexcept>

namespace tandem::bench {
namespace {

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Of an even number the lower one.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
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

std::vector<double*> RecordedStep::pieces() {
  std::vector<double*> all{&begin_ns};
  const auto add = [&](std::vector<Blocks>& stages) {
    for (Blocks& stage : stages)
      for (double& block : stage) all.push_back(&block);
  };
  add(before);
  for (Tile& tile : tiles) all.push_back(&tile.ns);
  for (double& batch : batch_ns_) all.push_back(&batch);
  add(after);
  return all;
}

RecordedStep typical(std::vector<RecordedStep> runs) {
  if (runs.empty()) throw std::logic_error("no run of the step was recorded");
  std::vector<std::vector<double*>> pieces;
  for (RecordedStep& run : runs) {
    pieces.push_back(run.pieces());
    if (run.pair_marks_ != runs.front().pair_marks_ || pieces.back().size() != pieces.front().size())
      throw std::logic_error("two runs of one step differ in their work");
  }
  std::vector<double> values(runs.size());
  for (std::size_t piece = 0; piece < pieces.front().size(); ++piece) {
    for (std::size_t run = 0; run < runs.size(); ++run) values[run] = *pieces[run][piece];
    *pieces.front()[piece] = median(values);
  }
  RecordedStep step = std::move(runs.front());
  std::partial_sum(step.batch_ns_.begin(), step.batch_ns_.end(), step.narrow_marks_.begin());
  return step;
}

}  // namespace tandem::bench
