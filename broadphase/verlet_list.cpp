#include "verlet_list.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "row_kernel.h"

namespace tandem {

/// Takes candidates and puts them on a list.
class VerletList::Collected final : public PairSink {
 public:
  Collected(const PairFilter& filter, std::vector<Pair>& list) : list_(list) {
    filter_ = &filter;
    buffer_ = room_.data();
    capacity_ = room_.size();
  }
  void flush() {
    list_.insert(list_.end(), buffer_, buffer_ + count_);
    count_ = 0;
  }

 private:
  void full() override { flush(); }
  std::vector<Pair>& list_;
  std::array<Pair, 256> room_;
};

/// Takes candidates and hands on those whose boxes overlap.
class VerletList::Overlapping final : public PairSink {
 public:
  Overlapping(const PageVector<BoxRecord>& records, PairSink& sink) : records_(records.data()), sink_(sink) {
    filter_ = &everything_;
    buffer_ = room_.data();
    capacity_ = room_.size();
  }
  void flush() {
    std::array<Pair, room> hits;
    const std::size_t count = overlapping(records_, buffer_, count_, hits.data());
    for (std::size_t k = 0; k < count; ++k) sink_.put(hits[k].a, hits[k].b);
    count_ = 0;
  }

 private:
  static constexpr std::size_t room = 256;
  void full() override { flush(); }

