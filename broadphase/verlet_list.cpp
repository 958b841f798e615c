#include "verlet_list.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "row_kernel.h"

namespace tandem {

/// Takes what a search found for a box that is outside, and hands on what overlaps it and is neither on the list nor
/// outside itself.
class VerletList::Found final : public PairSink {
 public:
  Found(const VerletList& owner, PairSink& sink) : owner_(owner), sink_(sink) {
    filter_ = &everything_;
    buffer_ = room_.data();
    capacity_ = room_.size();
  }
  void look_for(std::uint32_t index, const Aabb& box) {
    index_ = index;
    box_ = box;
  }
  void take(std::uint32_t other) {
    if (!overlap((*owner_.boxes_)[other], box_) || other == index_) return;
    if (!owner_.on_list(index_, other) && !owner_.is_outside(other)) sink_.put(index_, other);
  }
  void flush() {
    const auto other = [this](std::size_t k) { return buffer_[k].a == index_ ? buffer_[k].b : buffer_[k].a; };
    for (std::size_t k = 0; k < count_; ++k) prefetch_box(*owner_.boxes_, other(k));
    for (std::size_t k = 0; k < count_; ++k) take(other(k));
    count_ = 0;
  }

 private:
  void full() override { flush(); }
  const VerletList& owner_;
  PairSink& sink_;
  PairFilter everything_;
  std::uint32_t index_ = 0;
  Aabb box_{};
  std::array<Pair, 64> room_;
};

/// Takes candidates and hands on those whose boxes overlap.
class VerletList::Tested final : public PairSink {
 public:
  Tested(const BoxArray& boxes, PairSink& sink) : boxes_(boxes), sink_(sink) {
    filter_ = &everything_;
    buffer_ = room_.data();
    capacity_ = room_.size();
  }
  /// Tests what is left, and returns how many overlapped in all.
  std::size_t finish() {
    full();
    return found_;
  }

 private:
  void full() override {
    for (std::size_t k = 0; k < count_; ++k) {
      if (!overlap(boxes_[buffer_[k].a], boxes_[buffer_[k].b])) continue;
      sink_.put(buffer_[k].a, buffer_[k].b);
      ++found_;
    }
    count_ = 0;
  }
  const BoxArray& boxes_;
  PairSink& sink_;
  PairFilter everything_;
  std::size_t found_ = 0;
  std::array<Pair, 256> room_;
};

namespace {

// Nanoseconds, of a candidate tested, of a box searched for and of a box when a list is made: their ratios count.
constexpr double candidate_cost = 6, search_cost = 1200, renewal_cost = 120;
constexpr double least_steps_ahead = 4, most_steps_ahead = 64;

/// Candidates that are kept at most.
std::size_t most_candidates(std::size_t boxes) { return 1024 + 24 * boxes; }

/// Boxes outside that are searched for one by one at most; they are also tested against each other.
std::size_t most_outside(std::size_t boxes) {
  return std::max<std::size_t>(32, std::min<std::size_t>(boxes / 16, 4096));
}

bool inside(const Aabb& box, const Aabb& larger) {
  bool in = true;
  for (std::size_t k = 0; k < 3; ++k) in = in && larger.lo[k] <= box.lo[k] && box.hi[k] <= larger.hi[k];
  return in;
}

/// The farthest that a bound of the box moved; NaN or infinite when it was not there.
float motion(const Aabb& box, const BoxRecord& past) {
  float most = 0;
  for (std::size_t k = 0; k < 3; ++k)
    most = std::max({std::abs(box.lo[k] - past.lo()[k]), std::abs(box.hi[k] - past.hi()[k]), most});
  return most;
}

/// Negative for an empty box.
float longest_edge(const Aabb& box) {
  return std::max({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]});
}

/// Some of it at most.
template <class T>
void prefetch(const std::vector<T>& values) {
  constexpr std::size_t values_a_line = 64 / sizeof(T), most_lines = 128;
  for (std::size_t k = 0; k < std::min(values.size(), most_lines * values_a_line); k += values_a_line)
    __builtin_prefetch(values.data() + k);
}

/// The first of each of `strata` equal parts of `size`, at pseudo-random places: always the same.
template <class Visit>
void sample(std::size_t size, std::size_t strata, const Visit& visit) {
  std::uint64_t state = 1;
  for (std::size_t s = 0; s < strata; ++s) {
    const std::size_t first = s * size / strata, last = (s + 1) * size / strata;
    state = state * 6364136223846793005u + 1442695040888963407u;
    visit(first + (state >> 33) % (last - first));
  }
}

}  // namespace

