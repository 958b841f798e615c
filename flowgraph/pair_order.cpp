#include "pair_order.h"

#include <algorithm>

namespace tandem {
namespace {

void to_places(std::vector<std::uint32_t>& counts) {
  std::uint32_t sum = 0;
  for (std::uint32_t& count : counts) {
    const std::uint32_t here = count;
    count = sum;
    sum += here;
  }
}

}  // namespace

bool PairOrder::same_again(std::span<Batch* const> batches) {
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
  if (!same_again(batches)) {
    next_a_.assign(bodies, 0);
    next_b_.assign(bodies, 0);
    for (const Pair& pair : given_) ++next_a_[pair.a], ++next_b_[pair.b];
    to_places(next_a_);
    to_places(next_b_);
    by_b_.resize(given_.size());
    sorted_.resize(given_.size());
    for (const Pair& pair : given_) by_b_[next_b_[pair.b]++] = pair;
    for (const Pair& pair : by_b_) sorted_[next_a_[pair.a]++] = pair;
  }
  auto from = sorted_.begin();
  for (Batch* batch : batches) {
    const auto to = from + static_cast<std::ptrdiff_t>(batch->count);
    std::copy(from, to, batch->pairs.begin());
    from = to;
  }
}

}  // namespace tandem
