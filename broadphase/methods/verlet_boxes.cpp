// The boxes of a step that reuses a Verlet list: finds boxes that left their enlarged boxes, searches for their
// partners, and puts them back with new enlarged boxes.
#include <algorithm>
#include <cassert>
#include <thread>

#include "kernels/row_kernel.h"
#include "methods/verlet_list.h"
#include "storage/unfiltered_sink.h"

namespace tandem {

/// Takes the results of a search with the new enlarged box of a box that left: passes on pairs that overlap now, and
/// keeps those that may overlap later, except pairs that are on the list already and pairs with another box that left.
class VerletList::Found final : public UnfilteredSink<64> {
 public:
  Found(const VerletList& owner, std::vector<std::uint32_t>& kept, PairSink& sink)
      : owner_(owner), kept_(kept), sink_(sink) {}
  void search_for(std::uint32_t index, const Aabb& box) {
    index_ = index;
    box_ = box;
  }
  void meet(std::uint32_t other) {
    if (other == index_ || owner_.is_outside(other)) return;
    owner_.meet(index_, box_, other, (*owner_.boxes_)[other], kept_, sink_);
  }

 private:
  void take(std::span<const Pair> pairs) override {
    const auto other = [this](Pair pair) { return pair.a == index_ ? pair.b : pair.a; };
    for (const Pair pair : pairs) prefetch_box(*owner_.boxes_, other(pair));
    for (const Pair pair : pairs)
      if (!owner_.returned_.has(other(pair))) meet(other(pair));  // otherwise it has another enlarged box by now
  }
  const VerletList& owner_;
  std::vector<std::uint32_t>& kept_;
  PairSink& sink_;
  std::uint32_t index_ = 0;
  Aabb box_{};
};

namespace {

#ifdef NDEBUG
constexpr bool check_changes = false;
#else
constexpr bool check_changes = true;
#endif

bool inside(const BoxRecord& box, const BoxRecord& larger) {
  int in = 1;
  for (std::size_t k = 0; k < 3; ++k) in &= int{larger.lo()[k] <= box.lo()[k]} & int{box.hi()[k] <= larger.hi()[k]};
  return in != 0;
}

bool inside(const Aabb& box, const Aabb& larger) {
  bool in = true;
  for (std::size_t k = 0; k < 3; ++k) in = in && larger.lo[k] <= box.lo[k] && box.hi[k] <= larger.hi[k];
  return in;
}

}  // namespace

bool VerletList::is_outside(std::size_t i) const {
  if (changes_known() && changed_[i] == 0) return false;
  return !inside((*boxes_)[i], larger_[i]) || !last_filter_.same(filter_, i, i + 1);
}

bool VerletList::on_first_list(std::uint32_t a, std::uint32_t b) const {
  return overlap(first_box(a), first_box(b)) && list_filter_view_.allows(a, b);
}

bool VerletList::on_returned_list(std::uint32_t a, std::uint32_t b) const {
  return (returned_.has(a) || returned_.has(b)) && overlap(larger_[a], larger_[b]) && last_filter_.allows(a, b);
}

void VerletList::meet(std::uint32_t index, const Aabb& box, std::uint32_t other, const Aabb& others_box,
                      std::vector<std::uint32_t>& kept, PairSink& sink) const {
  if (on_first_list(index, other)) return;
  if (overlap(box, others_box) && !on_returned_list(index, other)) sink.put(index, other);
  if (filter_.allows(index, other)) kept.push_back(other);
}

void VerletList::put_back() {
  if (mode_ != Mode::reuse) {
    returned_.clear(size());
    among_.clear();
    for (Part& part : parts_) {
      part.outside.clear();
      part.list.clear();
      part.changed.clear();
    }
    pack();
    return;
  }
  std::vector<ReturnedBodies::Return> returns;
  for (std::size_t p = 0; p < part_count_; ++p) {
    const Part& part = parts_[p];
    for (std::size_t k = 0; k < part.outside.size(); ++k) {
      returns.push_back({part.outside[k], part.larger[k]});
      last_filter_.set(part.outside[k], part.filter, k);
    }
  }
  returned_.put(returns, [this](std::uint32_t body) { return larger_[body]; });
  if (!returns.empty()) {
    for (std::size_t p = 0; p < part_count_; ++p) parts_[p].list.forget(returned_);
    among_.forget(returned_);
  }
  for (const ReturnedBodies::Return& r : returns) {
    larger_.set(r.body, r.box);
    Part& part = parts_[r.body / boxes_a_part];
    const auto known = std::lower_bound(part.changed.begin(), part.changed.end(), r.body);
    if (known != part.changed.end() && *known == r.body)
      part.changed_larger[static_cast<std::size_t>(known - part.changed.begin())].set(r.box);
  }
}

void VerletList::prepare(std::size_t part) {
  const std::size_t first = part * boxes_a_part, last = part_end(part);
  if (mode_ == Mode::renew)
    enlarge_boxes(*boxes_, first, last, records_.data(), static_cast<float>(steps_ahead_), usual_, larger_);
  copy_boxes(*boxes_, first, last, records_.data());
  parts_done_.fetch_add(1, std::memory_order_relaxed);
}

bool VerletList::help_check(bool from_end) {
  constexpr std::uint64_t one_of_first = std::uint64_t{1} << 32, from_last = one_of_first - 1;
  const auto taken = [](std::uint64_t next) { return (next >> 32) + (next & from_last); };
  while (taken(next_part_.load(std::memory_order_relaxed)) < part_count_) {
    const std::uint64_t next = next_part_.fetch_add(from_end ? 1 : one_of_first, std::memory_order_relaxed);
    if (taken(next) >= part_count_) break;
    const std::size_t part = from_end ? part_count_ - 1 - (next & from_last) : next >> 32;
    // The destructor counts the part also when memory runs out, so that no thread waits forever.
    struct Done {
      std::uint8_t& flag;
      ~Done() { std::atomic_ref(flag).store(1, std::memory_order_release); }
    } const done{parts_[part].checked};
    check_part(part);
    parts_done_.fetch_add(1, std::memory_order_release);
  }
  return parts_done_.load(std::memory_order_acquire) == part_count_;
}

void VerletList::check_part(std::size_t index) {
  Part& part = parts_[index];
  const std::size_t first = index * boxes_a_part, last = part_end(index);
  const detail::ScratchPool<CheckScratch>::Lease lease(check_scratch_);
  CheckScratch& scratch = *lease;
  part.outside.clear();
  std::size_t count = find_outside(index, scratch);
  if (!changes_known() && !last_filter_.same(filter_, first, last)) {
    // A changed filter is rare: check the boxes one by one.
    filter_holds_.store(false, std::memory_order_relaxed);
    count = 0;
    for (std::size_t i = first; i < last; ++i)
      if (is_outside(i)) {
        scratch.past[count].set((*boxes_)[i]);
        scratch.outside[count++] = static_cast<std::uint32_t>(i);
      }
  }
  if (count == 0) return;
  part.outside.assign(scratch.outside.begin(), scratch.outside.begin() + static_cast<std::ptrdiff_t>(count));
  part.boxes.resize(count);
  part.larger.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    part.boxes.set(k, (*boxes_)[part.outside[k]]);
    if (!has_past_ || !copies_) scratch.past[k].set(part.boxes[k]);
  }
  // Swept twice as far as the other boxes, since each box that leaves costs a search of its own.
  enlarge_boxes(part.boxes, 0, count, scratch.past.data(), 2 * static_cast<float>(steps_ahead_), usual_, part.larger);
  part.filter.take(filter_, part.outside);
}

