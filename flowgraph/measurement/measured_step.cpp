// The cost of every piece of a step, read from the slices of a timeline: medians over several runs.
#include "tandem/flowgraph/measured_step.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace tandem {
namespace {

/// The median, as the benches compute it: of an even number, the mean of the two in the middle.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return values.size() % 2 != 0 ? *middle : 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double total(const std::vector<double*>& times) {
  double sum = 0;
  for (const double* time : times) sum += *time;
  return sum;
}

/// Sorts the slices of a step into its stages.
class Reader {
 public:
  explicit Reader(MeasuredStep& step) : step_(step) {}

  void read(const Timeline::Slice& slice) {
    const double ns = std::chrono::duration<double, std::nano>(slice.end - slice.begin).count();
    if (slice.name == "begin") {
      step_.begin_ns = ns;
    } else if (slice.name == "open") {
      open_ns_ += ns;  // includes the opening of stages without blocks
      opened_ = true;
    } else if (slice.name == "broad") {
      if (opened_) step_.open_tiles_ns = opening();
      step_.tiles.push_back({ns, slice.pairs});
    } else if (slice.name == "narrow") {
      narrow(slice, ns);
    } else if (slice.name == "join" && in_narrow_ && !opened_) {
      copied_ns_ += ns;
    } else {
      auto& stages = slice.name != "join" ? step_.before : is_joined() ? step_.after : step_.order;
      if (opened_ || stages.empty()) stages.push_back({opening(), {}});
      stages.back().blocks.push_back(ns);
    }
  }
  void end() {
    if (!step_.pieces.empty()) step_.pieces[last_].ns += copied_ns_;
  }

 private:
  bool is_joined() const { return in_narrow_ || step_.form == StepForm::overlapped; }

  double opening() {
    opened_ = false;
    return std::exchange(open_ns_, 0);
  }

  // Batches of StepForm::ordered come with the heavy ones first; the time of each includes taking it and putting its
  // answers away.
  void narrow(const Timeline::Slice& slice, double ns) {
    const bool ordered = step_.form == StepForm::ordered;
    if (ordered && !in_narrow_) {
      if (step_.order.empty()) throw std::invalid_argument("slices of a step whose pairs were not put in order first");
      copied_ns_ = step_.order.back().blocks.back();  // its slices so far were read as a stage
      step_.open_narrow_ns = step_.order.back().open_ns;
      step_.order.pop_back();
      in_narrow_ = true;
    }
    last_ = ordered ? slice.id : step_.pieces.size();
    if (last_ >= step_.pieces.size()) step_.pieces.resize(last_ + 1);
    step_.pieces[last_] = {ns + std::exchange(copied_ns_, 0), slice.pairs, slice.heavy};
  }

  MeasuredStep& step_;
  double open_ns_ = 0, copied_ns_ = 0;
  bool opened_ = false, in_narrow_ = false;
  std::size_t last_ = 0;
};

}  // namespace

void MeasuredStep::index() {
  first_pairs_.assign(1, 0);
  light_until_.assign(1, 0);
  costliest_ns_ = 0;
  for (const Piece& piece : pieces) {
    first_pairs_.push_back(first_pairs_.back() + piece.pairs);
    light_until_.push_back(light_until_.back() + (piece.heavy ? 0 : piece.ns));
    if (piece.heavy) costliest_ns_ = std::max(costliest_ns_, piece.ns);
  }
}

std::size_t MeasuredStep::piece_of(double pair) const {
  const auto next = std::upper_bound(first_pairs_.begin(), first_pairs_.end(), pair,
                                     [](double p, std::uint64_t first) { return p < static_cast<double>(first); });
  return static_cast<std::size_t>(next - first_pairs_.begin()) - 1;
}

double MeasuredStep::narrow_ns(double first, double end, bool heavy) const {
  const auto until = [&](double pair) {
    const std::size_t i = piece_of(pair);
    if (i >= pieces.size() || pieces[i].heavy || pieces[i].pairs == 0) return light_until_[i];
    return light_until_[i] + pieces[i].ns * (pair - first_pair(i)) / static_cast<double>(pieces[i].pairs);
  };
  if (!heavy) return until(end) - until(first);
  double sum = 0;
  for (std::size_t i = piece_of(first); i < pieces.size() && first_pair(i) < end; ++i) {
    const double from = std::max(first, first_pair(i)), to = std::min(end, first_pair(i + 1));
    if (pieces[i].heavy && to > from) sum += pieces[i].ns * (to - from) / static_cast<double>(pieces[i].pairs);
  }
  return sum;
}

double MeasuredStep::work_ns() const {
  MeasuredStep copy = *this;
  return total(copy.times());
}

std::size_t MeasuredStep::tasks() const {
  std::size_t all = tiles.size() + pieces.size();
  for (const auto* stages : {&before, &order, &after})
    for (const Stage& stage : *stages) all += stage.blocks.size();
  return all;
}

MeasuredStep read_step(const std::vector<Timeline::Slice>& slices, StepForm form) {
  MeasuredStep step;
  step.form = form;
  Reader reader(step);
  for (const Timeline::Slice& slice : slices) reader.read(slice);
  reader.end();
  step.index();
  return step;
}

std::vector<double*> MeasuredStep::times() {
  std::vector<double*> all{&begin_ns, &open_tiles_ns, &open_narrow_ns};
  for (auto* stages : {&before, &order, &after})
    for (Stage& stage : *stages) {
      all.push_back(&stage.open_ns);
      for (double& block : stage.blocks) all.push_back(&block);
    }
  for (Tile& tile : tiles) all.push_back(&tile.ns);
  for (Piece& piece : pieces) all.push_back(&piece.ns);
  return all;
}

MeasuredStep typical_step(std::vector<MeasuredStep> runs) {
  if (runs.empty()) throw std::invalid_argument("no run of the step was recorded");
  // Runs with other numbers of blocks than the first, which depend on the room in buffers, are left out.
  std::vector<std::vector<double*>> times;
  for (MeasuredStep& run : runs) {
    if (run.first_pairs_ != runs.front().first_pairs_ || run.tiles.size() != runs.front().tiles.size())
      throw std::invalid_argument("two runs of one step differ in their work");
    times.push_back(run.times());
    if (times.back().size() != times.front().size()) times.pop_back();
  }
  std::vector<double> values(times.size());
  for (std::size_t run = 0; run < times.size(); ++run) values[run] = total(times[run]);
  const double whole = median(values);
  for (std::size_t i = 0; i < times.front().size(); ++i) {
    for (std::size_t run = 0; run < times.size(); ++run) values[run] = *times[run][i];
    *times.front()[i] = median(values);
  }
  // Times are skewed, so the medians of the pieces add up to less than the median of the whole step: scale them to
  // that.
  const double sum = total(times.front()), scale = sum > 0 ? whole / sum : 1;
  for (double* time : times.front()) *time *= scale;
  MeasuredStep step = std::move(runs.front());
  step.index();
  return step;
}

}  // namespace tandem
