// A user's cost model: the time of a pair is estimated from the triangles of both, by a rate learnt from the steps
// before. Costly pairs begin first; the contacts are the same.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <vector>

#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/cost_model.h"
#include "tandem/engine/pipeline.h"

namespace {

class CostsByTriangles final : public tandem::CostModel {
 public:
  void begin_step(const tandem::Scene& scene) override {
    roots_.resize(scene.indices());
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      if (!scene.alive(i)) continue;
      const double triangles = static_cast<double>(scene.shape_of(i).triangles().size());
      roots_[i] = std::sqrt(1 + triangles);  // two surfaces intersect in about the square root of their triangles
    }
    // Measurements of the threads in the last step; the estimates do not change within a step.
    if (const double sum = sum_.exchange(0); sum > 0) ns_a_root_ = ns_.exchange(0) / sum;
  }
  std::chrono::nanoseconds guess(tandem::Pair pair) const override {
    return std::chrono::nanoseconds(static_cast<std::int64_t>(ns_a_root_ * size(pair)));
  }
  void took(std::span<const tandem::Pair> pairs, std::chrono::nanoseconds time) override {
    double sum = 0;
    for (const tandem::Pair pair : pairs) sum += size(pair);
    sum_.fetch_add(sum);
    ns_.fetch_add(static_cast<double>(time.count()));
  }

 private:
  double size(tandem::Pair pair) const { return roots_[pair.a] + roots_[pair.b]; }

  std::vector<double> roots_;  // one for each body
  double ns_a_root_ = 500;
  std::atomic<double> sum_{0}, ns_{0};
};

}  // namespace

int main() {
  tandem::Scene scene = tandem::make_builtin_scene("tori-on-cones", 100);
  tandem::PipelineOptions options{.threads = 2};
  options.answer.contact_hash = true;
  const std::uint64_t expected = tandem::Pipeline(options).step(scene).contact_hash;
  options.own_costs = [] { return std::make_unique<CostsByTriangles>(); };
  tandem::Pipeline pipeline(options);
  tandem::StepReport report;
  for (int step = 0; step < 10; ++step) {
    report = pipeline.step(scene);
    if (report.contact_hash != expected) std::puts("WRONG: other contacts");
  }
  std::printf("%llu pairs in %zu batches, the same contacts\n",
              static_cast<unsigned long long>(report.execution.candidate_pairs),
              static_cast<std::size_t>(report.execution.batches));
}
