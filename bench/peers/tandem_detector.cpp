// tandem as a contestant of the bench of whole steps.
#include <algorithm>

#include "scene_detector.h"
#include "tandem/engine/pipeline.h"

namespace tandem::bench {
namespace {

class TandemDetector final : public SceneDetector {
 public:
  TandemDetector(int threads, double keep_contacts)
      : pipeline_({.executor = threads == 1 ? ExecutorKind::sequential : ExecutorKind::flowgraph,
                   .threads = threads,
                   .answer = {.keep_contacts = keep_contacts}}) {}

  std::string name() const override {
    return pipeline_.options().answer.keep_contacts == 0 ? "tandem" : "tandem, kept 1e-3";
  }
  int threads() const override { return pipeline_.options().threads; }
  void detect(const Scene& scene) override { report_ = pipeline_.step(scene); }
  double kept_pairs() const override { return static_cast<double>(report_.kept_pairs); }

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

  std::uint64_t list_hash() const override { return hash(pipeline_.contacts()); }

 private:
  Pipeline pipeline_;
  StepReport report_;
};

}  // namespace

SceneDetectors tandem_detectors(const std::vector<int>& threads) {
  SceneDetectors out;
  for (const double keep_contacts : {0.0, 1e-3})
    for (const int count : threads) out.push_back(std::make_unique<TandemDetector>(count, keep_contacts));
  return out;
}

}  // namespace tandem::bench
