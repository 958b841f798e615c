// Finds the pairs of a thin slab first, so that the narrow phase can begin before the broad phase is prepared.
#include "kept_candidates/early_slab.h"

#include <span>
#include <thread>

#include "kernels/box_record.h"
#include "trees/spatial_sample.h"

namespace tandem {
namespace {

// With fewer boxes a step is short enough without early pairs.
constexpr std::size_t least_boxes = 16384;
constexpr std::size_t boxes_a_wanted = 112, most_wanted = 1024;
// Limits of the boxes found in the slab: a layer of a pile cannot be cut thinner and may hold more boxes than wanted.
// For scale: a step takes about 50 ns a box, the time of some 400 tests.
constexpr std::size_t most_a_wanted = 16, boxes_a_found = 40, most_tests_a_box = 20;

}  // namespace

void EarlySlab::choose(const BoxArray& boxes, const std::vector<Aabb>& sample) {
  leave_out();
  if (boxes.size() < least_boxes || sample.size() < 64) return;
  std::vector<Aabb> some;
  for (std::size_t i = 0; i < sample.size(); i += 4) some.push_back(sample[i]);
  std::array<double, 3> length{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Extent extent = bulk(some, axis);
    length[axis] = extent.hi - extent.lo;
  }
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::sort(axes.begin(), axes.end(),
            [&](std::size_t a, std::size_t b) { return length[a] != length[b] ? length[a] > length[b] : a < b; });
  axis_ = axes[0];
  along_ = axes[1];

  // The slab begins at the median of the lower bounds. Its width is that which would hold the wanted number of boxes,
  // if they are as dense as in the next sixteenth of the sample.
  const std::size_t wanted = std::min(boxes.size() / boxes_a_wanted, most_wanted);
  std::vector<float> lower(sample.size());
  for (std::size_t i = 0; i < sample.size(); ++i) lower[i] = sample[i].lo[axis_];
  const std::size_t middle = lower.size() / 2, next = middle + lower.size() / 16;
  const auto place = [&](std::size_t rank) { return lower.begin() + static_cast<std::ptrdiff_t>(rank); };
  std::nth_element(lower.begin(), place(middle), lower.end());
  std::nth_element(place(middle + 1), place(next), lower.end());
  const double share = static_cast<double>(wanted) / static_cast<double>(boxes.size()) *
                       static_cast<double>(lower.size()) / static_cast<double>(next - middle);
  begin_ = lower[middle];
  end_ = static_cast<float>(double{begin_} + share * (double{lower[next]} - double{begin_}));
  const auto touched = std::count_if(sample.begin(), sample.end(), [this](const Aabb& box) {
    return box.lo[axis_] < end_ && begin_ <= box.hi[axis_];
  });
  most_ = std::max(most_a_wanted * wanted, boxes.size() / boxes_a_found);
  const double guess =
      static_cast<double>(touched) * static_cast<double>(boxes.size()) / static_cast<double>(sample.size());
  if (!(begin_ < end_) || guess > 0.75 * static_cast<double>(most_)) return;
  boxes_ = &boxes;
  state_.store(State::chosen, std::memory_order_relaxed);
}

bool EarlySlab::taken() {
  State state = state_.load(std::memory_order_acquire);
  if (state == State::chosen && state_.compare_exchange_strong(state, State::searching, std::memory_order_acquire)) {
    // The destructor sets the state also when memory runs out, so that no thread waits forever.
    struct Done {
      std::atomic<State>& state;
      bool taken = false;
      ~Done() { state.store(taken ? State::taken : State::none, std::memory_order_release); }
    } done{state_};
    return done.taken = search();
  }
  for (; state == State::searching; state = state_.load(std::memory_order_acquire)) std::this_thread::yield();
  return state == State::taken;
}

bool EarlySlab::search() {
  found_.resize(most_ + BoxArray::padding);
  const std::size_t count = boxes_in_slab(*boxes_, axis_, begin_, end_, most_, found_.data());
  if (count > most_) return false;
  records_.resize(count);
  constexpr std::size_t ahead = 16;
  for (std::size_t k = 0; k < count; ++k) {
    if (k + ahead < count) prefetch_box(*boxes_, found_[k + ahead]);
    // A pair is early if its boxes overlap and the later of the two lower bounds lies in the slab: the rule by which a
    // pair belongs to a column of the grid.
    const Aabb box = (*boxes_)[found_[k]];
    records_[k] = {box, found_[k], box.lo[axis_] >= begin_ ? 3u : 2u};
  }
  if (count < 2) return true;
  Column& column = scratch_.column;
  sort_column(records_.data(), count, along_, column);
  std::size_t tests = 0;
  for (std::size_t row = 0; row < count; ++row) tests += column.cell_end[column.last[row]] - row;
  return tests <= most_tests_a_box * boxes_->size();
}

void EarlySlab::emit(PairSink& sink) {
  if (!taken() || records_.size() < 2) return;
  const std::vector<std::uint32_t>& index = scratch_.column.index;
  each_pair(scratch_, [&](std::span<const RowPair> pairs) {
    for (const RowPair pair : pairs) sink.put(index[pair.row], index[pair.other]);
  });
}

std::size_t EarlySlab::memory() const { return bytes_of(found_) + bytes_of(records_) + scratch_.memory(); }

}  // namespace tandem
