// Queries of a set of boxes by the hierarchy: overlap, rays, nearest boxes.
#include "tandem/broadphase/box_queries.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "kernels/row_kernel.h"
#include "trees/box_tree.h"

namespace tandem {
namespace {

void require(bool right, const char* what, double value, const char* allowed) {
  if (right) return;
  char text[32];
  const std::string found(text, std::to_chars(text, text + sizeof text, value).ptr);
  throw std::invalid_argument("box query: " + std::string(what) + " is " + found + ", allowed: " + allowed);
}

void run_blocks(const BlockRunner& runner, std::size_t blocks, const std::function<void(std::size_t)>& block) {
  if (runner && blocks > 1) return runner(blocks, block);
  for (std::size_t i = 0; i < blocks; ++i) block(i);
}

/// A ray prepared for slab tests (Kay and Kajiya, "Ray tracing complex scenes", 1986). Each operation of the test
/// rounds monotonically, so a ray that hits a box hits every box that contains it.
class Slabs {
 public:
  explicit Slabs(const Ray& ray) : origin_(ray.origin) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      require(std::isfinite(ray.origin[k]), "origin", ray.origin[k], "finite numbers");
      require(std::isfinite(ray.direction[k]), "direction", ray.direction[k], "finite numbers");
      largest = std::max(largest, std::abs(ray.direction[k]));
      inverse_[k] = 1 / ray.direction[k];
      across_[k] = std::isinf(inverse_[k]);
    }
    require(std::isfinite(1 / largest), "the largest component of direction", largest, "one whose inverse is finite");
    require(ray.t_max >= 0, "t_max", ray.t_max, ">= 0");
    // A box beyond the largest double is not hit: all such boxes would have the same t.
    t_max_ = std::min(ray.t_max, std::numeric_limits<double>::max());
  }

  /// The t of entry; negative if the ray misses the box.
  double enter(const Aabb& box) const {
    double from = 0, to = t_max_;
    for (std::size_t k = 0; k < 3; ++k) {
      if (across_[k]) {
        if (!(box.lo[k] <= origin_[k] && origin_[k] <= box.hi[k])) return -1;
        continue;
      }
      const double a = (box.lo[k] - origin_[k]) * inverse_[k], b = (box.hi[k] - origin_[k]) * inverse_[k];
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    return from <= to ? from : -1;
  }

 private:
  std::array<double, 3> origin_, inverse_{};
  std::array<bool, 3> across_{};
  double t_max_ = 0;
};

/// Components of points up to which the squares of distances to boxes are finite.
constexpr double farthest_point = 1e150;

double squared_distance(const std::array<double, 3>& point, const Aabb& box) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double off = std::max({box.lo[k] - point[k], point[k] - box.hi[k], 0.0});
    sum += off * off;
  }
  return sum;
}

/// Answers the queries by blocks, each into lists of its own, then joins the lists.
template <class Item, class Answer>
QueryAnswers<Item> answer_all(std::size_t queries, const BlockRunner& runner, const Answer& answer) {
  constexpr std::size_t queries_a_block = 64;
  const std::size_t blocks = (queries + queries_a_block - 1) / queries_a_block;
  std::vector<std::vector<Item>> found(blocks);
  QueryAnswers<Item> all;
  all.begin.resize(queries + 1);
  run_blocks(runner, blocks, [&](std::size_t block) {
    for (std::size_t q = block * queries_a_block, end = std::min(queries, q + queries_a_block); q < end; ++q) {
      const std::size_t before = found[block].size();
      answer(q, found[block]);
      all.begin[q + 1] = found[block].size() - before;
    }
  });
  for (std::size_t q = 0; q < queries; ++q) all.begin[q + 1] += all.begin[q];
  all.items.reserve(all.begin.back());
  for (const std::vector<Item>& some : found) all.items.insert(all.items.end(), some.begin(), some.end());
  return all;
}

}  // namespace

struct BoxQueries::Impl {
  BoxTree tree;
  std::size_t boxes = 0;
  double built_surface = 0;
};

