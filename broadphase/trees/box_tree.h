// A bounding volume hierarchy of boxes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"
#include "trees/spatial_sample.h"

namespace tandem {

/// A hierarchy of boxes with eight children a node, in the order of a space-filling curve (Morton 1966; Lauterbach
/// et al., "Fast BVH construction on GPUs", 2009). It has no links: node i of level k + 1 is the union of nodes
/// 8i .. 8i + 7 of level k, and level 0 is the sorted boxes, so every stage of the build cuts into independent blocks
/// and a node's children are one row for the SIMD kernel.
///
/// The order is made in two steps: a coarse grid over where the bulk of the boxes is, then each of its cells on its
/// own, with a code relative to what lies in it; runs of equal codes are refined in the same way until they are
/// small. So clusters, far outliers and sizes of any spread give a good tree, and a sorted cell depends on no other.
/// With Order::halves each run of 4096 boxes along the curve is then halved along the longest axis of its centres,
/// again and again (Lee and Lee, "OMT: overlap minimizing top-down bulk loading algorithm for R-tree", 2003): nodes are
/// more compact, for three times the time of a build.
class BoxTree {
 public:
  static constexpr std::size_t build_stages = 7;
  static constexpr std::size_t width = 8;  ///< children a node at most

  struct Range {
    std::size_t begin, end;
  };
  /// A node by its level and its place in the level; the nodes of level 0 are the boxes.
  struct Node {
    std::size_t level, place;
  };

  /// How much a build spends on the order of the boxes: little for a tree that is built for each step, more for one
  /// that answers many queries.
  enum class Order { curve, halves };

  /// Starts a build over the boxes `subset` of `boxes`, or all for nullptr. Bounds may be written until stage 0 runs.
  void begin(const BoxArray& boxes, const std::vector<std::uint32_t>* subset, Order order = Order::curve);
  std::size_t blocks(std::size_t stage) const;
  void run(std::size_t stage, std::size_t block);

  /// The number of independent blocks of the self join, which finds the pairs within the tree.
  std::size_t self_blocks() const;
  void self_pairs(std::size_t block, PairSink& sink) const;
  /// Puts the pairs of box `index`, which is not in the tree, with the boxes in it.
  void query(const Aabb& box, std::uint32_t index, PairSink& sink) const;

  /// Gives the bodies `changed` of a finished tree new boxes, which may be empty, without changing the tree's
  /// structure: it stays right, and gets slower the farther boxes move. Returns false, and changes nothing, if one of
  /// the bodies had an empty box at the build.
  bool refit(const BoxArray& boxes, std::span<const std::uint32_t> changed);
  bool refit(std::span<const Aabb> boxes, std::span<const std::uint32_t> changed);
  /// The sum of the half surface areas of the nodes just above the boxes: the cost of a query is roughly proportional
  /// to it.
  double surface() const;

  /// The number of levels of the finished tree. Its root is at level height() - 1; without boxes there are no levels.
  std::size_t height() const { return height_; }
  Node root() const { return {height_ - 1, 0}; }
  const BoxArray& level(std::size_t level) const { return levels_[level]; }
  Aabb box(const Node& node) const { return levels_[node.level][node.place]; }
  /// The children of a node above level 0, in the level below it.
  Range children(const Node& node) const { return {node.place * width, children_end(node.level, node.place)}; }
  /// The index of the body in a place of level 0.
  std::uint32_t index(std::size_t place) const { return index_[place]; }
  std::size_t memory() const;  ///< bytes held

 private:
  static constexpr std::uint32_t nowhere = 0xffffffffu;
  static constexpr std::size_t levels_a_block = 4;
  static constexpr std::size_t all_at_once = 4;  // a refit of more than 1 in 4 boxes updates all nodes
  static constexpr std::size_t boxes_a_level_block = width * width * width * width;
  struct Record {
    Aabb box;
    std::uint32_t index;
  };

  std::size_t items() const { return subset_ != nullptr ? subset_->size() : boxes_->size(); }
  std::uint32_t item(std::size_t i) const { return subset_ != nullptr ? (*subset_)[i] : static_cast<std::uint32_t>(i); }
  std::size_t children_end(std::size_t level, std::size_t node) const;
  void find_places();
  void choose_cells();
  void count_cells(std::size_t block);
  void plan();
  void scatter(std::size_t block);
  void sort_cells(std::size_t block);
  void halve_run(std::size_t first, std::size_t last);
  void raise(std::size_t level, std::size_t first, std::size_t last);
  template <class Boxes>
  bool refit_from(const Boxes& boxes, std::span<const std::uint32_t> changed);
  void pairs_from(std::size_t level, std::size_t node, std::size_t from, PairSink& sink) const;
  void cross(std::size_t level, std::size_t i, std::size_t j, PairSink& sink) const;
  void query_from(std::size_t level, std::size_t node, const Aabb& box, std::uint32_t index, PairSink& sink) const;

  const BoxArray* boxes_ = nullptr;
  const std::vector<std::uint32_t>* subset_ = nullptr;
  Order order_ = Order::curve;
  std::size_t items_a_block_ = 1;
  int cell_bits_ = 0;  // an axis
  Cube cube_;
  std::vector<std::uint32_t> offsets_;  // one a block and cell: counts, then where the block writes
  std::vector<std::uint16_t> cell_;     // the cell of each item
  std::vector<std::size_t> cell_begin_;
  std::vector<Range> group_cells_;
  std::vector<Record> records_;       // cell by cell
  std::vector<std::uint32_t> index_;  // body indices of the sorted boxes
  std::vector<std::uint32_t> place_;  // each body's place among them; made by the first refit after a build
  std::vector<std::uint32_t> moved_;  // scratch of a refit: places, then nodes
  std::vector<BoxArray> levels_;      // levels_[0] are the sorted boxes
  std::size_t height_ = 0;            // levels in use; the last has one node
};

}  // namespace tandem
