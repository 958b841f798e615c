// A user's balancing rule: moves threads according to a smoothed ratio of the busy times.
#include <cmath>
#include <cstdio>

#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/flowgraph/report.h"

namespace {

/// The broad phase's fraction of the work, smoothed over some ten steps, times the threads.
class SmoothedShare {
 public:
  int operator()(const tandem::ExecutionReport& report) {
    const double work = report.broad_ms + report.narrow_ms;
    if (work > 0) share_ += 0.1 * (report.broad_ms / work - share_);
    return static_cast<int>(std::lround(share_ * report.threads));
  }

 private:
  double share_ = 0.5;
};

}  // namespace

int main() {
  tandem::Scene scene = tandem::make_builtin_scene("tori-on-plane", 100);
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (scene.is_static()[i]) continue;
    tandem::Pose pose = scene.poses()[i];
    pose.translation *= 0.5;  // so near that they touch, and the narrow phase has most of the work
    scene.set_pose(scene.id(i), pose);
  }
  tandem::PipelineOptions options{.executor = tandem::ExecutorKind::threads, .threads = 4};
  options.sharing = {.form = tandem::StepForm::overlapped, .short_step_ms = 0};
  options.answer.contact_hash = true;
  const std::uint64_t expected = tandem::Pipeline(options).step(scene).contact_hash;
  options.balance.own_rule = SmoothedShare{};
  tandem::Pipeline pipeline(options);
  int changes = 0;
  for (int step = 0; step < 40; ++step) {
    const tandem::StepReport report = pipeline.step(scene);
    if (report.contact_hash != expected) std::puts("WRONG: other contacts");
    const tandem::BalanceDecision& decision = report.execution.decision;
    if (decision.action != tandem::BalanceAction::change) continue;
    ++changes;
    std::printf("step %d: %d-%d, %s\n", step, decision.after.broad, decision.after.narrow, decision.reason.data());
  }
  std::printf("%d changes, the same contacts\n", changes);
}