BoxQueries::BoxQueries() : impl_(std::make_unique<Impl>()) { build({}); }
BoxQueries::~BoxQueries() = default;
BoxQueries::BoxQueries(BoxQueries&&) noexcept = default;
BoxQueries& BoxQueries::operator=(BoxQueries&&) noexcept = default;

void BoxQueries::build(const BoxArray& boxes, const BlockRunner& runner) {
  BoxTree& tree = impl_->tree;
  tree.begin(boxes, nullptr, BoxTree::Order::halves);
  for (std::size_t stage = 0; stage < BoxTree::build_stages; ++stage)
    run_blocks(runner, tree.blocks(stage), [&](std::size_t block) { tree.run(stage, block); });
  impl_->boxes = boxes.size();
  impl_->built_surface = tree.surface();
}

namespace {

template <class Boxes>
void refit_tree(BoxTree& tree, std::size_t built, const Boxes& boxes, std::span<const std::uint32_t> changed) {
  if (boxes.size() != built)
    throw std::invalid_argument("box query: refit with " + std::to_string(boxes.size()) + " boxes, built from " +
                                std::to_string(built));
  if (!tree.refit(boxes, changed))
    throw std::invalid_argument("box query: refit of a box that was empty or not there at the build");
}

}  // namespace

void BoxQueries::refit(const BoxArray& boxes, std::span<const std::uint32_t> changed) {
  refit_tree(impl_->tree, impl_->boxes, boxes, changed);
}

void BoxQueries::refit(std::span<const Aabb> boxes, std::span<const std::uint32_t> changed) {
  refit_tree(impl_->tree, impl_->boxes, boxes, changed);
}

double BoxQueries::worn() const { return impl_->built_surface > 0 ? impl_->tree.surface() / impl_->built_surface : 1; }

std::size_t BoxQueries::memory() const { return impl_->tree.memory(); }

namespace {

/// The most nodes on the stack of a depth-first traversal: at each level all children but one of a node, and there are
/// fewer than 2^32 boxes, so at most 11 levels.
constexpr std::size_t most_waiting = 12 * BoxTree::width;
/// The most boxes of the level at which a visit begins.
constexpr std::size_t first_row = 64;

/// The level at which a visit begins, the lowest that is short: the kernel compares a few dozen boxes in the time of
/// two calls.
std::size_t first_level(const BoxTree& tree) {
  std::size_t level = tree.height() - 1;
  while (level > 0 && tree.level(level - 1).size() <= first_row) --level;
  return level;
}

}  // namespace

bool BoxQueries::visit_overlapping(const Aabb& box, BoxVisitor& visitor) const {
  const BoxTree& tree = impl_->tree;
  if (tree.height() == 0) return true;
  const std::size_t level = first_level(tree);
  std::array<BoxTree::Node, first_row + most_waiting> waiting;
  std::array<std::uint32_t, first_row + BoxArray::padding> hits;
  std::size_t count = 0;
  const auto take = [&](std::size_t at, std::size_t first, std::size_t last) {
    const std::size_t found = overlap_row(tree.level(at), first, last, box, hits.data());
    for (std::size_t k = 0; k < found; ++k) {
      if (at > 0)
        waiting[count++] = {at, hits[k]};
      else if (!visitor.visit(tree.index(hits[k])))
        return false;
    }
    return true;
  };
  if (!take(level, 0, tree.level(level).size())) return false;
  while (count > 0) {
    const BoxTree::Node node = waiting[--count];
    const auto [first, last] = tree.children(node);
    if (!take(node.level - 1, first, last)) return false;
  }
  return true;
}

namespace {

/// The squares of distances and limits are rounded: the square of a limit is enlarged by more than the rounding.
constexpr double above_rounding = 1 + 4 * std::numeric_limits<double>::epsilon();

/// Finds boxes near a box: waiting nodes are opened by their distance (best first: Hjaltason and Samet, "Distance
/// browsing in spatial databases", 1999), the boxes of a lowest node are shown one after the other.
class NearSearch {
 public:
  NearSearch(const BoxTree& tree, const Aabb& box, double limit, NearVisitor& visitor)
      : tree_(tree), box_(box), visitor_(visitor) {
    set_limit(limit);
  }

