// Registered objects with their boxes in floats, rounded outward, for tandem's broad phase, which finds all pairs from
// what it kept of the step before, and for its hierarchy, which is asked for one object's. What they find is put to
// FCL's own tests on the exact boxes.
#include "tandem/fcl/object_boxes.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "tandem/broadphase/box_queries.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem::fcl {
namespace {

constexpr std::uint32_t none = 0xffffffffu;
/// By how much larger the hierarchy's lowest nodes may become before it is built anew, by surface.
constexpr double worn_out = 1.5;
/// How many of the boxes, as one in so many, move before it is asked how worn it is: that takes a pass over an eighth.
constexpr std::size_t moves_between_checks = 4;
/// Distances are rounded: a limit for the hierarchy is larger by more than that.
constexpr double above_rounding = 1 + 32 * std::numeric_limits<double>::epsilon();

/// Holds all that the box's bounds lie between; NaN may be anywhere.
Aabb outward(const ExactBox& box) {
  constexpr double everywhere = std::numeric_limits<double>::infinity();
  Aabb out;
  for (std::size_t k = 0; k < 3; ++k) {
    const bool known = box.lo[k] == box.lo[k] && box.hi[k] == box.hi[k];
    out.lo[k] = round_down(known ? std::min(box.lo[k], box.hi[k]) : -everywhere);
    out.hi[k] = round_up(known ? std::max(box.lo[k], box.hi[k]) : everywhere);
  }
  return out;
}

bool same(const ExactBox& a, const ExactBox& b) { return a.lo == b.lo && a.hi == b.hi; }

/// As ::fcl::AABB::overlap.
bool overlap(const ExactBox& a, const ExactBox& b) {
  for (std::size_t k = 0; k < 3; ++k)
    if (a.lo[k] > b.hi[k] || a.hi[k] < b.lo[k]) return false;
  return true;
}

/// As ::fcl::AABB::distance.
double distance(const ExactBox& a, const ExactBox& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double off = a.lo[k] > b.hi[k] ? a.lo[k] - b.hi[k] : b.lo[k] > a.hi[k] ? b.lo[k] - a.hi[k] : 0;
    sum += off * off;
  }
  return std::sqrt(sum);
}

/// What was made of the boxes, once for all that ask until they change, by the first of them.
class MadeOnce {
 public:
  template <class Make>
  void ensure(const Make& make) {
    if (made_.load(std::memory_order_acquire)) return;
    const std::lock_guard lock(making_);
    if (made_.load(std::memory_order_relaxed)) return;
    make();
    made_.store(true, std::memory_order_release);
  }
  void outdate() { made_.store(false, std::memory_order_relaxed); }

 private:
  std::atomic<bool> made_{false};
  std::mutex making_;
};

/// Keeps the pairs it is given.
class PairList final : public PairSink {
 public:
  PairList() { filter_ = &all_; }
  void clear() {
    count_ = 0;
    buffer_ = pairs_.data();
    capacity_ = pairs_.size();
    if (capacity_ == 0) full();
  }
  std::span<const Pair> pairs() const { return std::span(pairs_).first(count_); }

 protected:
  void full() override {
    pairs_.resize(std::max<std::size_t>(256, 2 * pairs_.size()));
    buffer_ = pairs_.data();
    capacity_ = pairs_.size();
  }

 private:
  const PairFilter all_;
  std::vector<Pair> pairs_;
};

}  // namespace

struct ObjectBoxes::Impl {
  // By place.
  std::vector<void*> objects;  // null: free
  std::vector<ExactBox> exact;
  std::vector<std::uint32_t> earlier;  // another registration of the same object, or none
  BoxArray boxes;                      // at least so many, empty where free

  std::unordered_map<const void*, std::uint32_t> last;  // registration of an object
  std::vector<std::uint32_t> free;
  std::size_t count = 0;

  MadeOnce pairs_made;
  std::vector<std::uint8_t> is_changed_for_pairs;  // by place
  std::unique_ptr<BroadPhase> broad_phase = make_broad_phase(BroadPhaseKind::automatic);
  PairList pairs;

  MadeOnce tree_made;
  std::vector<std::uint8_t> is_changed_for_tree;  // by place
  std::vector<std::uint32_t> changed_for_tree;
  BoxQueries tree;
  std::vector<std::uint8_t> is_placed;  // by place: it was taken when the tree was built
  std::size_t moves = 0;                // since it was asked how worn the tree is

  Impl() { pairs.clear(); }
  void change(std::uint32_t place);
  void set(std::uint32_t place, const ExactBox& box) {
    if (same(exact[place], box)) return;
    exact[place] = box;
    change(place);
  }
  void make_pairs();
  void make_tree();
  const BoxQueries& current_tree() {
    tree_made.ensure([this] { make_tree(); });
    return tree;
  }
};

