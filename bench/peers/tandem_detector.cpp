#include <algorithm>

#include "scene_detector.h"
#include "tandem/engine/pipeline.h"

namespace tandem::bench {
namespace {

class TandemDetector final : public SceneDetector {
 public:
  explicit TandemDetector(int threads)
      : pipeline_({.executor = threads == 1 ? ExecutorKind::sequential : ExecutorKind::flowgraph, .threads = threads}) {
  }

  std::string name() const override { return "tandem"; }
  int threads() const override { return pipeline_.options().threads; }
  void detect(const Scene& scene) override { pipeline_.step(scene); }

  std::vector<TouchingPair> found() const override {
    std::vector<TouchingPair> out;
    for (const PairResult& pair : pipeline_.contacts().pairs) {
      if (!pair.answer.collide) continue;
      double depth = 0;
      for (const Contact& contact : pipeline_.contacts().of(pair)) depth = std::max(depth, contact.depth);
      out.push_back({pair.a, pair.b, pair.contact_count, depth});
    }
    return out;
  }

 private:
  Pipeline pipeline_;
};

}  // namespace

SceneDetectors tandem_detectors(const std::vector<int>& threads) {
  SceneDetectors out;
  for (const int count : threads) out.push_back(std::make_unique<TandemDetector>(count));
  return out;
}

}  // namespace tandem::bench