// Stages: decide, prepare, the method's but its last, make room, emit.
std::size_t VerletList::begin(const BoxArray& boxes, ListedMethod& method) {
  const bool complete =
      !bare_ && boxes_ != nullptr && parts_copied_.load(std::memory_order_relaxed) == part_copied_.size();
  outside_last_ = complete ? outside() : 0;
  outside_since_ += outside_last_;
  const bool same = method_ == &method && larger_.size() == boxes.size() && method_stages_ != 0;
  boxes_ = &boxes;
  method_ = &method;
  search_ = method.search_in();
  mode_ = Mode::scratch;
  method_begun_ = false;
  bare_ = bare_steps_left_ != 0;
  if (bare_) {
    --bare_steps_left_;
    has_past_ = list_made_ = false;
    return method_->begin(boxes);
  }
  has_past_ = has_past_ && complete && copies_ && now().size() == boxes.size();
  copies_ = true;
  list_made_ = list_made_ && same && blocks_done_.load(std::memory_order_relaxed) == list_count_;
  too_long_ = list_made_ && too_long();
  list_made_ = list_made_ && !too_long_;
  list_made_ = list_made_ && list_filter_.same_arrays(filter_);
  now_ = 1 - now_;
  fresh_ = now().size() != size();
  for (auto& records : records_) records.resize(size());
  larger_.resize(size());
  outside_of_part_.resize(parts());
  part_copied_.assign(parts(), 0);
  next_part_.store(0, std::memory_order_relaxed);
  parts_copied_.store(0, std::memory_order_relaxed);
  if (!same) {
    method_begun_ = true;
    method_stages_ = method_->begin(boxes);
  }
  return own_stages + method_stages_;
}

std::size_t VerletList::blocks(std::size_t stage) const {
  if (bare_) return method_->blocks(stage);
  if (stage == 0) return 1;
  if (stage == 1) return method_ran() ? parts() : 0;
  const std::size_t room = room_stage();
  if (stage < room) return method_ran() ? method_->blocks(stage - first_method_stage) : 0;
  if (stage == room) return mode_ == Mode::renew ? 1 : 0;
  // Of a list: its tiles, the boxes outside against what is not, those outside against each other.
  return method_ran() ? method_->blocks(method_stages_ - 1) : list_count_ + parts() + 1;
}

void VerletList::run(std::size_t stage, std::size_t block) {
  if (bare_) return method_->run(stage, block);
  if (stage == 0) return decide();
  if (stage == 1) return prepare(block);
  if (stage < room_stage()) return method_->run(stage - first_method_stage, block);
  list_count_ = method_->blocks(method_stages_ - 1);
  if (lists_.size() < list_count_) lists_.resize(list_count_);
}

bool VerletList::too_long() const { return listed_.load(std::memory_order_relaxed) > most_candidates(size()); }

std::size_t VerletList::outside() const {
  std::size_t count = 0;
  if (mode_ == Mode::reuse)
    for (const auto& some : outside_of_part_) count += some.size();
  return count;
}

bool VerletList::is_outside(std::size_t i) const {
  return !inside((*boxes_)[i], larger_[i]) || !list_filter_.same(filter_, i, i + 1);
}

bool VerletList::on_list(std::uint32_t a, std::uint32_t b) const {
  return overlap(larger_[a], larger_[b]) && list_filter_view_.allows(a, b);
}

