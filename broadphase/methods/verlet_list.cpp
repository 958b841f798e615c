#include "methods/verlet_list.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <utility>

#include "kernels/row_kernel.h"
#include "trees/spatial_sample.h"

namespace tandem {

/// Takes what a search found for the larger box that a box outside gets: hands on what overlaps the box itself, and
/// keeps what may come to; neither when the pair is on the list already, or the other one is outside, too.
class VerletList::Found final : public PairSink {
 public:
  Found(const VerletList& owner, std::vector<std::uint32_t>& kept, PairSink& sink)
      : owner_(owner), kept_(kept), sink_(sink) {
    filter_ = &everything_;
    buffer_ = room_.data();
    capacity_ = room_.size();
  }
  void look_for(std::uint32_t index, const Aabb& box) {
    index_ = index;
    box_ = box;
  }
  void take(std::uint32_t other) {
    if (other == index_ || owner_.is_outside(other)) return;
    owner_.meet(index_, box_, other, (*owner_.boxes_)[other], kept_, sink_);
  }
  void flush() {
    const auto other = [this](std::size_t k) { return buffer_[k].a == index_ ? buffer_[k].b : buffer_[k].a; };
    for (std::size_t k = 0; k < count_; ++k) prefetch_box(*owner_.boxes_, other(k));
    for (std::size_t k = 0; k < count_; ++k)
      if (!owner_.returned_.has(other(k))) take(other(k));  // else its box is not the one that was found
    count_ = 0;
  }

 private:
  void full() override { flush(); }
  const VerletList& owner_;
  std::vector<std::uint32_t>& kept_;
  PairSink& sink_;
  PairFilter everything_;
  std::uint32_t index_ = 0;
  Aabb box_{};
  std::array<Pair, 64> room_;
};

/// Takes candidates and hands on those whose boxes overlap, without the early ones.
class VerletList::Tested final : public PairSink {
 public:
  Tested(const BoxArray& boxes, EarlySlab& early, PairSink& sink)
      : boxes_(boxes), early_(early), has_early_(early.taken()), sink_(sink) {
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
      const Aabb a = boxes_[buffer_[k].a], b = boxes_[buffer_[k].b];
      if (!overlap(a, b)) continue;
      ++found_;
      if (!has_early_ || !early_.holds(a.lo[early_.axis()], b.lo[early_.axis()])) sink_.put(buffer_[k].a, buffer_[k].b);
    }
    count_ = 0;
  }
  const BoxArray& boxes_;
  const EarlySlab& early_;
  const bool has_early_;
  PairSink& sink_;
  PairFilter everything_;
  std::size_t found_ = 0;
  std::array<Pair, 256> room_;
};