std::size_t VerletList::find_outside(std::size_t index, CheckScratch& scratch) {
  const std::size_t first = index * boxes_a_part, last = part_end(index);
  BoxRecord* records = copies_ ? records_.data() : nullptr;
  if (!changes_known())
    return copy_boxes_that_left(*boxes_, first, last, larger_, records, scratch.outside.data(), scratch.past.data());
  const std::size_t changed = indices_set(changed_, first, last, scratch.changed.data());
  if (check_changes)
    for (std::size_t i = first; i < last; ++i) assert(changed_[i] != 0 || is_as_before(i));

  if (4 * changed > 3 * (last - first) && last_filter_.same(filter_, first, last)) {
    // If most boxes have changed, reading all in sequence is faster. An unchanged box is inside its enlarged one.
    const std::size_t left =
        copy_boxes_that_left(*boxes_, first, last, larger_, records, scratch.outside.data(), scratch.past.data());
    std::size_t count = 0;
    for (std::size_t k = 0; k < left; ++k) {
      if (changed_[scratch.outside[k]] == 0) continue;
      scratch.past[count] = scratch.past[k];
      scratch.outside[count++] = scratch.outside[k];
    }
    return count;
  }

  // Boxes whose groups or mask may have changed: the list must be filtered again.
  if (changed != 0) filter_holds_.store(false, std::memory_order_relaxed);
  constexpr std::size_t ahead = 8;
  Part& part = parts_[index];
  const std::span<const std::uint32_t> bodies(scratch.changed.data(), changed);
  if (!std::equal(bodies.begin(), bodies.end(), part.changed.begin(), part.changed.end())) {
    part.changed.assign(bodies.begin(), bodies.end());
    part.changed_larger.resize(changed);
    gather_boxes(larger_, bodies.data(), changed, part.changed_larger.data());
  }
  std::size_t count = 0;
  for (std::size_t k = 0; k < changed; ++k) {
    if (k + ahead < changed) {
      const std::size_t next = bodies[k + ahead];
      prefetch_box(*boxes_, next);
      if (records != nullptr) __builtin_prefetch(records + next, 1);
    }
    const std::uint32_t at = bodies[k];
    BoxRecord now;
    now.set((*boxes_)[at]);
    if (!inside(now, part.changed_larger[k]) || !last_filter_.same(filter_, at, at + 1)) {
      if (records != nullptr) scratch.past[count] = records[at];
      scratch.outside[count++] = at;
    }
    if (records != nullptr) records[at] = now;
  }
  return count;
}

