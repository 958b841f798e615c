// The broad phase by a uniform grid of columns.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kept_candidates/early_slab.h"
#include "kept_candidates/joint_stages.h"
#include "kernels/column_pairs.h"
#include "methods/box_search.h"
#include "methods/listed_method.h"
#include "storage/memory.h"
#include "storage/page_vector.h"
#include "tandem/broadphase/broad_phase.h"
#include "tandem/broadphase/scratch_pool.h"
#include "trees/box_tree.h"

namespace tandem {

/// A uniform grid of columns. Each box is entered in every column that it touches by one counting sort; a column is
/// then sorted into thin cells along its axis, so that the candidates of an entry are one contiguous row for the SIMD
/// kernel. The width of a column is the cheapest by a cost estimate from a sample of the boxes.
///
/// Boxes for which a uniform grid is unfit are handled separately: those that touch many columns are tested against all
/// others, one by one while they are few, by a BoxTree when they are many; far outliers fall into the columns at the
/// border, which only become slower; and if a few columns would hold too many boxes (tight clusters in an empty world)
/// the step is left to the tree. Memory is at most `max_columns_a_box` entries a box.
///
/// A step has two stages: what comes between the choice of columns and the pairs is done within the last one, while its
/// first block hands on the early pairs (EarlySlab).
class Grid final : public ListedMethod, public BoxSearch {
 public:
  std::size_t begin(const BoxArray& boxes) override;
  std::size_t blocks(std::size_t stage) const override;
  void run(std::size_t stage, std::size_t block) override;
  void emit(std::size_t block, PairSink& sink) override;
  BroadPhaseKind kind() const override { return BroadPhaseKind::grid; }
  std::size_t memory() const override;
  MethodCosts costs(std::size_t) const override { return {45, 15, 100, 16}; }
  BoxSearch* search_in() override { return this; }
  void prepare_search() override { searched_ = true; }
  void search(const Aabb& box, std::uint32_t index, PairSink& sink) const override;
  void prefetch(const Aabb& box, Fetch fetch) const override;
  bool emit_tiles(std::size_t block, TileMaker& maker) override;

  /// Boxes of the last complete step for which a grid is unfit; zero before the first step.
  struct Unfit {
    bool crowded = false;            ///< columns held too much: the tree did everything
    std::size_t longest_column = 0;  ///< entries
    std::size_t large = 0;           ///< boxes that touch many columns
  };
  Unfit unfit() const { return {crowded_, longest_column_, large_.size()}; }

 private:
  static constexpr std::size_t first_tree_stage = 3;  // of the joint ones
  static constexpr std::size_t joint_stages = first_tree_stage + BoxTree::build_stages;
  static constexpr std::size_t boxes_a_tile = 384;
  static constexpr std::uint32_t max_columns_a_box = 16;

  /// The thin cells of a column in whose order its records are.
  struct Thin {
    Slices cells;
    std::uint32_t longest = 0;   // see Column
    std::size_t first_cell = 0;  // in cell_end_
  };
  struct Touched {
    std::uint32_t u0, u1, v0, v1;
    std::uint32_t count() const { return (u1 - u0 + 1) * (v1 - v0 + 1); }
  };
  /// The columns that consecutive boxes touch. Computed wherever they are needed: stored, they would take eight bytes a
  /// box.
  struct TouchedRows {
    static constexpr std::size_t most = 64;
    std::array<std::array<std::uint16_t, most + BoxArray::padding>, 4> slices;  // u0, u1, v0, v1

    Touched operator[](std::size_t k) const { return {slices[0][k], slices[1][k], slices[2][k], slices[3][k]}; }
  };
  struct Range {
    std::size_t begin, end;
  };
  enum class Role : std::uint8_t { entered, large, empty };

  void choose_columns();
  void count(std::size_t block);
  void plan();
  void scatter(std::size_t block);
  Touched touched(const Aabb& box) const;
  /// Computes the columns of boxes [first, first + count), at most TouchedRows::most.
  void find_touched(std::size_t first, std::size_t count, TouchedRows& rows) const;
  /// Runs the stages before the pairs together with other threads; false if one of them failed.
  bool prepare();
  std::size_t joint_blocks(std::size_t stage) const;
  void run_joint(std::size_t stage, std::size_t block);
  /// The range of parts whose pairs a block of the last stage emits.
  Range tile(std::size_t block) const;
  std::size_t large_blocks() const;
  void emit_group(std::size_t group, PairSink& sink);
  bool may_hold_early(std::size_t column) const;
  /// The pairs of boxes that are not in columns.
  void emit_beside(std::size_t part, PairSink& sink) const;
  /// Sorts the entries of the column; false if there can be no pair.
  bool sort(std::size_t column, ColumnScratch& scratch);
  void keep_sorted(std::size_t column, const Column& sorted);
  void emit_large(std::size_t block, PairSink& sink) const;
  std::size_t columns() const { return std::size_t{u_.count} * v_.count; }
  bool use_tree() const { return crowded_ || large_.size() > max_large_by_row; }

  // A large box costs a row test of all boxes, the tree costs each box a query; estimated, not measured, to break even.
  static constexpr std::size_t max_large_by_row = 64;
  static constexpr std::size_t boxes_a_large_block = 8192;

  const BoxArray* boxes_ = nullptr;
  std::size_t size_ = 0;
  std::size_t boxes_a_block_ = 1, parts_ = 0;
  std::size_t along_ = 0;  // the axis of the columns
  Slices u_, v_;           // the two others
  double overlap_along_ = 1;
  bool crowded_ = false;
  std::size_t longest_column_ = 0;
  std::vector<std::uint32_t> offsets_;  // one a part and column: counts, then where the part writes
  std::vector<std::vector<std::uint32_t>> large_of_part_;
  std::vector<Role> role_;  // one a box
  std::vector<std::uint32_t> large_;
  std::vector<std::size_t> column_begin_;
  std::vector<Range> groups_;  // of columns: the blocks of the last stage
  PageVector<ColumnRecord> records_;
  bool searched_ = false;
  std::vector<Thin> thin_;  // one a column, when searched
  std::vector<std::uint32_t> cell_end_;
  BoxTree tree_;
  detail::ScratchPool<ColumnScratch> scratch_;
  JointStages joint_;
  EarlySlab early_;
};

}  // namespace tandem
