// Makes the built-in methods; all pairs of a method on the calling thread.
#include "tandem/broadphase/broad_phase.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "methods/automatic.h"
#include "methods/brute_force.h"
#include "methods/bvh.h"
#include "methods/grid.h"
#include "methods/sweep.h"

namespace tandem {

std::string_view name(BroadPhaseKind kind) {
  constexpr std::array<std::string_view, 6> names{"brute", "sweep", "grid", "bvh", "auto", "own"};
  return names[static_cast<std::size_t>(kind)];
}

std::unique_ptr<BroadPhase> make_broad_phase(BroadPhaseKind kind) {
  switch (kind) {
    case BroadPhaseKind::brute:
      return std::make_unique<BruteForce>();
    case BroadPhaseKind::sweep:
      return std::make_unique<Sweep>();
    case BroadPhaseKind::grid:
      return std::make_unique<Grid>();
    case BroadPhaseKind::bvh:
      return std::make_unique<Bvh>();
    case BroadPhaseKind::automatic:
      return std::make_unique<Automatic>();
    default:
      throw std::invalid_argument("broad phase: no such kind");
  }
}

namespace {

class CollectingSink final : public PairSink {
 public:
  explicit CollectingSink(const PairFilter& filter) : room_(1024) {
    filter_ = &filter;
    buffer_ = room_.data();
    capacity_ = room_.size();
  }
  std::vector<Pair> take() {
    room_.resize(count_);
    return std::move(room_);
  }

 private:
  void full() override {
    room_.resize(2 * room_.size());
    buffer_ = room_.data();
    capacity_ = room_.size();
  }
  std::vector<Pair> room_;
};

}  // namespace

std::vector<Pair> find_pairs(BroadPhase& method, const BoxArray& boxes, const PairFilter& filter) {
  CollectingSink sink(filter);
  method.expect(filter);
  const std::size_t stages = method.begin(boxes);
  for (std::size_t stage = 0; stage + 1 < stages; ++stage)
    for (std::size_t block = 0; block < method.blocks(stage); ++block) method.run(stage, block);
  for (std::size_t block = 0; block < method.blocks(stages - 1); ++block) method.emit(block, sink);
  std::vector<Pair> pairs = sink.take();
  method.expect({});  // the arrays of the filter may be destroyed after this call
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace tandem