std::size_t VerletList::guess_outside() const {
  std::size_t count = 0;
  if (size() <= boxes_a_part / 2) {
    for (std::size_t i = 0; i < size(); ++i) count += is_outside(i) ? 1 : 0;
    return count;
  }
  // A cache line's worth of boxes at each place.
  constexpr std::size_t boxes_a_place = 16;
  const std::size_t places = std::clamp<std::size_t>(size() / 2048, 64, 512);
  for (const bool look : {false, true}) {
    sample(size(), places, [&](std::size_t first) {
      first -= first % boxes_a_place;
      if (!look) {
        prefetch_box(*boxes_, first);
        return prefetch_box(larger_, first);
      }
      for (std::size_t i = first; i < std::min(size(), first + boxes_a_place); ++i) count += is_outside(i) ? 1 : 0;
    });
  }
  return count * size() / (places * boxes_a_place);
}

void VerletList::decide() {
  bool keep = list_made_, foreseen = true;
  ++age_;
  if (list_made_ && guess_outside() > most_outside(size())) {
    keep = false;
    foreseen = static_cast<double>(age_) >= steps_ahead_ || outside_since_ > most_outside(size());
  } else if (list_made_) {
    // A list goes when what left it has cost as much as a new one. A step more shows how all move.
    keep = !has_past_ ||
           (search_cost * static_cast<double>(outside_since_) <= renewal_cost * static_cast<double>(size()) &&
            static_cast<double>(age_) < std::max(4 * steps_ahead_, 32.0));
  }
  if (keep) {
    mode_ = Mode::reuse;
    // Where few boxes are on the list, they are read where they are. For a list the last motion must be known.
    copies_ = 4 * listed_bodies_.load(std::memory_order_relaxed) > size() ||
              static_cast<double>(age_ + 1) >= steps_ahead_ || 16 * outside_since_ > size() ||
              4 * outside_last_ > most_outside(size());
    return;
  }

  bool failed = too_long_;
  if (list_made_) {
    failed = !paid();
    adapt();
  }
  if (failed)
    ++failures_;
  else if (list_made_)
    failures_ = 0;
  // Lists do not last, or would be too long: 8 steps without one, then 16, up to 128, each time with a trial after
  // them.
  if (failed && (failures_ > 1 || too_long_)) bare_steps_left_ = std::size_t{4} << std::min<std::size_t>(failures_, 5);
  bool renew = has_past_ && foreseen && !method_begun_ && bare_steps_left_ == 0;
  if (renew) usual_ = usual();
  renew = renew && !jolted();
  has_past_ = true;
  list_made_ = renew;
  mode_ = renew ? Mode::renew : Mode::scratch;
  if (!renew) {
    if (!method_begun_) method_->begin(*boxes_);
    return;
  }
  age_ = outside_since_ = 0;
  blocks_done_.store(0, std::memory_order_relaxed);
  listed_.store(0, std::memory_order_relaxed);
  listed_bodies_.store(0, std::memory_order_relaxed);
  hits_.store(0, std::memory_order_relaxed);
  list_count_ = std::numeric_limits<std::size_t>::max();
  list_filter_.take(filter_);
  list_filter_view_ = list_filter_.view();
  method_->begin(larger_);
  if (search_ != nullptr) search_->prepare_search();
}

void VerletList::FilterCopy::take(const PairFilter& filter) {
  group.assign(filter.group.begin(), filter.group.end());
  mask.assign(filter.mask.begin(), filter.mask.end());
  is_static.assign(filter.is_static.begin(), filter.is_static.end());
}

bool VerletList::FilterCopy::same_arrays(const PairFilter& filter) const {
  return group.size() == filter.group.size() && mask.size() == filter.mask.size() &&
         is_static.size() == filter.is_static.size();
}

bool VerletList::FilterCopy::same(const PairFilter& filter, std::size_t first, std::size_t last) const {
  const auto equal = [&](const auto& mine, const auto& now) {
    const auto place = static_cast<std::ptrdiff_t>(first);
    return mine.empty() ||
           std::equal(mine.begin() + place, mine.begin() + static_cast<std::ptrdiff_t>(last), now.begin() + place);
  };
  return equal(group, filter.group) && equal(mask, filter.mask) && equal(is_static, filter.is_static);
}

