// The broad phase `auto`: chooses a method for each step.
#pragma once
#include <string>

#include "methods/brute_force.h"
#include "methods/bvh.h"
#include "methods/grid.h"
#include "methods/sweep.h"
#include "methods/verlet_list.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem {

/// Picks a method for each step, by the number of boxes, then by how well the grid suited the boxes of the step before;
/// keeps the candidates as long as boxes move little or predictably (VerletList). The choice depends only on the boxes
/// of this object's steps, and the pairs do not depend on the choice.
class Automatic final : public BroadPhase {
 public:
  void expect(const PairFilter& filter) override { list_.expect(filter); }
  void expect_changes(std::span<const std::uint8_t> changed) override { list_.expect_changes(changed); }
  void expect_only_changes() override { list_.expect_only_changes(); }
  std::size_t begin(const BoxArray& boxes) override;
  std::size_t blocks(std::size_t stage) const override { return list_.blocks(stage); }
  void run(std::size_t stage, std::size_t block) override { list_.run(stage, block); }
  void emit(std::size_t block, PairSink& sink) override { list_.emit(block, sink); }
  BroadPhaseKind kind() const override { return method_->kind(); }
  std::size_t memory() const override {
    return brute_.memory() + sweep_.memory() + grid_.memory() + bvh_.memory() + list_.memory();
  }
  std::string_view reason() const override {
    return list_.mode() == VerletList::Mode::reuse ? reason_while_kept_ : reason_;
  }

 private:
  // Measured on one core with AVX2, ms a step, brute | sweep | grid | bvh, for 500, 1000 and 2000 unit boxes that
  // overlap about one other each: .041 | .030 | .050 | .048, .137 | .090 | .093 | .152, .394 | .183 | .131 | .272; for
  // a pile of them: .075 | .051 | .061 | .111, .265 | .207 | .184 | .317, .660 | .455 | .313 | .576. For more boxes the
  // grid is fastest, or level with the tree (a flat world on a ground), except in worlds that it leaves to the tree.
  // Brute force has one stage to schedule, the sweep five, the grid twelve: at similar times, few stages win.
  static constexpr std::size_t brute_below = 256;
  static constexpr std::size_t sweep_below = 1024;
  // 2000 boxes that all overlap each other: brute 7 to 8 ms, tree 11 to 12 ms; that hardly overlap: .39 and .27 ms.
  static constexpr std::size_t brute_in_crowds_below = 2048;
  // Steps with the tree before the grid is tried again. A trial costs about a tenth of a step.
  static constexpr int tree_steps = 32;

  ListedMethod& choose(std::size_t n);

  BruteForce brute_;
  Sweep sweep_;
  Grid grid_;
  Bvh bvh_;
  VerletList list_;
  ListedMethod* method_ = &brute_;
  std::string reason_, reason_while_kept_;
  std::string unfit_reason_;
  int tree_steps_left_ = 0;
  std::size_t last_size_ = 0;
};

}  // namespace tandem
