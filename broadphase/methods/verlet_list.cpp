// Decides which steps reuse the Verlet list, which make it anew, and for how many steps it is made.
#include "methods/verlet_list.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "trees/spatial_sample.h"

namespace tandem {

namespace {

// Estimated times in nanoseconds, of which only ratios matter: to test a candidate, to search for a box that left, and
// to make a list, per box; and of a whole step that reuses a list, per box and per candidate.
constexpr double candidate_cost = 6, search_cost = 1200, renewal_cost = 120, reused_box_cost = 12,
                 reused_candidate_cost = 4;
constexpr double least_steps_ahead = 4, most_steps_ahead = 64;
/// A list is worth making if its steps take no more than this share of the time of steps from scratch: a smaller gain
/// is not worth the long steps of renewals.
constexpr double worth_making = 0.8;
/// Candidates for each pair beyond which the boxes' motions are those of a shock, with which no list is made.
constexpr double most_for_a_pair = 16;

/// The most candidates that are kept.
std::size_t most_candidates(std::size_t boxes) { return 1024 + 24 * boxes; }

/// The most boxes outside that are searched for one by one; they are also tested against each other.
std::size_t most_outside(std::size_t boxes) {
  return std::max<std::size_t>(32, std::min<std::size_t>(boxes / 16, 4096));
}

/// The largest change of a bound of the box; NaN or infinite where the box was or is empty.
float motion(const Aabb& box, const BoxRecord& past) {
  float most = 0;
  for (std::size_t k = 0; k < 3; ++k)
    most = std::max({std::abs(box.lo[k] - past.lo()[k]), std::abs(box.hi[k] - past.hi()[k]), most});
  return most;
}

/// The longest edge; negative for an empty box.
float longest_edge(const Aabb& box) {
  return std::max({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]});
}

/// A stratified sample: calls visit with one pseudo-random index of each of `strata` equal ranges; always the same
/// indices.
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

// Stages: decide, those of the method but its last (in a step from scratch), emit. Joint stages of a renewal within the
// last one: prepare, those of the method but its last.
std::size_t VerletList::begin(const BoxArray& boxes, ListedMethod& method) {
  const bool complete = !without_list_ && boxes_ != nullptr &&
                        parts_done_.load(std::memory_order_relaxed) == part_count_ &&
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
  without_list_ = steps_without_list_ != 0;
  if (without_list_) {
    --steps_without_list_;
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
  for (Part& part : parts_) part.checked = 0;
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
  if (without_list_) return method_->blocks(stage);
  if (stage == 0) return 1;
  if (stage - first_method_stage + 1 < method_stages_)
    return mode_ == Mode::scratch ? method_->blocks(stage - first_method_stage) : 0;
  switch (mode_) {
    case Mode::scratch:  // and the blocks that copy the boxes
      return method_->blocks(method_stages_ - 1) + part_count_;
    case Mode::renew:
      return 1 + list_count_;
    default:  // reuse: tiles of the list; boxes put back or outside, by parts; boxes outside against each other
      return is_resting_ ? 0 : list_count_ + part_count_ + 1;
  }
}

void VerletList::run(std::size_t stage, std::size_t block) {
  if (without_list_) return method_->run(stage, block);
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

void VerletList::pack() {
  constexpr std::size_t few = 512, most_together = 1024;  // bodies
  const std::size_t listed = listed_bodies_.load(std::memory_order_relaxed);
  // Boxes read from the box array take longer, but the first tiles must do with them until all boxes are copied.
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
  // Boxes whose filter has not changed can only be outside by their bounds.
  if (last_filter_.same(filter_, first, last)) return count_boxes_that_left(*boxes_, first, last, larger_);
  std::size_t count = 0;
  for (std::size_t i = first; i < last; ++i) count += is_outside(i) ? 1 : 0;
  return count;
}

std::size_t VerletList::guess_outside() const {
  if (size() <= boxes_a_part / 2) return count_outside(0, size());
  std::size_t count = 0;
  // The boxes of one cache line at each sampled place.
  constexpr std::size_t boxes_a_place = 16;
  const std::size_t places = std::clamp<std::size_t>(size() / 4096, 32, 128);
  for (const bool fetched : {false, true}) {
    sample(size(), places, [&](std::size_t first) {
      first -= first % boxes_a_place;
      if (!fetched) {
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
  // Bodies that leave an old list would leave a new one as often.
  const double leaving = static_cast<double>(outside_since_) * std::min(1.0, 2 * steps_ahead_ / age);
  const bool worn = search_cost * leaving > renewal_cost * n || returned_candidates() > most_candidates(size()) / 4;
  copies_ = wasteful || worn;
  return !has_past_ || !copies_;  // one step more shows how all boxes move
}

void VerletList::reuse(std::size_t changed) {
  mode_ = Mode::reuse;
  blocks_done_.store(0, std::memory_order_relaxed);
  // With few boxes on the list, they are read from the box array instead of records. A new list needs the last motion
  // of all.
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
  // Lists that do not last, or would be too long, are suspended: for 8 steps, then 16, up to 128, each time followed by
  // a trial.
  if (failed && (failures_ > 1 || too_long_))
    steps_without_list_ = std::size_t{4} << std::min<std::size_t>(failures_, 5);
  if (!(has_past_ && foreseen && !method_begun_ && steps_without_list_ == 0)) return false;
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
  next_part_.store(std::uint64_t{part_count_} << 32, std::memory_order_relaxed);
  parts_done_.store(part_count_, std::memory_order_relaxed);
  blocks_done_.store(part_count_ + 1, std::memory_order_relaxed);
}

std::size_t VerletList::memory() const {
  std::size_t bytes = bytes_of(records_) + larger_.memory() + bytes_of(lists_) + bytes_of(packed_) +
                      list_filter_.memory() + last_filter_.memory() + returned_.memory() + among_.memory() +
                      bytes_of(parts_) + outside_boxes_.memory() + scratch_.memory() + check_scratch_.memory() +
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

// For evenly spread boxes, the number of overlapping pairs is proportional to the product over the axes of the sums of
// their edges: compares that of the swept boxes with that of the boxes.
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
  return then * pairs > most_for_a_pair * now;
}

// Looking further ahead makes renewals rarer, lists longer and boxes that leave more frequent. The total is near its
// minimum where renewal and use cost the same.
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
  const double renewal = costs.listed_box * n + costs.candidate * candidates,
               reuse = reused_box_cost * n + reused_candidate_cost * candidates;
  const auto reused = static_cast<double>(age_ - 1);
  const double searches = search_cost * static_cast<double>(outside_since_);
  return renewal + reused * reuse + searches <= worth_making * (1 + reused) * scratch;
}

}  // namespace tandem