void ObjectBoxes::Impl::change(std::uint32_t place) {
  if (place >= boxes.size()) {
    boxes.resize(objects.capacity());
    is_changed_for_pairs.resize(boxes.size());
    is_changed_for_tree.resize(boxes.size());
    is_placed.resize(boxes.size());
  }
  if (objects[place] != nullptr)
    boxes.set(place, outward(exact[place]));
  else
    boxes.set_empty(place);
  is_changed_for_pairs[place] = 1;
  if (is_changed_for_tree[place] == 0) changed_for_tree.push_back(place);
  is_changed_for_tree[place] = 1;
  pairs_made.outdate();
  tree_made.outdate();
}

void ObjectBoxes::Impl::make_pairs() {
  pairs.clear();
  broad_phase->expect_changes(is_changed_for_pairs);
  const std::size_t stages = broad_phase->begin(boxes);
  for (std::size_t stage = 0; stage + 1 < stages; ++stage)
    for (std::size_t block = 0; block < broad_phase->blocks(stage); ++block) broad_phase->run(stage, block);
  for (std::size_t block = 0; block < broad_phase->blocks(stages - 1); ++block) broad_phase->emit(block, pairs);
  std::fill(is_changed_for_pairs.begin(), is_changed_for_pairs.end(), std::uint8_t{0});
}

void ObjectBoxes::Impl::make_tree() {
  bool build = false;
  for (const std::uint32_t place : changed_for_tree) {
    build = build || is_placed[place] == 0;
    is_changed_for_tree[place] = 0;
  }
  if (!build) {
    tree.refit(boxes, changed_for_tree);
    moves += changed_for_tree.size();
    if (moves * moves_between_checks > boxes.size()) {
      moves = 0;
      build = tree.worn() > worn_out;
    }
  }
  changed_for_tree.clear();
  if (!build) return;
  tree.build(boxes);
  moves = 0;
  for (std::size_t place = 0; place < objects.size(); ++place) is_placed[place] = objects[place] != nullptr ? 1 : 0;
}

ObjectBoxes::ObjectBoxes() : impl_(std::make_unique<Impl>()) {}
ObjectBoxes::~ObjectBoxes() = default;
ObjectBoxes::ObjectBoxes(ObjectBoxes&&) noexcept = default;
ObjectBoxes& ObjectBoxes::operator=(ObjectBoxes&&) noexcept = default;

std::size_t ObjectBoxes::size() const { return impl_->count; }

void ObjectBoxes::reserve(std::size_t more) {
  Impl& m = *impl_;
  const std::size_t all = m.objects.size() + more;
  m.last.reserve(m.last.size() + more);
  m.objects.reserve(all);
  m.exact.reserve(all);
  m.earlier.reserve(all);
}

void ObjectBoxes::add(void* object, const ExactBox& box) {
  Impl& m = *impl_;
  auto place = static_cast<std::uint32_t>(m.objects.size());
  if (m.free.empty()) {
    m.objects.push_back(object);
    m.exact.push_back(box);
    m.earlier.push_back(none);
  } else {
    place = m.free.back();
    m.free.pop_back();
    m.objects[place] = object;
    m.exact[place] = box;
  }
  const auto [entry, is_first] = m.last.try_emplace(object, place);
  m.earlier[place] = is_first ? none : entry->second;
  entry->second = place;
  ++m.count;
  m.change(place);
}

void ObjectBoxes::remove(const void* object) {
  Impl& m = *impl_;
  const auto entry = m.last.find(object);
  if (entry == m.last.end()) return;
  const std::uint32_t place = entry->second;
  if (m.earlier[place] == none)
    m.last.erase(entry);
  else
    entry->second = m.earlier[place];
  m.objects[place] = nullptr;
  m.free.push_back(place);
  --m.count;
  m.change(place);
}

void ObjectBoxes::clear() { impl_ = std::make_unique<Impl>(); }

std::span<void* const> ObjectBoxes::objects() const { return impl_->objects; }

void ObjectBoxes::set(std::size_t place, const ExactBox& box) { impl_->set(static_cast<std::uint32_t>(place), box); }

void ObjectBoxes::set(const void* object, const ExactBox& box) {
  const auto entry = impl_->last.find(object);
  if (entry == impl_->last.end()) return;
  for (std::uint32_t place = entry->second; place != none; place = impl_->earlier[place]) impl_->set(place, box);
}

