// Sorts a step's candidate pairs in parallel: a counting sort into ranges of the first body, then each range by itself.
#include "answers/pair_order.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "answers/key_sort.h"

namespace tandem {

void PairOrder::begin(std::span<Batch* const> batches, std::size_t bodies) {
  is_sorted_ = false;
  prepare(batches, bodies, most_groups);
}

void PairOrder::prepare(std::span<Batch* const> batches, std::size_t bodies, std::size_t groups) {
  batches_ = batches;
  std::size_t total = 0;
  for (const Batch* batch : batches) total += batch->count;
  groups_ = std::clamp(total / pairs_a_group, std::size_t{1}, groups);
  // Pairs a range: about eight, which are sorted by insertion. A single group has only one row of counts, so it can
  // afford ranges of about two pairs: fewer comparisons, whose outcome no branch predictor foresees.
  const std::size_t wanted = groups_ == 1 ? std::bit_ceil(std::clamp(total / 2, std::size_t{1}, std::size_t{65536}))
                                          : std::bit_ceil(std::clamp(total / 8, std::size_t{1}, std::size_t{4096}));
  shift_ = 0;
  while (bodies >> shift_ > wanted) ++shift_;
  ranges_ = (bodies >> shift_) + 1;
  row_ = (ranges_ + 15) / 16 * 16;  // a group's row fills whole cache lines
  next_.resize(groups_ * row_);
  first_.resize(ranges_ + 1);
  keys_.resize(total);
}

std::size_t PairOrder::open(std::size_t stage) {
  if (keys_.empty()) return 0;
  if (stage < 2 && groups_ == 1) return 0;  // too few pairs to share: the last stage sorts them all
  if (stage == 0) return groups_;
  if (stage == 1) {
    to_places();
    return groups_;
  }
  return groups_ == 1 ? 1 : (keys_.size() + pairs_a_block - 1) / pairs_a_block;
}

void PairOrder::run(std::size_t stage, std::size_t block) {
  if (stage == 0) return count(block);
  if (stage == 1) return scatter(block);
  if (groups_ > 1) return sort_ranges(block);
  count(0);
  to_places();
  scatter(0);
  for (std::size_t i = 0; i < keys_.size(); i += pairs_a_block) sort_ranges(i / pairs_a_block);
}

bool PairOrder::same_again(std::span<Batch* const> batches) {
  std::size_t total = 0;
  for (const Batch* batch : batches) total += batch->count;
  // Only as many pairs as the last time can be the same; only then they are stored for the next comparison.
  if (std::exchange(last_total_, total) != total) {
    given_.clear();
    return false;
  }
  std::size_t at = 0;
  bool same = true;
  for (const Batch* batch : batches) {
    const auto pairs = std::span(batch->pairs).first(batch->count);
    const std::size_t end = at + pairs.size();
    const auto known = given_.begin() + static_cast<std::ptrdiff_t>(at);
    if (!same || end > given_.size() || !std::equal(pairs.begin(), pairs.end(), known)) {
      same = false;
      if (end > given_.size()) given_.resize(end);
      std::copy(pairs.begin(), pairs.end(), given_.begin() + static_cast<std::ptrdiff_t>(at));
    }
    at = end;
  }
  same = same && at == given_.size();
  given_.resize(at);
  return same;
}

void PairOrder::sort(std::span<Batch* const> batches, std::size_t bodies) {
  if (same_again(batches) && is_sorted_) return;
  is_sorted_ = false;
  prepare(batches, bodies, 1);
  if (open(stages - 1) != 0) run(stages - 1, 0);
  is_sorted_ = true;
}

std::span<Batch* const> PairOrder::group(std::size_t block) const {
  const std::size_t begin = batches_.size() * block / groups_, end = batches_.size() * (block + 1) / groups_;
  return batches_.subspan(begin, end - begin);
}

std::span<std::uint32_t> PairOrder::row(std::size_t group) { return std::span(next_).subspan(group * row_, ranges_); }

void PairOrder::count(std::size_t block) {
  const auto counts = row(block);
  std::fill(counts.begin(), counts.end(), 0u);
  for (const Batch* batch : group(block))
    for (const Pair& pair : std::span(batch->pairs).first(batch->count)) ++counts[pair.a >> shift_];
}

void PairOrder::to_places() {
  std::uint32_t sum = 0;
  for (std::size_t range = 0; range < ranges_; ++range) {
    first_[range] = sum;
    for (std::size_t at = range; at < groups_ * row_; at += row_) {
      const std::uint32_t here = next_[at];
      next_[at] = sum;
      sum += here;
    }
  }
  first_[ranges_] = sum;
  std::size_t longest = 0;
  for (std::size_t range = 0; range < ranges_; ++range)
    longest = std::max<std::size_t>(longest, first_[range + 1] - first_[range]);
  // A single group is sorted by a single thread, range after range.
  const std::size_t room = longest <= most_by_insertion ? 0 : groups_ == 1 ? longest : keys_.size();
  if (spare_.size() < room) spare_.resize(room);
}

void PairOrder::scatter(std::size_t block) {
  const auto next = row(block);
  for (const Batch* batch : group(block))
    for (const Pair& pair : std::span(batch->pairs).first(batch->count))
      keys_[next[pair.a >> shift_]++] = std::uint64_t{pair.a} << 32 | pair.b;
}

PairOrder::Range PairOrder::ranges(std::size_t block) const {
  const auto from = [this](std::size_t pair) {
    const auto end = first_.begin() + static_cast<std::ptrdiff_t>(ranges_);
    return static_cast<std::size_t>(std::lower_bound(first_.begin(), end, pair) - first_.begin());
  };
  return {from(block * pairs_a_block), from(std::min(keys_.size(), (block + 1) * pairs_a_block))};
}

void PairOrder::sort_ranges(std::size_t block) {
  const auto [begin, end] = ranges(block);
  for (std::size_t range = begin; range < end; ++range) {
    const std::size_t first = first_[range], count = first_[range + 1] - first;
    const auto spare = count <= most_by_insertion ? std::span<std::uint64_t>()
                                                  : std::span(spare_).subspan(groups_ == 1 ? 0 : first, count);
    sort_by_key(std::span(keys_).subspan(first, count), spare, [](std::uint64_t key) { return key; });
  }
}

}  // namespace tandem