bool VerletList::is_as_before(std::size_t i) const {
  BoxRecord record;
  record.set((*boxes_)[i]);
  return (!has_past_ || std::equal(record.bounds, record.bounds + 8, records_[i].bounds)) &&
         last_filter_.same(filter_, i, i + 1);
}

const VerletList::Part& VerletList::checked_part(std::size_t part) const {
  while (std::atomic_ref(parts_[part].checked).load(std::memory_order_acquire) == 0) std::this_thread::yield();
  return parts_[part];
}

void VerletList::search_outside(Part& part, Scratch& scratch, PairSink& sink) {
  const std::vector<std::uint32_t>& outside = part.outside;
  if (outside.empty()) return;
  Found found(*this, part.list.others, sink);
  if (search_ == nullptr) scratch.row.resize(std::max(scratch.row.size(), size() + BoxArray::padding));
  constexpr std::size_t ahead = 4;
  for (std::size_t k = 0; k < outside.size(); ++k) {
    if (search_ != nullptr && k + 2 * ahead < outside.size())
      search_->prefetch(part.larger[k + 2 * ahead], BoxSearch::Fetch::index);
    if (search_ != nullptr && k + ahead < outside.size())
      search_->prefetch(part.larger[k + ahead], BoxSearch::Fetch::boxes);
    const std::uint32_t index = outside[k];
    const Aabb larger = part.larger[k];
    found.search_for(index, part.boxes[k]);
    if (search_ != nullptr) {
      search_->search(larger, index, found);
      found.flush();
      scratch.found.clear();
      returned_.overlapping(larger, scratch.row, scratch.found);
      for (const std::uint32_t other : scratch.found) found.meet(other);
    } else {
      const std::size_t count = overlap_row(larger_, 0, size(), larger, scratch.row.data());
      for (std::size_t h = 0; h < count; ++h) found.meet(scratch.row[h]);
    }
    part.list.close(index, returned_.turn() + 1);
  }
}

// A sweep along the first axis, so that the time does not grow with the square of the number of boxes outside.
void VerletList::test_outside(Scratch& scratch, PairSink& sink) {
  struct Outside {
    std::uint32_t body;
    Aabb box, larger;
  };
  std::vector<Outside> all;
  for (std::size_t p = 0; p < part_count_; ++p) {
    const Part& part = checked_part(p);
    for (std::size_t k = 0; k < part.outside.size(); ++k)
      all.push_back({part.outside[k], part.boxes[k], part.larger[k]});
  }
  if (all.size() < 2) return;
  std::sort(all.begin(), all.end(), [](const Outside& p, const Outside& q) {
    return p.larger.lo[0] != q.larger.lo[0] ? p.larger.lo[0] < q.larger.lo[0] : p.body < q.body;
  });
  outside_boxes_.resize(all.size());
  for (std::size_t k = 0; k < all.size(); ++k) outside_boxes_.set(k, all[k].larger);
  scratch.row.resize(std::max(scratch.row.size(), all.size() + BoxArray::padding));
  const float* sorted = outside_boxes_.lo(0);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Outside& one = all[k];
    const auto end =
        static_cast<std::size_t>(std::upper_bound(sorted + k, sorted + all.size(), one.larger.hi[0]) - sorted);
    const std::size_t count = overlap_row(outside_boxes_, k + 1, end, one.larger, scratch.row.data());
    for (std::size_t h = 0; h < count; ++h) {
      const Outside& other = all[scratch.row[h]];
      meet(one.body, one.box, other.body, other.box, among_.others, sink);
    }
    among_.close(one.body, returned_.turn() + 1);
  }
}

}  // namespace tandem
