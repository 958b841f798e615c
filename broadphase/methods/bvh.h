// The broad phase `bvh`: a bounding volume hierarchy joined with itself.
#pragma once
#include <bit>

#include "methods/box_search.h"
#include "methods/listed_method.h"
#include "tandem/broadphase/broad_phase.h"
#include "trees/box_tree.h"

namespace tandem {

/// A bounding volume hierarchy over all boxes (BoxTree), built anew each step and joined with itself. Slower than the
/// grid where boxes are alike and spread evenly, but its cost depends little on the distribution of sizes and density.
class Bvh final : public ListedMethod, public BoxSearch {
 public:
  std::size_t begin(const BoxArray& boxes) override;
  std::size_t blocks(std::size_t stage) const override;
  void run(std::size_t stage, std::size_t block) override { tree_.run(stage, block); }
  void emit(std::size_t block, PairSink& sink) override { tree_.self_pairs(block, sink); }
  BroadPhaseKind kind() const override { return BroadPhaseKind::bvh; }
  std::size_t memory() const override { return tree_.memory(); }
  MethodCosts costs(std::size_t boxes) const override {
    const double box = 20 * static_cast<double>(std::bit_width(boxes));
    return {box - 60, 45, box + 20, 50};
  }
  BoxSearch* search_in() override { return this; }
  void search(const Aabb& box, std::uint32_t index, PairSink& sink) const override { tree_.query(box, index, sink); }

 private:
  BoxTree tree_;
};

}  // namespace tandem