namespace {

// Nanoseconds, of a candidate tested, of a box searched for and of a box when a list is made: their ratios count.
constexpr double candidate_cost = 6, search_cost = 1200, renewal_cost = 120;
#ifdef NDEBUG
constexpr bool check_changes = false;
#else
constexpr bool check_changes = true;
#endif
constexpr double least_steps_ahead = 4, most_steps_ahead = 64;

/// Candidates that are kept at most.
std::size_t most_candidates(std::size_t boxes) { return 1024 + 24 * boxes; }

/// Boxes outside that are searched for one by one at most; they are also tested against each other.
std::size_t most_outside(std::size_t boxes) {
  return std::max<std::size_t>(32, std::min<std::size_t>(boxes / 16, 4096));
}

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

// Stages: decide, the method's but its last when it works from scratch, emit. Joint stages of a renewal within the
// last: prepare, the method's but its last.
std::size_t VerletList::begin(const BoxArray& boxes, ListedMethod& method) {
  const bool complete = !bare_ && boxes_ != nullptr && parts_done_.load(std::memory_order_relaxed) == part_count_ &&
                        (mode_ != Mode::reuse || blocks_done_.load(std::memory_order_relaxed) == part_count_ + 1);
  outside_last_ = complete ? outside() : 0;
  outside_since_ += outside_last_;
  const bool same = method_ == &method && larger_.size() == boxes.size() && method_stages_ != 0;
  has_past_ = complete && copies_ && records_.size() == boxes.size();
  list_made_ = list_made_ && same && complete &&
               (mode_ == Mode::reuse || blocks_done_.load(std::memory_order_relaxed) == list_count_);
  boxes_ = &boxes;
  method_ = &method;
  search_ = method.search_in();
  changed_ = std::exchange(next_changed_, {});
  if (changed_.size() != boxes.size() || !list_made_) changed_ = {};
  filtered_further_ = std::exchange(next_only_changes_, false);
  only_changes_ = filtered_further_ && !changed_.empty();
  method_begun_ = false;
  bare_ = bare_steps_left_ != 0;
  if (bare_) {
    --bare_steps_left_;
    mode_ = Mode::scratch;
    list_made_ = false;
    return method_->begin(boxes);
  }
  copies_ = true;
  is_resting_ = false;
  too_long_ = list_made_ && too_long();
  list_made_ = list_made_ && !too_long_ && list_filter_.same_arrays(filter_);
  records_.resize(size());
  larger_.resize(size());
  part_count_ = std::max<std::size_t>(1, (size() + boxes_a_part - 1) / boxes_a_part);
  if (parts_.size() < part_count_) parts_.resize(part_count_);
  for (Part& part : parts_) part.looked_at = 0;
  next_part_.store(0, std::memory_order_relaxed);
  parts_done_.store(0, std::memory_order_relaxed);
  if (list_made_) put_back();
  mode_ = Mode::scratch;
  if (!same) {
    method_begun_ = true;
    method_stages_ = method_->begin(boxes);
  }
  return first_method_stage + method_stages_;
}

std::size_t VerletList::blocks(std::size_t stage) const {
  if (bare_) return method_->blocks(stage);
  if (stage == 0) return 1;
  if (stage - first_method_stage + 1 < method_stages_)
    return mode_ == Mode::scratch ? method_->blocks(stage - first_method_stage) : 0;
  switch (mode_) {
    case Mode::scratch:  // and copies of the boxes
      return method_->blocks(method_stages_ - 1) + part_count_;
    case Mode::renew:
      return 1 + list_count_;
    default:  // of a list: its tiles, the boxes put back or outside of a part, those outside against each other
      return is_resting_ ? 0 : list_count_ + part_count_ + 1;
  }
}

void VerletList::run(std::size_t stage, std::size_t block) {
  if (bare_) return method_->run(stage, block);
  if (stage == 0) return decide();
  method_->run(stage - first_method_stage, block);
}

bool VerletList::too_long() const { return listed_.load(std::memory_order_relaxed) > most_candidates(size()); }

std::size_t VerletList::outside() const {
  std::size_t count = 0;
  if (mode_ == Mode::reuse)
    for (std::size_t part = 0; part < part_count_; ++part) count += parts_[part].outside.size();
  return count;
}

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

void VerletList::ReturnedList::forget(const ReturnedBodies& returned) {
  if (others.size() <= 2 * kept + 64) return;
  std::size_t first = 0, end = 0, entry_count = 0;
  for (Entry entry : entries) {
    const std::size_t begin = std::exchange(first, entry.end);
    if (returned.turn(entry.body) != entry.turn) continue;
    const std::size_t mine = end;
    for (std::size_t k = begin; k < first; ++k)
      if (returned.turn(others[k]) <= entry.turn) others[end++] = others[k];
    entry.end = end;
    if (end != mine) entries[entry_count++] = entry;
  }
  entries.resize(entry_count);
  others.resize(end);
  kept = end;
}

void VerletList::pack() {
  constexpr std::size_t few = 512, most_together = 1024;  // bodies
  const std::size_t listed = listed_bodies_.load(std::memory_order_relaxed);
  // What is read where the boxes are takes long, but must do until the others' boxes are copied.
  const std::size_t most_first = std::clamp<std::size_t>(listed / 64, 256, most_together);
  is_packed_ = listed < few * list_count_;
  if (is_packed_) put_together(most_first, most_together);
  first_lists_ = 0;
  for (std::size_t bodies = 0; first_lists_ < list_count_ && bodies < most_first / 2; ++first_lists_)
    bodies += list(first_lists_).bodies.size();
  first_lists_ = std::max(first_lists_, list_count_ / 64 + 1);
}

void VerletList::put_together(std::size_t most_first, std::size_t most_together) {
  std::size_t packed = 0;
  for (std::size_t k = 0; k < list_count_; ++k) {
    const std::size_t most = packed <= 1 ? most_first : most_together;
    if (packed == 0 || packed_[packed - 1].bodies.size() + lists_[k].bodies.size() > most) {
      if (packed_.size() == packed) packed_.emplace_back();
      packed_[packed++].clear();
    }
    packed_[packed - 1].append(lists_[k]);
    lists_[k] = {};
  }
  for (std::size_t k = packed; k < packed_.size(); ++k) packed_[k] = {};
  list_count_ = packed;
}

std::size_t VerletList::returned_candidates() const {
  std::size_t count = among_.others.size();
  for (std::size_t part = 0; part < part_count_; ++part) count += parts_[part].list.others.size();
  return count;
}

std::size_t VerletList::count_outside(std::size_t first, std::size_t last) const {
  // Those that have not changed are not outside.
  if (last_filter_.same(filter_, first, last)) return count_boxes_that_left(*boxes_, first, last, larger_);
  std::size_t count = 0;
  for (std::size_t i = first; i < last; ++i) count += is_outside(i) ? 1 : 0;
  return count;
}

std::size_t VerletList::guess_outside() const {
  if (size() <= boxes_a_part / 2) return count_outside(0, size());
  std::size_t count = 0;
  // A cache line's worth of boxes at each place.
  constexpr std::size_t boxes_a_place = 16;
  const std::size_t places = std::clamp<std::size_t>(size() / 4096, 32, 128);
  for (const bool look : {false, true}) {
    sample(size(), places, [&](std::size_t first) {
      first -= first % boxes_a_place;
      if (!look) {
        prefetch_box(*boxes_, first);
        return prefetch_box(larger_, first);
      }
      count += count_outside(first, std::min(size(), first + boxes_a_place));
    });
  }
  return count * size() / (places * boxes_a_place);
}

bool VerletList::keeps_list(std::size_t changed, bool& foreseen) {
  if (!list_made_) return false;
  if (changed > most_outside(size()) && guess_outside() > most_outside(size())) {
    foreseen = static_cast<double>(age_) >= steps_ahead_ || outside_since_ > most_outside(size());
    return false;
  }
  const auto n = static_cast<double>(size());
  const auto listed = listed_.load(std::memory_order_relaxed), hits = hits_.load(std::memory_order_relaxed);
  const auto age = static_cast<double>(age_), extra = static_cast<double>(listed - std::min(listed, hits));
  const bool wasteful = age >= std::max(4 * steps_ahead_, 32.0) && candidate_cost * extra * age > renewal_cost * n;
  // Those that leave an old list would leave a new one as often.
  const double leaving = static_cast<double>(outside_since_) * std::min(1.0, 2 * steps_ahead_ / age);
  const bool worn = search_cost * leaving > renewal_cost * n || returned_candidates() > most_candidates(size()) / 4;
  copies_ = wasteful || worn;
  return !has_past_ || !copies_;  // a step more shows how all move
}

void VerletList::reuse(std::size_t changed) {
  mode_ = Mode::reuse;
  blocks_done_.store(0, std::memory_order_relaxed);
  // Where few boxes are on the list, they are read where they are. For a list the last motion must be known.
  copies_ = copies_ || 4 * listed_bodies_.load(std::memory_order_relaxed) > size() || 8 * changed < size() ||
            static_cast<double>(age_ + 1) >= steps_ahead_ || outside_last_ != 0;
}

bool VerletList::may_renew(bool foreseen) {
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
  if (!(has_past_ && foreseen && !method_begun_ && bare_steps_left_ == 0)) return false;
  usual_ = usual();
  return !jolted();
}

void VerletList::decide() {
  const std::size_t changed = changed_.empty() ? size() : count_set(changed_);
  if (list_made_ && only_changes_ && changed == 0 && has_past_) return rest();
  ++age_;
  bool foreseen = true;
  if (keeps_list(changed, foreseen)) return reuse(changed);
  copies_ = true;
  list_made_ = may_renew(foreseen);
  if (list_made_) return begin_renewal();
  mode_ = Mode::scratch;
  if (!method_begun_) method_->begin(*boxes_);
}

void VerletList::begin_renewal() {
  mode_ = Mode::renew;
  age_ = outside_since_ = 0;
  blocks_done_.store(0, std::memory_order_relaxed);
  listed_.store(0, std::memory_order_relaxed);
  listed_bodies_.store(0, std::memory_order_relaxed);
  hits_.store(0, std::memory_order_relaxed);
  list_count_ = size() / boxes_a_list + 1;
  if (lists_.size() < list_count_) lists_.resize(list_count_);
  list_filter_.take(filter_);
  last_filter_.take(filter_);
  list_filter_view_ = list_filter_.view();
  filter_holds_.store(!(filter_.group.empty() && filter_.is_static.empty()), std::memory_order_relaxed);
  method_->begin(larger_);
  if (search_ != nullptr) search_->prepare_search();
  renewal_.start(method_stages_, part_count_);
  early_.choose(*boxes_, sample_boxes(*boxes_));
}

/// A step in which no box changes and no pair is asked for: the list and the records stay as they are.
void VerletList::rest() {
  mode_ = Mode::reuse;
  is_resting_ = true;
  for (std::size_t part = 0; part < part_count_; ++part) parts_[part].outside.clear();
  next_part_.store(part_count_, std::memory_order_relaxed);
  parts_done_.store(part_count_, std::memory_order_relaxed);
  blocks_done_.store(part_count_ + 1, std::memory_order_relaxed);
}

std::size_t VerletList::memory() const {
  std::size_t bytes = bytes_of(records_) + larger_.memory() + bytes_of(lists_) + bytes_of(packed_) +
                      list_filter_.memory() + last_filter_.memory() + returned_.memory() + among_.memory() +
                      bytes_of(parts_) + outside_boxes_.memory() + scratch_.memory() + looks_.memory() +
                      early_.memory();
  for (const auto* lists : {&lists_, &packed_})
    for (const CandidateTiles& list : *lists) bytes += list.memory();
  for (const Part& part : parts_) bytes += part.memory();
  return bytes;
}

UsualBox VerletList::usual() const {
  std::vector<float> motions, edges;
  sample(size(), std::min<std::size_t>(size(), 256), [&](std::size_t i) {
    const Aabb box = (*boxes_)[i];
    const float moved = motion(box, records_[i]), edge = longest_edge(box);
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
    const bool goes_on = motion(box, records_[i]) <= std::max(longest / 2, usual_.motion);
    const double most = std::max<double>(longest, usual_.motion * steps_ahead_);
    std::array<double, 3> edge, swept;
    double product_now = 1, product_then = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const double step = goes_on ? std::abs(double{box.lo[k]} - double{records_[i].lo()[k]}) : 0;
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
    enlarge_boxes(*boxes_, first, last, records_.data(), static_cast<float>(steps_ahead_), usual_, larger_);
  copy_boxes(*boxes_, first, last, records_.data());
  parts_done_.fetch_add(1, std::memory_order_relaxed);
}

bool VerletList::help_look() {
  while (next_part_.load(std::memory_order_relaxed) < part_count_) {
    const std::size_t part = next_part_.fetch_add(1, std::memory_order_relaxed);
    if (part >= part_count_) break;
    // Who waits for it must not wait for ever when memory is out.
    struct Done {
      std::uint8_t& flag;
      ~Done() { std::atomic_ref(flag).store(1, std::memory_order_release); }
    } const done{parts_[part].looked_at};
    look_at(part);
    parts_done_.fetch_add(1, std::memory_order_release);
  }
  return parts_done_.load(std::memory_order_acquire) == part_count_;
}

void VerletList::look_at(std::size_t index) {
  Part& part = parts_[index];
  const std::size_t first = index * boxes_a_part, last = part_end(index);
  const ScratchPool<Look>::Lease lease(looks_);
  Look& look = *lease;
  part.outside.clear();
  std::size_t count = find_outside(index, look);
  if (!changes_known() && !last_filter_.same(filter_, first, last)) {
    // Looked at one by one: rare.
    filter_holds_.store(false, std::memory_order_relaxed);
    count = 0;
    for (std::size_t i = first; i < last; ++i)
      if (is_outside(i)) {
        look.past[count].set((*boxes_)[i]);
        look.outside[count++] = static_cast<std::uint32_t>(i);
      }
  }
  if (count == 0) return;
  part.outside.assign(look.outside.begin(), look.outside.begin() + static_cast<std::ptrdiff_t>(count));
  part.boxes.resize(count);
  part.larger.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    part.boxes.set(k, (*boxes_)[part.outside[k]]);
    if (!has_past_ || !copies_) look.past[k].set(part.boxes[k]);
  }
  // Further than all others: each costs a search of its own.
  enlarge_boxes(part.boxes, 0, count, look.past.data(), 2 * static_cast<float>(steps_ahead_), usual_, part.larger);
  part.filter.take(filter_, part.outside);
}

std::size_t VerletList::find_outside(std::size_t index, Look& look) {
  const std::size_t first = index * boxes_a_part, last = part_end(index);
  BoxRecord* records = copies_ ? records_.data() : nullptr;
  if (!changes_known())
    return copy_boxes_that_left(*boxes_, first, last, larger_, records, look.outside.data(), look.past.data());
  const std::size_t changed = indices_set(changed_, first, last, look.changed.data());
  if (check_changes)
    for (std::size_t i = first; i < last; ++i) assert(changed_[i] != 0 || is_as_before(i));

  if (4 * changed > 3 * (last - first) && last_filter_.same(filter_, first, last)) {
    // All in a row is faster than these one by one. What has not changed is outside of nothing.
    const std::size_t left =
        copy_boxes_that_left(*boxes_, first, last, larger_, records, look.outside.data(), look.past.data());
    std::size_t count = 0;
    for (std::size_t k = 0; k < left; ++k) {
      if (changed_[look.outside[k]] == 0) continue;
      look.past[count] = look.past[k];
      look.outside[count++] = look.outside[k];
    }
    return count;
  }

  // Whose part of the filter changed is not looked for.
  if (changed != 0) filter_holds_.store(false, std::memory_order_relaxed);
  constexpr std::size_t ahead = 8;
  Part& part = parts_[index];
  const std::span<const std::uint32_t> bodies(look.changed.data(), changed);
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
      if (records != nullptr) look.past[count] = records[at];
      look.outside[count++] = at;
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

const VerletList::Part& VerletList::looked_at(std::size_t part) const {
  while (std::atomic_ref(parts_[part].looked_at).load(std::memory_order_acquire) == 0) std::this_thread::yield();
  return parts_[part];
}

void VerletList::emit(std::size_t block, PairSink& sink) {
  if (bare_) return method_->emit(block, sink);
  if (mode_ == Mode::scratch) {
    const std::size_t blocks = method_->blocks(method_stages_ - 1);
    return block < blocks ? method_->emit(block, sink) : prepare(block - blocks);
  }
  if (mode_ == Mode::renew && block == 0) return early_.emit(sink);
  const ScratchPool<Scratch>::Lease lease(scratch_);
  Scratch& scratch = *lease;
  if (mode_ == Mode::renew) return renew_block(block - 1, scratch, sink);
  const bool first_tiles = block < std::min(first_lists_, list_count_);
  const bool all_copied = !first_tiles && help_look() && copies_;
  if (block < list_count_) {
    (void)test(list(block), all_copied, scratch, sink);
    return;
  }
  if (block - list_count_ < part_count_) {
    (void)looked_at(block - list_count_);
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
  if (too_long()) {  // it will not be used
    Tested tested(*boxes_, early_, sink);
    for (std::size_t b = first; b < last; ++b) method_->emit(b, tested);
    hits_.fetch_add(tested.finish(), std::memory_order_relaxed);
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
  // Lists are short and lie anywhere: what follows the first lines is not fetched ahead by itself.
  prefetch(tiles.bodies);
  prefetch(tiles.candidates);
  BoxRecord* boxes = scratch.boxes.data();
  const bool early = mode_ == Mode::renew && early_.taken();
  // As long as not all are looked at, it is not known whether the filter is as it was.
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
    const std::uint32_t exchanged = (a ^ b) & (0u - std::uint32_t{b < a});  // no branch: nothing foresees which is less
    sink.put_allowed({a ^ exchanged, b ^ exchanged});
  }
}

void VerletList::put_later(std::span<const LocalPair> pairs, const std::uint32_t* bodies, const BoxRecord* boxes,
                           PairSink& sink) const {
  const std::size_t axis = early_.axis();
  for (const LocalPair pair : pairs)
    if (!early_.holds(boxes[pair.a].lo()[axis], boxes[pair.b].lo()[axis])) sink.put(bodies[pair.a], bodies[pair.b]);
}

// A pair is held by the one that was put back last.
void VerletList::test(const ReturnedList& list, bool all_copied, PairSink& sink) const {
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
  for (const ReturnedList::Entry& entry : list.entries) {
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
    found.look_for(index, part.boxes[k]);
    if (search_ != nullptr) {
      search_->search(larger, index, found);
      found.flush();
      scratch.found.clear();
      returned_.overlapping(larger, scratch.row, scratch.found);
      for (const std::uint32_t other : scratch.found) found.take(other);
    } else {
      const std::size_t count = overlap_row(larger_, 0, size(), larger, scratch.row.data());
      for (std::size_t h = 0; h < count; ++h) found.take(scratch.row[h]);
    }
    part.list.close(index, returned_.turn() + 1);
  }
}

// A sweep along the first axis, so that time does not grow with the square of what is outside.
void VerletList::test_outside(Scratch& scratch, PairSink& sink) {
  struct Outside {
    std::uint32_t body;
    Aabb box, larger;
  };
  std::vector<Outside> all;
  for (std::size_t p = 0; p < part_count_; ++p) {
    const Part& part = looked_at(p);
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