std::size_t VerletList::memory() const {
  std::size_t bytes = bytes_of(records_[0]) + bytes_of(records_[1]) + larger_.memory() + bytes_of(lists_) +
                      bytes_of(list_filter_.group) + bytes_of(list_filter_.mask) + bytes_of(list_filter_.is_static) +
                      bytes_of(outside_of_part_) + bytes_of(part_copied_) + outside_boxes_.memory() + scratch_.memory();
  for (const CandidateTiles& list : lists_) bytes += list.memory();
  for (const auto& outside : outside_of_part_) bytes += bytes_of(outside);
  return bytes;
}

UsualBox VerletList::usual() const {
  std::vector<float> motions, edges;
  sample(size(), std::min<std::size_t>(size(), 256), [&](std::size_t i) {
    const Aabb box = (*boxes_)[i];
    const float moved = motion(box, past()[i]), edge = longest_edge(box);
    if (moved <= std::numeric_limits<float>::max()) motions.push_back(moved);
    if (0 <= edge && edge <= std::numeric_limits<float>::max()) edges.push_back(edge);
  });
  const auto most = [](std::vector<float>& values) {
    if (values.empty()) return 0.0f;
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(3 * values.size() / 4);
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  return {2 * most(motions), most(edges)};
}

// Boxes of edges a and b overlap in a share of places that goes with the product of a + b over the axes.
bool VerletList::jolted() const {
  double now = 0, then = 0;
  std::array<double, 3> edge_before{}, swept_before{};
  bool first = true;
  sample(size(), std::min<std::size_t>(size(), 256), [&](std::size_t i) {
    const Aabb box = (*boxes_)[i];
    const float longest = longest_edge(box);
    if (!(box.lo[0] <= box.hi[0] && longest <= std::numeric_limits<float>::max())) return;
    const bool goes_on = motion(box, past()[i]) <= std::max(longest / 2, usual_.motion);
    const double most = std::max<double>(longest, usual_.motion * steps_ahead_);
    std::array<double, 3> edge, swept;
    double product_now = 1, product_then = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double step = goes_on ? std::abs(double{box.lo[k]} - double{past()[i].lo()[k]}) : 0;
      edge[k] = double{box.hi[k]} - double{box.lo[k]};
      swept[k] = edge[k] + std::min(step * steps_ahead_, most);
      product_now *= edge[k] + edge_before[k];
      product_then *= swept[k] + swept_before[k];
    }
    if (!first) {
      now += product_now;
      then += product_then;
    }
    first = false;
    edge_before = edge;
    swept_before = swept;
  });
  const double pairs =
      std::max(static_cast<double>(hits_.load(std::memory_order_relaxed)) / static_cast<double>(size()), 0.5);
  return then * pairs > 16 * now;
}

// Looking further ahead makes lists rarer and longer, and they are left by more. The best is near where both cost the
// same.
void VerletList::adapt() {
  const auto extra =
      static_cast<double>(listed_.load(std::memory_order_relaxed) - hits_.load(std::memory_order_relaxed));
  const double steps = static_cast<double>(std::max<std::size_t>(1, age_));
  const double renewal = renewal_cost * static_cast<double>(size()) / steps;
  const double use = candidate_cost * extra + search_cost * static_cast<double>(outside_since_) / steps;
  const bool further = 2 * static_cast<double>(age_) >= steps_ahead_ && renewal > use;
  steps_ahead_ = std::clamp(further ? 1.5 * steps_ahead_ : steps_ahead_ / 1.5, least_steps_ahead, most_steps_ahead);
}

bool VerletList::paid() const {
  const MethodCosts costs = method_->costs(size());
  const auto candidates = static_cast<double>(listed_.load(std::memory_order_relaxed)), n = static_cast<double>(size());
  const auto pairs = static_cast<double>(hits_.load(std::memory_order_relaxed));
  const double scratch = costs.box * n + costs.pair * pairs;
  const double renewal = costs.listed_box * n + costs.candidate * candidates, reuse = 12 * n + 4 * candidates;
  const auto reused = static_cast<double>(age_ - 1);
  const double searches = search_cost * static_cast<double>(outside_since_);
  return renewal + reused * reuse + searches <= 0.8 * (1 + reused) * scratch;  // else spikes for next to nothing
}

