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

void PairOrder::sort(std::span<Batch* const> batches, std::size_t bodies) {
  next_a_.assign(bodies, 0);
  next_b_.assign(bodies, 0);
  std::size_t total = 0;
  for (const Batch* batch : batches) {
    total += batch->count;
    for (const Pair& pair : std::span(batch->pairs).first(batch->count)) ++next_a_[pair.a], ++next_b_[pair.b];
  }
  to_places(next_a_);
  to_places(next_b_);
  by_b_.resize(total);
  sorted_.resize(total);
  for (const Batch* batch : batches)
    for (const Pair& pair : std::span(batch->pairs).first(batch->count)) by_b_[next_b_[pair.b]++] = pair;
  for (const Pair& pair : by_b_) sorted_[next_a_[pair.a]++] = pair;
  auto from = sorted_.begin();
  for (Batch* batch : batches) {
    const auto to = from + static_cast<std::ptrdiff_t>(batch->count);
    std::copy(from, to, batch->pairs.begin());
    from = to;
  }
}

}  // namespace tandem
