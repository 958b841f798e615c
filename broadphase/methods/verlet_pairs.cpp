// The pairs of a step with a Verlet list: tests the candidates, and stores them in a step that makes the list anew.
#include <algorithm>
#include <utility>

#include "methods/verlet_list.h"
#include "storage/unfiltered_sink.h"

namespace tandem {

/// A sink that takes candidates and passes on those whose boxes overlap. To be flushed at the end.
class VerletList::Tested final : public UnfilteredSink<256> {
 public:
  Tested(const BoxArray& boxes, PairSink& sink) : boxes_(boxes), sink_(sink) {}
  std::size_t found() const { return found_; }  ///< how many overlapped

 private:
  void take(std::span<const Pair> pairs) override {
    for (const Pair pair : pairs) {
      if (!overlap(boxes_[pair.a], boxes_[pair.b])) continue;
      ++found_;
      sink_.put(pair.a, pair.b);
    }
  }
  const BoxArray& boxes_;
  PairSink& sink_;
  std::size_t found_ = 0;
};

namespace {

/// Prefetches the first cache lines of a vector.
template <class T>
void prefetch(const std::vector<T>& values) {
  constexpr std::size_t values_a_line = 64 / sizeof(T), most_lines = 128;
  for (std::size_t k = 0; k < std::min(values.size(), most_lines * values_a_line); k += values_a_line)
    __builtin_prefetch(values.data() + k);
}

}  // namespace

void VerletList::emit(std::size_t block, PairSink& sink) {
  if (without_list_) return method_->emit(block, sink);
  if (mode_ == Mode::scratch) {
    const std::size_t blocks = method_->blocks(method_stages_ - 1);
    return block < blocks ? method_->emit(block, sink) : prepare(block - blocks);
  }
  if (mode_ == Mode::renew && block == 0) return early_.emit(sink);
  const detail::ScratchPool<Scratch>::Lease lease(scratch_);
  Scratch& scratch = *lease;
  if (mode_ == Mode::renew) return renew_block(block - 1, scratch, sink);
  const bool first_tiles = block < std::min(first_lists_, list_count_);
  const bool all_copied = !first_tiles && help_check(2 * block > list_count_ + part_count_) && copies_;
  if (block < list_count_) {
    (void)test(list(block), all_copied, scratch, sink);
    return;
  }
  if (block - list_count_ < part_count_) {
    (void)checked_part(block - list_count_);
    Part& part = parts_[block - list_count_];
    test(part.list, all_copied, sink);
    search_outside(part, scratch, sink);
  } else {
    test(among_, all_copied, sink);
    test_outside(scratch, sink);
  }
  blocks_done_.fetch_add(1, std::memory_order_relaxed);
}

bool VerletList::prepare_renewal() {
  return renewal_.join(
      [this](std::size_t stage) { return method_->blocks(stage - 1); },
      [this](std::size_t stage, std::size_t block) { stage == 0 ? prepare(block) : method_->run(stage - 1, block); });
}

void VerletList::renew_block(std::size_t block, Scratch& scratch, PairSink& sink) {
  if (!prepare_renewal()) return;
  const std::size_t blocks = method_->blocks(method_stages_ - 1);
  const std::size_t first = block * blocks / list_count_, last = (block + 1) * blocks / list_count_;
  if (too_long()) {  // the list will not be used
    LaterPairs later(early_, *boxes_, sink);
    Tested tested(*boxes_, early_.taken() ? later : sink);
    for (std::size_t b = first; b < last; ++b) method_->emit(b, tested);
    tested.flush();
    later.flush();
    hits_.fetch_add(tested.found(), std::memory_order_relaxed);
    blocks_done_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  CandidateTiles& tiles = scratch.tiles;
  scratch.maker.start(list_filter_view_, tiles);
  for (std::size_t b = first; b < last; ++b)
    if (search_ == nullptr || !search_->emit_tiles(b, scratch.maker)) method_->emit(b, scratch.maker);
  scratch.maker.finish();
  if (!too_long()) lists_[block].assign(tiles);
  listed_.fetch_add(tiles.candidates.size(), std::memory_order_relaxed);
  listed_bodies_.fetch_add(tiles.bodies.size(), std::memory_order_relaxed);
  hits_.fetch_add(test(tiles, true, scratch, sink), std::memory_order_relaxed);
  blocks_done_.fetch_add(1, std::memory_order_relaxed);
}

std::size_t VerletList::test(const CandidateTiles& tiles, bool all_copied, Scratch& scratch, PairSink& sink) {
  // Short lists lie anywhere in memory: the hardware does not prefetch beyond their first lines.
  prefetch(tiles.bodies);
  prefetch(tiles.candidates);
  BoxRecord* boxes = scratch.boxes.data();
  const bool early = mode_ == Mode::renew && early_.taken();
  // Until all boxes are checked, it is not known whether the filter is unchanged.
  const bool allowed =
      !filtered_further_ && (all_copied || mode_ == Mode::renew) && filter_holds_.load(std::memory_order_relaxed);
  std::size_t found = 0, first_body = 0, first = 0;
  for (const CandidateTiles::Tile& tile : tiles.tiles) {
    const std::uint32_t* bodies = tiles.bodies.data() + first_body;
    const std::size_t body_count = tile.bodies_end - first_body;
    if (only_changes_ && mode_ == Mode::reuse &&
        test_changed({bodies, body_count}, std::span(tiles.candidates).subspan(first, tile.candidates_end - first),
                     all_copied, scratch, sink)) {
      first = tile.candidates_end;
      first_body = tile.bodies_end;
      continue;
    }
    if (all_copied)
      gather_records(records_.data(), bodies, body_count, boxes);
    else
      gather_boxes(*boxes_, bodies, body_count, boxes);
    bool some_early = false;
    if (early)
      for (std::size_t k = 0; k < body_count; ++k) {
        const float lo = boxes[k].lo()[early_.axis()];
        some_early |= early_.holds(lo, lo);
      }
    while (first < tile.candidates_end) {
      const std::size_t count = std::min(scratch.hits.size(), tile.candidates_end - first);
      const std::size_t hits = overlapping(boxes, tiles.candidates.data() + first, count, scratch.hits.data());
      if (some_early)
        put_later(std::span(scratch.hits).first(hits), bodies, boxes, sink);
      else
        put_all(std::span(scratch.hits).first(hits), bodies, allowed, sink);
      found += hits;
      first += count;
    }
    first_body = tile.bodies_end;
  }
  return found;
}

bool VerletList::test_changed(std::span<const std::uint32_t> bodies, std::span<const LocalPair> candidates,
                              bool all_copied, Scratch& scratch, PairSink& sink) const {
  std::uint8_t* changed = scratch.changed.data();
  std::size_t count = 0;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    changed[k] = changed_[bodies[k]] != 0 ? 1 : 0;
    count += changed[k];
  }
  if (count == 0) return true;
  if (8 * count > bodies.size()) return false;
  for (const LocalPair candidate : candidates) {
    if ((changed[candidate.a] | changed[candidate.b]) == 0) continue;
    const std::uint32_t a = bodies[candidate.a], b = bodies[candidate.b];
    if (overlap_now(a, b, all_copied)) sink.put(a, b);
  }
  return true;
}

void VerletList::put_all(std::span<const LocalPair> pairs, const std::uint32_t* bodies, bool allowed, PairSink& sink) {
  if (!allowed) {
    for (const LocalPair pair : pairs) sink.put(bodies[pair.a], bodies[pair.b]);
    return;
  }
  for (const LocalPair pair : pairs) {
    const std::uint32_t a = bodies[pair.a], b = bodies[pair.b];
    // Without a branch, since which is smaller is unpredictable.
    const std::uint32_t exchanged = (a ^ b) & (0u - std::uint32_t{b < a});
    sink.put_allowed({a ^ exchanged, b ^ exchanged});
  }
}

void VerletList::put_later(std::span<const LocalPair> pairs, const std::uint32_t* bodies, const BoxRecord* boxes,
                           PairSink& sink) const {
  const std::size_t axis = early_.axis();
  for (const LocalPair pair : pairs)
    if (!early_.holds(boxes[pair.a].lo()[axis], boxes[pair.b].lo()[axis])) sink.put(bodies[pair.a], bodies[pair.b]);
}

// A pair of two bodies that were put back is held by the one that was put back last.
void VerletList::test(const ReturnedCandidates& list, bool all_copied, PairSink& sink) const {
  constexpr std::size_t ahead = 16;
  std::array<std::array<std::uint32_t, 2>, 64> room;
  std::size_t count = 0;
  const auto flush = [&] {
    for (std::size_t k = 0; k < count; ++k) {
      const auto [a, b] = room[k];
      if (overlap_now(a, b, all_copied)) sink.put(a, b);
    }
    count = 0;
  };
  std::size_t first = 0;
  for (const ReturnedCandidates::Entry& entry : list.entries) {
    const std::size_t begin = std::exchange(first, entry.end);
    if (returned_.turn(entry.body) != entry.turn) continue;
    if (all_copied) __builtin_prefetch(&records_[entry.body]);
    for (std::size_t k = begin; k < entry.end; ++k) {
      const std::uint32_t other = list.others[k];
      if (k + ahead < list.others.size()) returned_.prefetch(list.others[k + ahead]);
      if (returned_.turn(other) > entry.turn || left_out(entry.body, other)) continue;
      if (all_copied)
        __builtin_prefetch(&records_[other]);
      else
        prefetch_box(*boxes_, other);
      room[count++] = {entry.body, other};
      if (count == room.size()) flush();
    }
  }
  flush();
}

}  // namespace tandem