void VerletList::prepare(std::size_t part) {
  const std::size_t first = part * boxes_a_part, last = part_end(part);
  if (mode_ == Mode::renew)
    enlarge_boxes(*boxes_, first, last, past().data(), static_cast<float>(steps_ahead_), usual_, larger_);
  copy_boxes(*boxes_, first, last, now().data());
  if (fresh_) copy_boxes(*boxes_, first, last, records_[1 - now_].data());  // pages are had now, not in a later step
  parts_copied_.fetch_add(1, std::memory_order_relaxed);
}

bool VerletList::help_copy() {
  while (next_part_.load(std::memory_order_relaxed) < parts()) {
    const std::size_t part = next_part_.fetch_add(1, std::memory_order_relaxed);
    if (part >= parts()) break;
    find_outside(part, copies_ ? now().data() : nullptr, outside_of_part_[part]);
    std::atomic_ref(part_copied_[part]).store(1, std::memory_order_release);
    parts_copied_.fetch_add(1, std::memory_order_release);
  }
  return parts_copied_.load(std::memory_order_acquire) == parts();
}

void VerletList::find_outside(std::size_t part, BoxRecord* records, std::vector<std::uint32_t>& outside) const {
  const std::size_t first = part * boxes_a_part, last = part_end(part);
  outside.resize(boxes_a_part);
  outside.resize(copy_boxes_that_left(*boxes_, first, last, larger_, records, outside.data()));
  if (list_filter_.same(filter_, first, last)) return;
  for (std::size_t i = first; i < last; ++i)
    if (!list_filter_.same(filter_, i, i + 1)) outside.push_back(static_cast<std::uint32_t>(i));
  std::sort(outside.begin(), outside.end());
  outside.erase(std::unique(outside.begin(), outside.end()), outside.end());
}

const std::vector<std::uint32_t>& VerletList::outside_of(std::size_t part, std::vector<std::uint32_t>& room) const {
  if (std::atomic_ref(part_copied_[part]).load(std::memory_order_acquire) != 0) return outside_of_part_[part];
  room.clear();
  for (std::size_t i = part * boxes_a_part; i < part_end(part); ++i)
    if (is_outside(i)) room.push_back(static_cast<std::uint32_t>(i));
  return room;
}

void VerletList::emit(std::size_t block, PairSink& sink) {
  if (bare_ || mode_ == Mode::scratch) return method_->emit(block, sink);
  const ScratchPool<Scratch>::Lease lease(scratch_);
  Scratch& scratch = *lease;
  if (mode_ == Mode::renew) return renew_block(block, scratch, sink);
  const bool first_tiles = block <= list_count_ / 64 && block < list_count_;
  const bool all_copied = !first_tiles && help_copy() && copies_;
  if (block < list_count_) {
    test(lists_[block], all_copied, scratch, sink);
  } else if (block - list_count_ < parts()) {
    search_outside(block - list_count_, scratch, sink);
  } else {
    test_outside(scratch, sink);
  }
}