  const BoxRecord* records_;
  PairSink& sink_;
  PairFilter everything_;  // the sink has its own
  std::array<Pair, room> room_;
};

/// Takes what a search found for one box, and hands on what truly overlaps it.
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
  void flush() {
    for (std::size_t k = 0; k < count_; ++k) {
      const std::uint32_t other = buffer_[k].a == index_ ? buffer_[k].b : buffer_[k].a;
      if (owner_.meets(other, box_)) sink_.put(index_, other);
    }
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

namespace {

// Estimated nanoseconds, of a candidate tested and of a box when a list is made: their ratio is what counts.
constexpr double candidate_cost = 2, renewal_cost = 100;
constexpr double least_steps_ahead = 4, most_steps_ahead = 64;

/// Candidates that are kept at most.
std::size_t most_candidates(std::size_t boxes) { return 1024 + 24 * boxes; }

/// Boxes outside that are searched for one by one at most; they are also tested against each other.
std::size_t most_outside(std::size_t boxes) {
  return std::max<std::size_t>(32, std::min<std::size_t>(boxes / 16, 4096));
}

/// The farthest that a bound of the box moved; NaN or infinite when it was not there.
float motion(const Aabb& box, const BoxRecord& past) {
  float most = 0;
  for (std::size_t k = 0; k < 3; ++k)
    most = std::max({std::abs(box.lo[k] - past.lo[k]), std::abs(box.hi[k] - past.hi[k]), most});
  return most;
}

}  // namespace

// Stages: look, decide, enlarge, the method's but its last, make room, collect, arrange, cut, emit.
std::size_t VerletList::begin(const BoxArray& boxes, BroadPhase& method, BoxSearch* search) {
  for (const std::uint32_t index : outside_) is_outside_[index] = 0;
  outside_.clear();

  const bool same = method_ == &method && place_.size() == boxes.size() && method_stages_ != 0;
  boxes_ = &boxes;
  method_ = &method;
  search_ = search;
  mode_ = Mode::scratch;
  method_begun_ = false;
  bare_ = bare_steps_left_ != 0;
  if (bare_) {
    --bare_steps_left_;
    has_past_ = list_made_ = false;
    return method_->begin(boxes);
  }
  has_past_ = has_past_ && past_.size() == boxes.size();
  list_made_ = list_made_ && same && blocks_done_.load(std::memory_order_relaxed) == list_count_;
  too_long_ = list_made_ && too_long();
  list_made_ = list_made_ && !too_long_;
  list_made_ = list_made_ && list_filter_.same_arrays(filter_);
  list_made_ = list_made_ && arranged_.load(std::memory_order_relaxed) == list_count_;
  past_.resize(size());
  larger_.resize(size());
  place_.resize(size());
  body_.resize(size());
  records_.resize(size());
  is_outside_.resize(size());
  outside_of_block_.resize(look_blocks());
  if (!same) {
    method_begun_ = true;
    method_stages_ = method_->begin(boxes);
  }
  return own_stages + method_stages_;
}

std::size_t VerletList::blocks(std::size_t stage) const {
  if (bare_) return method_->blocks(stage);
  if (stage == 0) return list_made_ ? look_blocks() : 0;
  if (stage == 1) return 1;
  if (stage == 2) return copy_now_ ? look_blocks() : 0;
  const std::size_t room = room_stage();
  if (stage < room) return method_ran() ? method_->blocks(stage - first_method_stage) : 0;
  const bool renew = mode_ == Mode::renew;
  if (stage == room) return renew ? 1 : 0;
  if (stage == room + 1) return renew ? list_count_ : 0;
  if (stage == room + 2) return renew && !too_long() ? look_blocks() + list_count_ : 0;
  if (stage == room + 3) return renew && !too_long() ? 1 : 0;
  if (mode_ == Mode::scratch || (renew && too_long())) return method_->blocks(method_stages_ - 1);
  return pieces_.size() + (outside_.size() + outside_a_block - 1) / outside_a_block;
}

void VerletList::run(std::size_t stage, std::size_t block) {
  if (bare_) return method_->run(stage, block);
  if (stage == 0) return look(block);
  if (stage == 1) return decide();
  if (stage == 2) return enlarge(block);
  const std::size_t room = room_stage();
  if (stage < room) return method_->run(stage - first_method_stage, block);
  if (stage == room + 1) return collect(block);
  if (stage == room + 2) return block < look_blocks() ? place(block) : arrange(block - look_blocks());
  if (stage == room + 3) return cut();
  list_count_ = method_->blocks(method_stages_ - 1);
  if (lists_.size() < list_count_) lists_.resize(list_count_);
}

bool VerletList::too_long() const { return listed_.load(std::memory_order_relaxed) > most_candidates(size()); }

void VerletList::place(std::size_t block) {
  std::vector<std::uint32_t>& outside = outside_of_block_[block];
  outside.resize(boxes_a_block + BoxArray::padding);
  const std::size_t first = block * boxes_a_block, last = std::min(size(), first + boxes_a_block);
  outside.resize(place_boxes(*boxes_, first, last, larger_, place_.data(), records_.data(), outside.data()));
}

void VerletList::look(std::size_t block) {
  place(block);
  std::vector<std::uint32_t>& outside = outside_of_block_[block];
  const std::size_t first = block * boxes_a_block, last = std::min(size(), first + boxes_a_block);
  if (list_filter_.same(filter_, first, last)) return;
  for (std::size_t i = first; i < last; ++i)
    if (!list_filter_.same(filter_, i, i + 1)) outside.push_back(static_cast<std::uint32_t>(i));
  std::sort(outside.begin(), outside.end());
  outside.erase(std::unique(outside.begin(), outside.end()), outside.end());
}

void VerletList::collect(std::size_t block) {
  std::vector<Pair>& list = lists_[block];
  list.clear();
  if (!too_long()) {
    const PairFilter filter = list_filter_.view();
    Collected sink(filter, list);
    method_->emit(block, sink);
    sink.flush();
    claim_places(list);
    listed_.fetch_add(list.size(), std::memory_order_relaxed);
  }
  blocks_done_.fetch_add(1, std::memory_order_relaxed);
}

void VerletList::arrange(std::size_t list) {
  for (Pair& pair : lists_[list]) pair = {place_[pair.a], place_[pair.b]};
  arranged_.fetch_add(1, std::memory_order_relaxed);
}

void VerletList::cut() {
  pieces_.clear();
  for (std::size_t list = 0; list < list_count_; ++list)
    for (std::size_t first = 0; first < lists_[list].size(); first += pairs_a_block)
      pieces_.push_back({list, first, std::min(lists_[list].size(), first + pairs_a_block)});
}

// Boxes of a list that have no place yet get the next ones. Who is first differs from run to run on threads; it decides
// where a box lies, not what is found.
void VerletList::claim_places(const std::vector<Pair>& list) {
  const ScratchPool<Scratch>::Lease scratch(scratch_);
  std::vector<std::uint32_t>& claimed = (*scratch).row;
  claimed.clear();
  constexpr std::uint32_t claim = no_place - 1;
  const auto take = [&](std::uint32_t index) {
    const std::atomic_ref place(place_[index]);
    std::uint32_t expected = no_place;
    if (place.load(std::memory_order_relaxed) == no_place &&
        place.compare_exchange_strong(expected, claim, std::memory_order_relaxed))
      claimed.push_back(index);
  };
  for (const Pair& pair : list) {
    take(pair.a);
    take(pair.b);
  }
  std::uint32_t next = places_.fetch_add(static_cast<std::uint32_t>(claimed.size()), std::memory_order_relaxed);
  for (const std::uint32_t index : claimed) {
    std::atomic_ref(place_[index]).store(next, std::memory_order_relaxed);
    body_[next++] = index;
  }
}

bool VerletList::meets(std::uint32_t other, const Aabb& box) const {
  return is_outside_[other] == 0 && overlap((*boxes_)[other], box);
}

void VerletList::decide() {
  const std::size_t outside_before = outside_since_;
  std::size_t outside = 0;
  if (list_made_)
    for (const auto& some : outside_of_block_) outside += some.size();
  outside_since_ += outside;
  ++age_;
  ++past_age_;

  bool keep = list_made_, foreseen = true;
  copy_now_ = true;
  if (list_made_ && outside > most_outside(size())) {
    keep = false;
    foreseen = static_cast<double>(age_) >= steps_ahead_ || outside_before > most_outside(size());
    failures_ = age_ <= 2 ? failures_ + 1 : 0;
  } else if (list_made_) {
    // A search is estimated to cost as much as making the list for two boxes.
    const auto lasts = [&](std::size_t outside_then, std::size_t age) {
      return 2 * outside_then <= size() && static_cast<double>(age) < std::max(4 * steps_ahead_, 32.0);
    };
    keep = lasts(outside_since_, age_);
    // A list is best made from the last motion. When the next may be due, it is kept.
    copy_now_ = !keep || !lasts(outside_since_ + 2 * outside, age_ + 1) || 2 * outside > most_outside(size()) ||
                static_cast<double>(age_ + 1) >= steps_ahead_;
  }
  if (copy_now_) past_steps_ = std::exchange(past_age_, 0);
  if (keep) {
    mode_ = Mode::reuse;
    for (const auto& some : outside_of_block_) outside_.insert(outside_.end(), some.begin(), some.end());
    outside_boxes_.resize(outside);
    for (std::size_t k = 0; k < outside; ++k) {
      outside_boxes_.set(k, (*boxes_)[outside_[k]]);
      constexpr float inf = std::numeric_limits<float>::infinity();
      is_outside_[outside_[k]] = 1;
      if (const std::uint32_t place = place_[outside_[k]]; place != no_place)
        records_[place].set({{inf, inf, inf}, {-inf, -inf, -inf}});
    }
    return;
  }

  if (list_made_) adapt();
  if (too_long_) ++failures_;
  // Lists do not last, or would be too long: 8 steps without one, then 16, up to 128.
  if (failures_ > 1 || too_long_) bare_steps_left_ = std::size_t{4} << std::min<std::size_t>(failures_, 5);
  const bool renew = has_past_ && foreseen && !method_begun_ && bare_steps_left_ == 0;
  has_past_ = true;
  list_made_ = renew;
  mode_ = renew ? Mode::renew : Mode::scratch;
  if (!renew) {
    if (!method_begun_) method_->begin(*boxes_);
    return;
  }
  age_ = outside_since_ = 0;
  arranged_.store(0, std::memory_order_relaxed);
  places_.store(0, std::memory_order_relaxed);
  blocks_done_.store(0, std::memory_order_relaxed);
  listed_.store(0, std::memory_order_relaxed);
  hits_.store(0, std::memory_order_relaxed);
  list_count_ = std::numeric_limits<std::size_t>::max();
  list_filter_.take(filter_);
  usual_motion_ = usual_motion();
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
  std::size_t bytes = bytes_of(past_) + bytes_of(records_) + bytes_of(place_) + bytes_of(body_) +
                      bytes_of(is_outside_) + larger_.memory() + bytes_of(lists_) + bytes_of(pieces_) +
                      bytes_of(list_filter_.group) + bytes_of(list_filter_.mask) + bytes_of(list_filter_.is_static) +
                      bytes_of(outside_of_block_) + bytes_of(outside_) + outside_boxes_.memory() + scratch_.memory();
  for (const auto& list : lists_) bytes += bytes_of(list);
  for (const auto& outside : outside_of_block_) bytes += bytes_of(outside);
  return bytes;
}

// A motion that most of a few hundred boxes stay below, twice over.
float VerletList::usual_motion() const {
  std::vector<float> motions;
  const std::size_t strata = std::min<std::size_t>(size(), 256);
  std::uint64_t state = 1;
  for (std::size_t s = 0; s < strata; ++s) {
    // One of each of equal parts, at a pseudo-random place.
    const std::size_t first = s * size() / strata, last = (s + 1) * size() / strata;
    state = state * 6364136223846793005u + 1442695040888963407u;
    const std::size_t i = first + (state >> 33) % (last - first);
    const float moved = motion((*boxes_)[i], past_[i]) / static_cast<float>(past_steps_);
    if (moved <= std::numeric_limits<float>::max()) motions.push_back(moved);
  }
  if (motions.empty()) return 0;
  const auto most = motions.begin() + static_cast<std::ptrdiff_t>(3 * motions.size() / 4);
  std::nth_element(motions.begin(), most, motions.end());
  return 2 * *most;
}

// Looking further ahead makes lists rarer and longer. The best is near where both cost the same.
void VerletList::adapt() {
  const auto extra =
      static_cast<double>(listed_.load(std::memory_order_relaxed) - hits_.load(std::memory_order_relaxed));
  const double renewal =
      renewal_cost * static_cast<double>(size()) / static_cast<double>(std::max<std::size_t>(1, age_));
  const bool further = 2 * static_cast<double>(age_) >= steps_ahead_ && renewal > candidate_cost * extra;
  steps_ahead_ = std::clamp(further ? 1.5 * steps_ahead_ : steps_ahead_ / 1.5, least_steps_ahead, most_steps_ahead);
}

void VerletList::enlarge(std::size_t block) {
  const std::size_t first = block * boxes_a_block, last = std::min(size(), first + boxes_a_block);
  if (mode_ == Mode::renew) {
    enlarge_boxes(*boxes_, first, last, past_.data(), static_cast<float>(past_steps_), static_cast<float>(steps_ahead_),
                  usual_motion_, larger_);
    std::fill(place_.begin() + static_cast<std::ptrdiff_t>(first), place_.begin() + static_cast<std::ptrdiff_t>(last),
              no_place);
  }
  copy_boxes(*boxes_, first, last, past_.data());
}

void VerletList::emit(std::size_t block, PairSink& sink) {
  if (mode_ == Mode::scratch) return method_->emit(block, sink);
  if (mode_ == Mode::renew && too_long()) {
    Overlapping exact(past_, sink);
    method_->emit(block, exact);
    return exact.flush();
  }
  if (block >= pieces_.size()) return search_outside(block - pieces_.size(), sink);
  const ScratchPool<Scratch>::Lease scratch(scratch_);
  Scratch& s = *scratch;
  const Piece piece = pieces_[block];
  std::size_t found = 0;
  constexpr std::size_t at_once = 512;  // so that the first pairs are on their way early
  for (std::size_t first = piece.first; first < piece.last; first += at_once) {
    const std::size_t count = std::min(at_once, piece.last - first);
    const std::size_t hits = overlapping(records_.data(), lists_[piece.list].data() + first, count, s.hits.data());
    found += hits;
    for (std::size_t k = 0; k < hits; ++k) sink.put(body_[s.hits[k].a], body_[s.hits[k].b]);
  }
  if (mode_ == Mode::renew) hits_.fetch_add(found, std::memory_order_relaxed);
}

void VerletList::search_outside(std::size_t block, PairSink& sink) {
  const ScratchPool<Scratch>::Lease scratch(scratch_);
  std::vector<std::uint32_t>& row = (*scratch).row;
  row.resize(std::max(outside_.size(), search_ == nullptr ? size() : 0) + BoxArray::padding);
  Found found(*this, sink);
  for (std::size_t k = block * outside_a_block, end = std::min(outside_.size(), k + outside_a_block); k < end; ++k) {
    const std::uint32_t index = outside_[k];
    const Aabb box = outside_boxes_[k];
    if (search_ != nullptr) {
      found.look_for(index, box);
      search_->search(box, index, found);
      found.flush();
    } else {
      const std::size_t count = overlap_row(*boxes_, 0, size(), box, row.data());
      for (std::size_t h = 0; h < count; ++h)
        if (is_outside_[row[h]] == 0) sink.put(index, row[h]);
    }
    // Those outside have no records: they meet each other here.
    const std::size_t count = overlap_row(outside_boxes_, k + 1, outside_.size(), box, row.data());
    for (std::size_t h = 0; h < count; ++h) sink.put(index, outside_[row[h]]);
  }
}

}  // namespace tandem
