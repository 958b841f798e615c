// Registered objects with their boxes in floats, rounded outward, for tandem's broad phase, which finds all pairs with
// the candidates kept from the step before, and for its hierarchy, which answers for single objects. Results are
// filtered by FCL's own tests on the exact boxes.
#include "tandem/fcl/object_boxes.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "tandem/broadphase/box_queries.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem::fcl {
namespace {

constexpr std::uint32_t none = 0xffffffffu;
/// Factor by which the surface of the hierarchy's lowest nodes may grow before it is built anew.
constexpr double worn_out = 1.5;
/// A quarter of the boxes move between two checks of that growth: a check takes a pass over an eighth of the nodes.
constexpr std::size_t moves_between_checks = 4;
/// The number of boxes that are compared with their neighbours before all are: in a crowded world some of them already
/// overlap.
constexpr std::size_t neighbours_tested = 128, neighbours_a_group = 8;
/// Distances are rounded: a limit for the hierarchy is enlarged by more than that.
constexpr double above_rounding = 1 + 32 * std::numeric_limits<double>::epsilon();

constexpr float far = std::numeric_limits<float>::infinity();
constexpr Aabb no_box{{far, far, far}, {-far, -far, -far}};

/// The box in floats that contains the given one, as far as floats reach, and at most two units in the last place
/// larger; NaN becomes unbounded.
Aabb outward(const ExactBox& box) {
  constexpr double most = std::numeric_limits<float>::max(), smallest = std::numeric_limits<float>::min(),
                   last_place = std::numeric_limits<float>::epsilon();
  Aabb out;
  for (std::size_t k = 0; k < 3; ++k) {
    const bool known = box.lo[k] == box.lo[k] && box.hi[k] == box.hi[k];
    const double lo = known ? std::clamp(std::min(box.lo[k], box.hi[k]), -most, most) : -most;
    const double hi = known ? std::clamp(std::max(box.lo[k], box.hi[k]), -most, most) : most;
    out.lo[k] = static_cast<float>(std::max(lo - (std::abs(lo) * last_place + smallest), -most));
    out.hi[k] = static_cast<float>(std::min(hi + (std::abs(hi) * last_place + smallest), most));
  }
  return out;
}

/// By their bits, so that a box with NaN equals itself.
bool same(const ExactBox& a, const ExactBox& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

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

/// Data made from the boxes, once until they change, by the first of several threads that needs them.
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

/// Collects pairs.
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

/// Places whose boxes have changed since data were made from them.
class Changes {
 public:
  void resize(std::size_t places) { flags_.resize(places); }
  void add(std::uint32_t place) {
    if (flags_[place] == 0) list_.push_back(place);
    flags_[place] = 1;
  }
  std::span<const std::uint32_t> list() const { return list_; }
  std::span<const std::uint8_t> flags() const { return flags_; }
  void clear() {
    for (const std::uint32_t place : list_) flags_[place] = 0;
    list_.clear();
  }

 private:
  std::vector<std::uint8_t> flags_;
  std::vector<std::uint32_t> list_;
};

struct ObjectBoxes::Impl {
  // By place.
  std::vector<void*> objects;  // null: free
  std::vector<ExactBox> exact;
  std::vector<std::uint8_t> changed;   // since the lists of changes were made
  std::vector<std::uint32_t> earlier;  // an earlier registration of the same object, or none

  std::vector<std::uint32_t> some_changed;  // places that may have changed, one by one
  bool all_changed = false;                 // or all may have

  std::unordered_map<const void*, std::uint32_t> last;  // registration of an object
  std::vector<std::uint32_t> free;
  std::size_t count = 0;
  std::size_t room = 0;  // number of places in data made from them; free ones are empty boxes there

  MadeOnce changes_listed;
  MadeOnce pairs_made;
  Changes changed_for_pairs;
  BoxArray boxes;
  std::unique_ptr<BroadPhase> broad_phase = make_broad_phase(BroadPhaseKind::automatic);
  PairList pairs;

  MadeOnce tree_made;
  Changes changed_for_tree;
  std::vector<Aabb> tree_boxes;
  BoxQueries tree;
  std::vector<std::uint8_t> is_placed;  // by place: it was in use when the tree was built
  std::size_t moves = 0;                // since the last check of the tree's growth

  MadeOnce neighbours_made;
  std::vector<std::uint32_t> in_order;    // the first places in the order of the tree when it was last built
  std::vector<std::uint32_t> neighbours;  // the same before the tree was updated

  Impl() { pairs.clear(); }
  void change(std::uint32_t place);
  void set(std::uint32_t place, const ExactBox& box) {
    if (same(exact[place], box)) return;
    exact[place] = box;
    change(place);
  }
  Aabb box(std::uint32_t place) const { return objects[place] != nullptr ? outward(exact[place]) : no_box; }
  void outdate() {
    changes_listed.outdate();
    pairs_made.outdate();
    tree_made.outdate();
    neighbours_made.outdate();
  }
  void list_changes();
  void make_pairs();
  void make_tree();
  void build_tree();
  const BoxQueries& current_tree() {
    tree_made.ensure([this] { make_tree(); });
    return tree;
  }
  std::span<const std::uint32_t> current_neighbours() {
    neighbours_made.ensure([this] { neighbours = in_order; });
    return neighbours;
  }
};

void ObjectBoxes::Impl::change(std::uint32_t place) {
  if (place >= room) room = objects.capacity();
  if (changed[place] == 0) some_changed.push_back(place);
  changed[place] = 1;
  outdate();
}

void ObjectBoxes::Impl::list_changes() {
  changed_for_pairs.resize(room);
  changed_for_tree.resize(room);
  const auto add = [this](std::uint32_t place) {
    if (changed[place] == 0) return;
    changed[place] = 0;
    changed_for_pairs.add(place);
    changed_for_tree.add(place);
  };
  if (all_changed)
    for (std::uint32_t place = 0; place < changed.size(); ++place) add(place);
  else
    for (const std::uint32_t place : some_changed) add(place);
  all_changed = false;
  some_changed.clear();
}

void ObjectBoxes::Impl::make_pairs() {
  changes_listed.ensure([this] { list_changes(); });
  if (boxes.size() != room) boxes.resize(room);
  for (const std::uint32_t place : changed_for_pairs.list()) boxes.set(place, box(place));
  pairs.clear();
  broad_phase->expect_changes(changed_for_pairs.flags());
  const std::size_t stages = broad_phase->begin(boxes);
  for (std::size_t stage = 0; stage + 1 < stages; ++stage)
    for (std::size_t block = 0; block < broad_phase->blocks(stage); ++block) broad_phase->run(stage, block);
  for (std::size_t block = 0; block < broad_phase->blocks(stages - 1); ++block) broad_phase->emit(block, pairs);
  changed_for_pairs.clear();
}

void ObjectBoxes::Impl::make_tree() {
  changes_listed.ensure([this] { list_changes(); });
  current_neighbours();  // before the tree's order changes: which thread comes first must not matter
  tree_boxes.resize(room, no_box);
  bool build = is_placed.size() != room;
  is_placed.resize(room);
  for (const std::uint32_t place : changed_for_tree.list()) {
    tree_boxes[place] = box(place);
    build = build || is_placed[place] == 0;
  }
  if (!build) {
    tree.refit(tree_boxes, changed_for_tree.list());
    moves += changed_for_tree.list().size();
    if (moves * moves_between_checks > room) {
      moves = 0;
      build = tree.worn() > worn_out;
    }
  }
  changed_for_tree.clear();
  if (build) build_tree();
}

void ObjectBoxes::Impl::build_tree() {
  BoxArray all;
  all.resize(room);
  for (std::size_t place = 0; place < room; ++place) all.set(place, tree_boxes[place]);
  tree.build(all);
  moves = 0;
  for (std::size_t place = 0; place < objects.size(); ++place) is_placed[place] = objects[place] != nullptr ? 1 : 0;
  struct First final : BoxVisitor {
    std::vector<std::uint32_t>& places;
    explicit First(std::vector<std::uint32_t>& p) : places(p) { places.clear(); }
    bool visit(std::uint32_t place) override {
      places.push_back(place);
      return places.size() < neighbours_tested;
    }
  } first(in_order);
  tree.visit_overlapping({no_box.hi, no_box.lo}, first);  // all of them
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
  m.changed.reserve(all);
  m.earlier.reserve(all);
}

void ObjectBoxes::add(void* object, const ExactBox& box) {
  Impl& m = *impl_;
  auto place = static_cast<std::uint32_t>(m.objects.size());
  if (m.free.empty()) {
    m.objects.push_back(object);
    m.exact.push_back(box);
    m.changed.push_back(0);
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

ObjectBoxes::Places ObjectBoxes::places() { return {impl_->objects, impl_->exact, impl_->changed}; }

void ObjectBoxes::take_changes() {
  impl_->all_changed = true;
  impl_->outdate();
}
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

/// The remaining reach of a search for near objects.
struct Reach {
  double limit;
  bool going = true;

  /// The limit for the hierarchy, which also shows boxes at the limit.
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
  const bool swapped = size() < other.size();  // the smaller set queries the larger one
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
    tree.visit_overlapping(outward(small.exact[i]), found);
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
  Reach reach{limit};
  const auto take = [&](std::uint32_t a, std::uint32_t b) {
    if (distance(m.exact[a], m.exact[b]) < reach.limit)
      reach.going = visitor.visit(m.objects[std::min(a, b)], m.objects[std::max(a, b)], reach.limit);
  };
  // If two of these touch, no data of the others' boxes are needed.
  const std::span<const std::uint32_t> neighbours = m.current_neighbours();
  const auto is_taken = [&m](std::uint32_t place) { return m.objects[place] != nullptr; };
  for (std::size_t j = 0; j < neighbours.size(); ++j)
    for (std::size_t i = j / neighbours_a_group * neighbours_a_group; i < j && reach.outward() > 0; ++i)
      if (is_taken(neighbours[i]) && is_taken(neighbours[j])) take(neighbours[i], neighbours[j]);
  if (reach.outward() <= 0) return;

  std::vector<std::uint32_t> group(neighbours.empty() ? 0 : m.objects.size(), none);
  for (std::size_t j = 0; j < neighbours.size(); ++j)
    group[neighbours[j]] = static_cast<std::uint32_t>(j / neighbours_a_group);
  const auto is_tested = [&](std::uint32_t a, std::uint32_t b) {
    return !group.empty() && group[a] != none && group[a] == group[b];
  };
  const BoxQueries& tree = m.current_tree();
  for (std::uint32_t i = 0; i < m.objects.size() && reach.outward() > 0; ++i) {
    if (m.objects[i] == nullptr) continue;
    const auto take_later = [&](std::uint32_t place) {
      if (i < place && !is_tested(i, place)) take(i, place);
    };
    ReachVisitor found(reach, take_later);
    tree.visit_near(outward(m.exact[i]), reach.outward(), found);
  }
}

void ObjectBoxes::visit_near(const ObjectBoxes& other, double limit, NearPairVisitor& visitor) const {
  const bool swapped = size() < other.size();  // the smaller set queries the larger one
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
    tree.visit_near(outward(small.exact[i]), reach.outward(), found);
  }
}

void ObjectBoxes::visit_overlapping(const ExactBox& box, BoxedObjectVisitor& visitor) const {
  Impl& m = *impl_;
  double unused = 0;
  const auto take = [&](std::uint32_t place) {
    return !overlap(m.exact[place], box) || visitor.visit(m.objects[place], m.exact[place], unused);
  };
  OverlapVisitor found(take);
  m.current_tree().visit_overlapping(outward(box), found);
}

void ObjectBoxes::visit_near(const ExactBox& box, double limit, BoxedObjectVisitor& visitor) const {
  Impl& m = *impl_;
  Reach reach{limit};
  const auto take = [&](std::uint32_t place) {
    if (distance(m.exact[place], box) < reach.limit)
      reach.going = visitor.visit(m.objects[place], m.exact[place], reach.limit);
  };
  ReachVisitor found(reach, take);
  m.current_tree().visit_near(outward(box), reach.outward(), found);
}

}  // namespace tandem::fcl
