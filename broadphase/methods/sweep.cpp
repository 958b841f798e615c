// The broad phase by sweep and prune along one axis.
#include "methods/sweep.h"

#include <algorithm>
#include <array>
#include <bit>

#include "kernels/row_kernel.h"

namespace tandem {
namespace {

/// Maps floats to integers that sort the same way; -0 and +0 become one value.
std::uint64_t sort_key(float lower_bound, std::size_t index) {
  const auto bits = std::bit_cast<std::uint32_t>(lower_bound + 0.0f);
  const std::uint32_t ordered = bits ^ ((bits >> 31) != 0 ? 0xffffffffu : 0x80000000u);
  return std::uint64_t{ordered} << 32 | index;
}

}  // namespace

// Stages: measure the spread, sort chunks, merge rounds, gather, emit.
std::size_t Sweep::begin(const BoxArray& boxes) {
  boxes_ = &boxes;
  size_ = boxes.size();
  const std::size_t chunks = (size_ + chunk - 1) / chunk;
  merge_rounds_ = chunks > 1 ? static_cast<std::size_t>(std::bit_width(chunks - 1)) : 0;
  spread_.assign(chunks, {});
  keys_.resize(size_);
  merged_.resize(size_);
  order_.resize(size_);
  sorted_.resize(size_);
  return 4 + merge_rounds_;
}

std::size_t Sweep::blocks(std::size_t stage) const {
  if (stage == 3 + merge_rounds_) return (size_ + rows_a_block - 1) / rows_a_block;
  return spread_.size();
}

void Sweep::run(std::size_t stage, std::size_t block) {
  if (stage == 0) return measure(block);
  if (stage == 1) return sort_chunk(block);
  if (stage < 2 + merge_rounds_) return merge(stage - 2, block);
  gather(block);
}

void Sweep::measure(std::size_t block) {
  Spread spread;
  for (std::size_t i = block * chunk, end = std::min(size_, i + chunk); i < end; ++i) {
    const Aabb box = (*boxes_)[i];
    if (box.lo[0] > box.hi[0]) continue;
    spread.count += 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double centre = 0.5 * (double{box.lo[k]} + double{box.hi[k]});
      spread.sum[k] += centre;
      spread.sum_of_squares[k] += centre * centre;
    }
  }
  spread_[block] = spread;
}

int Sweep::axis() const {
  Spread all;
  for (const Spread& part : spread_) {
    all.count += part.count;
    for (std::size_t k = 0; k < 3; ++k) {
      all.sum[k] += part.sum[k];
      all.sum_of_squares[k] += part.sum_of_squares[k];
    }
  }
  if (all.count == 0) return 0;
  std::array<double, 3> variance;
  for (std::size_t k = 0; k < 3; ++k) variance[k] = all.sum_of_squares[k] - all.sum[k] * (all.sum[k] / all.count);
  return static_cast<int>(std::max_element(variance.begin(), variance.end()) - variance.begin());
}

void Sweep::sort_chunk(std::size_t block) {
  const float* lower = boxes_->lo(axis());
  const std::size_t first = block * chunk, last = std::min(size_, first + chunk);
  for (std::size_t i = first; i < last; ++i) keys_[i] = sort_key(lower[i], i);
  std::sort(keys_.begin() + static_cast<std::ptrdiff_t>(first), keys_.begin() + static_cast<std::ptrdiff_t>(last));
}

// One block makes `chunk` elements of the merged runs. It finds where its elements begin in either run by bisection
// along the merge path (Odeh et al., "Merge Path", 2012), so that the blocks of a round are independent.
void Sweep::merge(std::size_t round, std::size_t block) {
  const std::vector<std::uint64_t>& in = round % 2 == 0 ? keys_ : merged_;
  std::vector<std::uint64_t>& out = round % 2 == 0 ? merged_ : keys_;
  const std::size_t run = chunk << round, first = block * chunk, last = std::min(size_, first + chunk);
  const std::size_t base = first / (2 * run) * (2 * run);
  const std::size_t middle = std::min(size_, base + run), end = std::min(size_, base + 2 * run);
  const std::uint64_t *left = in.data() + base, *right = in.data() + middle;
  const std::size_t left_size = middle - base, right_size = end - middle;

  // The number of the first `taken` elements that come from the left run.
  const auto from_left = [&](std::size_t taken) {
    std::size_t low = taken > right_size ? taken - right_size : 0, high = std::min(taken, left_size);
    while (low < high) {
      const std::size_t guess = (low + high) / 2;
      if (left[guess] < right[taken - guess - 1])
        low = guess + 1;
      else
        high = guess;
    }
    return low;
  };
  const std::size_t l0 = from_left(first - base), l1 = from_left(last - base);
  const std::size_t r0 = first - base - l0, r1 = last - base - l1;
  std::merge(left + l0, left + l1, right + r0, right + r1, out.begin() + static_cast<std::ptrdiff_t>(first));
}

void Sweep::gather(std::size_t block) {
  const std::vector<std::uint64_t>& keys = merge_rounds_ % 2 == 0 ? keys_ : merged_;
  for (std::size_t i = block * chunk, end = std::min(size_, i + chunk); i < end; ++i) {
    order_[i] = static_cast<std::uint32_t>(keys[i]);
    sorted_.set(i, (*boxes_)[order_[i]]);
  }
}

void Sweep::emit(std::size_t block, PairSink& sink) {
  constexpr std::size_t piece = 1024;  // boxes of a row: bounds the buffer
  std::array<std::uint32_t, piece + BoxArray::padding> hits;
  const float* lower = sorted_.lo(axis());
  const auto along = static_cast<std::size_t>(axis());
  for (std::size_t i = block * rows_a_block, rows = std::min(size_, i + rows_a_block); i < rows; ++i) {
    const Aabb box = sorted_[i];
    const std::size_t end =
        static_cast<std::size_t>(std::upper_bound(lower + i + 1, lower + size_, box.hi[along]) - lower);
    for (std::size_t j = i + 1; j < end; j += piece) {
      const std::size_t count = overlap_row(sorted_, j, std::min(end, j + piece), box, hits.data());
      for (std::size_t k = 0; k < count; ++k) sink.put(order_[i], order_[hits[k]]);
    }
  }
}

}  // namespace tandem