namespace {

template <class Take>
class OverlapVisitor final : public BoxVisitor {
 public:
  explicit OverlapVisitor(const Take& take) : take_(take) {}
  bool visit(std::uint32_t place) override { return take_(place); }

 private:
  const Take& take_;
};

/// How far a search for near objects still goes.
struct Reach {
  double limit;
  bool going = true;

  /// What to say to the hierarchy, which shows what is at the limit, too.
  double outward() const { return going && limit > 0 ? limit * above_rounding : -1; }
};

template <class Take>
class ReachVisitor final : public NearVisitor {
 public:
  ReachVisitor(const Reach& reach, const Take& take) : reach_(reach), take_(take) {}
  double visit(std::uint32_t place, double) override {
    take_(place);
    return reach_.outward();
  }

 private:
  const Reach& reach_;
  const Take& take_;
};

}  // namespace

void ObjectBoxes::visit_overlapping(void* asked, const ExactBox& box, ObjectPairVisitor& visitor) const {
  Impl& m = *impl_;
  const auto take = [&](std::uint32_t place) {
    return !overlap(m.exact[place], box) || visitor.visit(m.objects[place], asked);
  };
  OverlapVisitor found(take);
  m.current_tree().visit_overlapping(outward(box), found);
}

void ObjectBoxes::visit_overlapping(ObjectPairVisitor& visitor) const {
  Impl& m = *impl_;
  m.pairs_made.ensure([&m] { m.make_pairs(); });
  for (const auto [a, b] : m.pairs.pairs())
    if (overlap(m.exact[a], m.exact[b]) && !visitor.visit(m.objects[a], m.objects[b])) return;
}

void ObjectBoxes::visit_overlapping(const ObjectBoxes& other, ObjectPairVisitor& visitor) const {
  const bool swapped = size() < other.size();  // the smaller set asks the larger one
  Impl &large = swapped ? *other.impl_ : *impl_, &small = swapped ? *impl_ : *other.impl_;
  const BoxQueries& tree = large.current_tree();
  bool going = true;
  for (std::size_t i = 0; i < small.objects.size() && going; ++i) {
    if (small.objects[i] == nullptr) continue;
    const auto take = [&](std::uint32_t place) {
      if (!overlap(large.exact[place], small.exact[i])) return true;
      return going = swapped ? visitor.visit(small.objects[i], large.objects[place])
                             : visitor.visit(large.objects[place], small.objects[i]);
    };
    OverlapVisitor found(take);
    tree.visit_overlapping(small.boxes[i], found);
  }
}

void ObjectBoxes::visit_near(void* asked, const ExactBox& box, double limit, NearPairVisitor& visitor) const {
  Impl& m = *impl_;
  Reach reach{limit};
  const auto take = [&](std::uint32_t place) {
    if (distance(m.exact[place], box) < reach.limit) reach.going = visitor.visit(m.objects[place], asked, reach.limit);
  };
  ReachVisitor found(reach, take);
  m.current_tree().visit_near(outward(box), reach.outward(), found);
}

void ObjectBoxes::visit_near(double limit, NearPairVisitor& visitor) const {
  Impl& m = *impl_;
  const BoxQueries& tree = m.current_tree();
  Reach reach{limit};
  for (std::uint32_t i = 0; i < m.objects.size() && reach.outward() > 0; ++i) {
    if (m.objects[i] == nullptr) continue;
    const auto take = [&](std::uint32_t place) {
      if (i < place && distance(m.exact[i], m.exact[place]) < reach.limit)
        reach.going = visitor.visit(m.objects[i], m.objects[place], reach.limit);
    };
    ReachVisitor found(reach, take);
    tree.visit_near(m.boxes[i], reach.outward(), found);
  }
}

void ObjectBoxes::visit_near(const ObjectBoxes& other, double limit, NearPairVisitor& visitor) const {
  const bool swapped = size() < other.size();  // the smaller set asks the larger one
  Impl &large = swapped ? *other.impl_ : *impl_, &small = swapped ? *impl_ : *other.impl_;
  const BoxQueries& tree = large.current_tree();
  Reach reach{limit};
  for (std::size_t i = 0; i < small.objects.size() && reach.outward() > 0; ++i) {
    if (small.objects[i] == nullptr) continue;
    const auto take = [&](std::uint32_t place) {
      if (!(distance(small.exact[i], large.exact[place]) < reach.limit)) return;
      reach.going = swapped ? visitor.visit(small.objects[i], large.objects[place], reach.limit)
                            : visitor.visit(large.objects[place], small.objects[i], reach.limit);
    };
    ReachVisitor found(reach, take);
    tree.visit_near(small.boxes[i], reach.outward(), found);
  }
}

}  // namespace tandem::fcl
