// A user's broad phase: the boxes sorted along one axis, each tested against those that begin before it ends.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <numeric>
#include <vector>

#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"

namespace {

/// Two stages: one block that sorts, then blocks of a hundred boxes that put pairs, on any threads.
class SortAndSweep final : public tandem::BroadPhase {
 public:
  std::size_t begin(const tandem::BoxArray& boxes) override {
    boxes_ = &boxes;  // its bounds are set from stage 0 on
    order_.resize(boxes.size());
    return 2;
  }
  std::size_t blocks(std::size_t stage) const override { return stage == 0 ? 1 : (order_.size() + 99) / 100; }
  void run(std::size_t, std::size_t) override {
    std::iota(order_.begin(), order_.end(), 0u);
    const float* x = boxes_->lo(0);
    std::sort(order_.begin(), order_.end(), [x](auto i, auto k) { return x[i] != x[k] ? x[i] < x[k] : i < k; });
  }
  void emit(std::size_t block, tandem::PairSink& sink) override {
    const std::size_t end = std::min(order_.size(), 100 * (block + 1));
    for (std::size_t i = 100 * block; i < end; ++i) {
      const tandem::Aabb box = (*boxes_)[order_[i]];
      for (std::size_t k = i + 1; k < order_.size() && boxes_->lo(0)[order_[k]] <= box.hi[0]; ++k)
        if (overlap(box, (*boxes_)[order_[k]])) sink.put(order_[i], order_[k]);
    }
  }

 private:
  const tandem::BoxArray* boxes_ = nullptr;
  std::vector<std::uint32_t> order_;
};

}  // namespace

int main() {
  const tandem::Scene scene = tandem::make_builtin_scene("cubes-on-plane", 500);
  tandem::PipelineOptions options;
  options.answer = {.margin = 1, .contact_hash = true};  // so large that cubes in the air have contacts
  const tandem::StepReport usual = tandem::Pipeline(options).step(scene);
  options.own_broad_phase = [] { return std::make_unique<SortAndSweep>(); };
  tandem::Pipeline pipeline(options);
  for (int step = 0; step < 3; ++step) {
    const tandem::StepReport own = pipeline.step(scene);
    if (own.contact_hash != usual.contact_hash) std::puts("WRONG: other contacts");
    if (own.execution.candidate_pairs != usual.execution.candidate_pairs) std::puts("WRONG: other pairs");
  }
  std::printf("%zu pairs by %s, the same contacts\n", static_cast<std::size_t>(usual.execution.candidate_pairs),
              name(pipeline.step(scene).broad_phase).data());
}