void VerletList::renew_block(std::size_t block, Scratch& scratch, PairSink& sink) {
  if (too_long()) {  // it will not be used
    Tested tested(*boxes_, sink);
    method_->emit(block, tested);
    hits_.fetch_add(tested.finish(), std::memory_order_relaxed);
    blocks_done_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  CandidateTiles& tiles = scratch.tiles;
  scratch.maker.start(list_filter_view_, tiles);
  if (search_ == nullptr || !search_->emit_tiles(block, scratch.maker)) method_->emit(block, scratch.maker);
  scratch.maker.finish();
  if (!too_long()) lists_[block].assign(tiles);
  listed_.fetch_add(tiles.candidates.size(), std::memory_order_relaxed);
  listed_bodies_.fetch_add(tiles.bodies.size(), std::memory_order_relaxed);
  hits_.fetch_add(test(tiles, true, scratch, sink), std::memory_order_relaxed);
  blocks_done_.fetch_add(1, std::memory_order_relaxed);
}

std::size_t VerletList::test(const CandidateTiles& tiles, bool all_copied, Scratch& scratch, PairSink& sink) const {
  // Lists are short and lie anywhere: what follows the first lines is not fetched ahead by itself.
  prefetch(tiles.bodies);
  prefetch(tiles.candidates);
  BoxRecord* boxes = scratch.boxes.data();
  std::size_t found = 0, first_body = 0, first = 0;
  for (const CandidateTiles::Tile& tile : tiles.tiles) {
    const std::uint32_t* bodies = tiles.bodies.data() + first_body;
    const std::size_t body_count = tile.bodies_end - first_body;
    if (all_copied)
      gather_records(now().data(), bodies, body_count, boxes);
    else
      gather_boxes(*boxes_, bodies, body_count, boxes);
    while (first < tile.candidates_end) {
      const std::size_t count = std::min(scratch.hits.size(), tile.candidates_end - first);
      const std::size_t hits = overlapping(boxes, tiles.candidates.data() + first, count, scratch.hits.data());
      for (std::size_t k = 0; k < hits; ++k) sink.put(bodies[scratch.hits[k].a], bodies[scratch.hits[k].b]);
      found += hits;
      first += count;
    }
    first_body = tile.bodies_end;
  }
  return found;
}

void VerletList::search_outside(std::size_t part, Scratch& scratch, PairSink& sink) {
  Found found(*this, sink);
  if (search_ == nullptr) scratch.row.resize(size() + BoxArray::padding);
  const std::vector<std::uint32_t>& outside = outside_of(part, scratch.outside);
  constexpr std::size_t ahead = 4;
  for (std::size_t k = 0; k < outside.size(); ++k) {
    if (search_ != nullptr && k + 2 * ahead < outside.size())
      search_->prefetch((*boxes_)[outside[k + 2 * ahead]], BoxSearch::Fetch::index);
    if (search_ != nullptr && k + ahead < outside.size())
      search_->prefetch((*boxes_)[outside[k + ahead]], BoxSearch::Fetch::boxes);
    const std::uint32_t index = outside[k];
    const Aabb box = (*boxes_)[index];
    found.look_for(index, box);
    if (search_ != nullptr) {
      search_->search(box, index, found);
      found.flush();
    } else {
      const std::size_t count = overlap_row(*boxes_, 0, size(), box, scratch.row.data());
      for (std::size_t h = 0; h < count; ++h) found.take(scratch.row[h]);
    }
  }
}

// A sweep along the first axis, so that time does not grow with the square of what is outside.
void VerletList::test_outside(Scratch& scratch, PairSink& sink) {
  std::vector<std::uint32_t> all;
  for (std::size_t part = 0; part < parts(); ++part) {
    const std::vector<std::uint32_t>& some = outside_of(part, scratch.outside);
    all.insert(all.end(), some.begin(), some.end());
  }
  if (all.size() < 2) return;
  const float *lo = boxes_->lo(0), *hi = boxes_->hi(0);
  std::sort(all.begin(), all.end(),
            [&](std::uint32_t a, std::uint32_t b) { return lo[a] != lo[b] ? lo[a] < lo[b] : a < b; });
  outside_boxes_.resize(all.size());
  for (std::size_t k = 0; k < all.size(); ++k) outside_boxes_.set(k, (*boxes_)[all[k]]);
  scratch.row.resize(all.size() + BoxArray::padding);
  const float* sorted = outside_boxes_.lo(0);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto end = static_cast<std::size_t>(std::upper_bound(sorted + k, sorted + all.size(), hi[all[k]]) - sorted);
    const std::size_t count = overlap_row(outside_boxes_, k + 1, end, outside_boxes_[k], scratch.row.data());
    for (std::size_t h = 0; h < count; ++h)
      if (const std::uint32_t other = all[scratch.row[h]]; !on_list(all[k], other)) sink.put(all[k], other);
  }
}

}  // namespace tandem