  void run(std::size_t level) {
    add(level, 0, tree_.level(level).size());
    while (count_ > 0 && limit_ >= 0) {
      const std::size_t nearest = take_out_nearest();
      if (nearest == none) return;
      const BoxTree::Node node{levels_[nearest], places_[nearest]};
      const double squared = squared_[nearest];
      --count_;
      squared_[nearest] = squared_[count_], levels_[nearest] = levels_[count_], places_[nearest] = places_[count_];
      if (node.level == 0) {
        show(node.place, squared);
      } else if (node.level == 1 || count_ + BoxTree::width > most_nodes) {
        show_below(node);
      } else {
        const auto [first, last] = tree_.children(node);
        add(node.level - 1, first, last);
      }
    }
  }

 private:
  static constexpr std::size_t most_nodes = 256;
  static constexpr std::size_t none = most_nodes;

  void set_limit(double limit) {
    limit_ = limit;
    most_ = limit * limit * above_rounding;
  }

  void add(std::size_t level, std::size_t first, std::size_t last) {
    const std::size_t near =
        near_row(tree_.level(level), first, last, box_, most_, &places_[count_], &squared_[count_]);
    std::fill_n(&levels_[count_], near, static_cast<std::uint32_t>(level));
    count_ += near;
  }

  /// The place of the nearest waiting node, the first of several, or none; drops the nodes that have become too far.
  std::size_t take_out_nearest() {
    std::size_t kept = 0, nearest = none;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count_; ++i) {
      const double squared = squared_[i];
      if (squared > most_) continue;
      squared_[kept] = squared, levels_[kept] = levels_[i], places_[kept] = places_[i];
      if (squared < least) least = squared, nearest = kept;
      ++kept;
    }
    count_ = kept;
    return nearest;
  }

  void show(std::size_t place, double squared) {
    const double distance = std::sqrt(squared);
    if (distance <= limit_) set_limit(visitor_.visit(tree_.index(place), distance));
  }

  /// Shows all boxes below a node, of each node's children the nearer ones first.
  void show_below(const BoxTree::Node& node) {
    std::array<double, BoxTree::width + BoxArray::padding> squared;
    std::array<std::uint32_t, BoxTree::width + BoxArray::padding> children;
    const auto [first, last] = tree_.children(node);
    const std::size_t near =
        near_row(tree_.level(node.level - 1), first, last, box_, most_, children.data(), squared.data());
    for (std::size_t shown = 0; shown < near; ++shown) {
      for (std::size_t k = shown + 1; k < near; ++k)
        if (squared[k] < squared[shown]) {
          std::swap(squared[k], squared[shown]);
          std::swap(children[k], children[shown]);
        }
      if (limit_ < 0 || squared[shown] > most_) return;
      if (node.level == 1)
        show(children[shown], squared[shown]);
      else
        show_below({node.level - 1, children[shown]});
    }
  }

  const BoxTree& tree_;
  const Aabb& box_;
  NearVisitor& visitor_;
  double limit_ = 0, most_ = 0;  // most_: the square of the limit, rounded up
  std::size_t count_ = 0;
  // The squared distances of the waiting nodes.
  std::array<double, most_nodes + BoxArray::padding> squared_;
  std::array<std::uint32_t, most_nodes + BoxArray::padding> places_;
  std::array<std::uint32_t, most_nodes + BoxArray::padding> levels_;
};

}  // namespace

void BoxQueries::visit_near(const Aabb& box, double limit, NearVisitor& visitor) const {
  const BoxTree& tree = impl_->tree;
  if (tree.height() == 0 || !(limit >= 0)) return;
  NearSearch(tree, box, limit, visitor).run(first_level(tree));
}

void BoxQueries::overlapping(const Aabb& box, std::vector<std::uint32_t>& out) const {
  for (std::size_t k = 0; k < 3; ++k) {
    require(!std::isnan(box.lo[k]), "lo", box.lo[k], "a number");
    require(!std::isnan(box.hi[k]), "hi", box.hi[k], "a number");
    if (box.lo[k] > box.hi[k]) return;
  }
  const auto old = static_cast<std::ptrdiff_t>(out.size());
  struct List final : BoxVisitor {
    std::vector<std::uint32_t>& found;
    explicit List(std::vector<std::uint32_t>& out) : found(out) {}
    bool visit(std::uint32_t index) override {
      found.push_back(index);
      return true;
    }
  } list(out);
  visit_overlapping(box, list);
  std::sort(out.begin() + old, out.end());
}

