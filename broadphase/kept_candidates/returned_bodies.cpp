// Bodies that left their enlarged boxes and were put back with new ones, sorted for overlap queries.
#include "kept_candidates/returned_bodies.h"

#include <algorithm>
#include <limits>

#include "kernels/row_kernel.h"

namespace tandem {

void ReturnedBodies::clear(std::size_t count) {
  if (turn_ != 0 || place_.size() != count) place_.assign(count, 0);
  known_.clear();
  for (Sorted* some : {&sorted_, &recent_}) {
    some->items.clear();
    some->boxes.resize(0);
    some->reach.clear();
  }
  turn_ = 0;
}

void ReturnedBodies::order(std::vector<Item>& items, std::size_t first) {
  const auto before = [](const Item& p, const Item& q) {
    return p.box.lo[0] != q.box.lo[0] ? p.box.lo[0] < q.box.lo[0] : p.body < q.body;
  };
  const auto middle = items.begin() + static_cast<std::ptrdiff_t>(first);
  std::sort(middle, items.end(), before);
  std::inplace_merge(items.begin(), middle, items.end(), before);
}

void ReturnedBodies::refresh(Sorted& sorted) {
  sorted.boxes.resize(sorted.items.size());
  sorted.reach.resize(sorted.items.size());
  float reach = -std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < sorted.items.size(); ++k) {
    const Aabb& box = sorted.items[k].box;
    sorted.boxes.set(k, box);
    sorted.reach[k] = reach = std::max(reach, box.hi[0]);
  }
}

void ReturnedBodies::sort() {
  if (recent_.items.size() > std::max<std::size_t>(512, sorted_.items.size() / 4)) {
    std::erase_if(sorted_.items, [&](const Item& item) { return turn(item.body) != item.turn; });
    const std::size_t first = sorted_.items.size();
    sorted_.items.insert(sorted_.items.end(), recent_.items.begin(), recent_.items.end());
    order(sorted_.items, first);
    refresh(sorted_);
    recent_.items.clear();
  }
  order(recent_.items, 0);
  refresh(recent_);
}

void ReturnedBodies::overlapping(const Aabb& box, std::vector<std::uint32_t>& row,
                                 std::vector<std::uint32_t>& out) const {
  search(sorted_, box, row, out);
  search(recent_, box, row, out);
}

void ReturnedBodies::search(const Sorted& sorted, const Aabb& box, std::vector<std::uint32_t>& row,
                            std::vector<std::uint32_t>& out) const {
  const float *lo = sorted.boxes.lo(0), *lo_end = lo + sorted.items.size();
  const auto begin = static_cast<std::size_t>(std::lower_bound(sorted.reach.begin(), sorted.reach.end(), box.lo[0]) -
                                              sorted.reach.begin());
  const auto end = static_cast<std::size_t>(std::upper_bound(lo, lo_end, box.hi[0]) - lo);
  if (begin >= end) return;
  if (row.size() < end - begin + BoxArray::padding) row.resize(end - begin + BoxArray::padding);
  const std::size_t count = overlap_row(sorted.boxes, begin, end, box, row.data());
  for (std::size_t k = 0; k < count; ++k)
    if (const Item& item = sorted.items[row[k]]; turn(item.body) == item.turn) out.push_back(item.body);
}

}  // namespace tandem