void BoxQueries::along(const Ray& ray, std::vector<RayHit>& out) const {
  const Slabs slabs(ray);
  const auto old = static_cast<std::ptrdiff_t>(out.size());
  const BoxTree& tree = impl_->tree;
  if (tree.height() == 0) return;
  std::vector<BoxTree::Node> open{tree.root()};
  while (!open.empty()) {
    const BoxTree::Node node = open.back();
    open.pop_back();
    const double t = slabs.enter(tree.box(node));
    if (t < 0) continue;
    if (node.level == 0) {
      out.push_back({tree.index(node.place), t});
      continue;
    }
    const auto [first, last] = tree.children(node);
    for (std::size_t child = first; child < last; ++child) open.push_back({node.level - 1, child});
  }
  std::sort(out.begin() + old, out.end(),
            [](const RayHit& a, const RayHit& b) { return a.t != b.t ? a.t < b.t : a.index < b.index; });
}

// Best-first search (Hjaltason and Samet, "Distance browsing in spatial databases", 1999): the heap's nearest node or
// box is opened next, and only what is farther than the k best known is left out.
void BoxQueries::nearest(const std::array<double, 3>& point, std::size_t k, std::vector<Neighbour>& out) const {
  for (const double x : point) require(std::abs(x) <= farthest_point, "point", x, "numbers of at most 1e150 in size");
  const BoxTree& tree = impl_->tree;
  if (tree.height() == 0 || k == 0) return;
  struct Open {
    double distance;
    BoxTree::Node node;
  };
  const auto later = [](const Open& a, const Open& b) { return a.distance > b.distance; };
  const auto nearer = [](const Neighbour& a, const Neighbour& b) {
    return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.index < b.index;
  };
  std::vector<Open> open{{squared_distance(point, tree.box(tree.root())), tree.root()}};
  std::vector<Neighbour> best;  // a heap, the farthest in front
  while (!open.empty()) {
    std::pop_heap(open.begin(), open.end(), later);
    const Open next = open.back();
    open.pop_back();
    if (best.size() == k && next.distance > best.front().squared_distance) break;
    if (next.node.level == 0) {
      const Neighbour found{tree.index(next.node.place), next.distance};
      if (best.size() == k) {
        if (!nearer(found, best.front())) continue;
        std::pop_heap(best.begin(), best.end(), nearer);
        best.pop_back();
      }
      best.push_back(found);
      std::push_heap(best.begin(), best.end(), nearer);
      continue;
    }
    const auto [first, last] = tree.children(next.node);
    for (std::size_t child = first; child < last; ++child) {
      const BoxTree::Node node{next.node.level - 1, child};
      const double distance = squared_distance(point, tree.box(node));
      if (best.size() == k && distance > best.front().squared_distance) continue;
      open.push_back({distance, node});
      std::push_heap(open.begin(), open.end(), later);
    }
  }
  std::sort_heap(best.begin(), best.end(), nearer);
  out.insert(out.end(), best.begin(), best.end());
}

QueryAnswers<std::uint32_t> BoxQueries::overlapping(std::span<const Aabb> boxes, const BlockRunner& runner) const {
  return answer_all<std::uint32_t>(boxes.size(), runner, [&](std::size_t q, auto& out) { overlapping(boxes[q], out); });
}

QueryAnswers<RayHit> BoxQueries::along(std::span<const Ray> rays, const BlockRunner& runner) const {
  return answer_all<RayHit>(rays.size(), runner, [&](std::size_t q, auto& out) { along(rays[q], out); });
}

QueryAnswers<Neighbour> BoxQueries::nearest(std::span<const std::array<double, 3>> points, std::size_t k,
                                            const BlockRunner& runner) const {
  return answer_all<Neighbour>(points.size(), runner, [&](std::size_t q, auto& out) { nearest(points[q], k, out); });
}

}  // namespace tandem
