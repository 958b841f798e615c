// A host with its own oneTBB graph: collision detection as nodes of this graph, in its arena, within its limits, beside
// its other work, cancelled with its tasks. Prints what it did; exit code 1 if an answer differs from that of a plain
// sequential step.
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <tuple>
#include <vector>

#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"

namespace {

namespace flow = tbb::flow;
using tandem::Pipeline;
using tandem::Scene;
using tandem::StepReport;

using Message = const Scene*;

tandem::PipelineOptions options(int threads) { return {.threads = threads, .answer = {.contact_hash = true}}; }

/// A node that takes a scene and returns a report: for the host's graph a single node, which may become several inside.
class DetectionNode : public flow::composite_node<std::tuple<Message>, std::tuple<StepReport>> {
 public:
  DetectionNode(flow::graph& graph, tandem::PipelineOptions options)
      : composite_node(graph),
        pipeline_(std::move(options)),
        step_(graph, flow::serial, [this](Message scene) { return pipeline_.step(*scene); }) {
    set_external_ports(input_ports_type(step_), output_ports_type(step_));
  }

 private:
  Pipeline pipeline_;
  flow::function_node<Message, StepReport> step_;  // serial: a pipeline does one step at a time
};

/// The same, but the step runs in an arena beside the graph's; the graph's threads do not wait for it.
class BackgroundDetection {
 public:
  using Node = flow::async_node<Message, StepReport>;

  BackgroundDetection(flow::graph& graph, tandem::PipelineOptions options)
      : pipeline_(std::move(options)), node_(graph, flow::serial, [this](Message scene, Node::gateway_type& gateway) {
          gateway.reserve_wait();  // the graph is not done before the answer arrives
          arena_.enqueue([this, scene, &gateway] {
            gateway.try_put(pipeline_.step(*scene));
            gateway.release_wait();
          });
        }) {}
  Node& node() { return node_; }

 private:
  tbb::task_arena arena_{2};
  Pipeline pipeline_;
  Node node_;
};

/// The host's own work: the sum of all bodies' distances from the origin.
double other_work(const Scene& scene) {
  double sum = 0;
  for (const tandem::Pose& pose : scene.poses()) sum += pose.translation.norm();
  return sum;
}

int failures = 0;

void tell(const char* what, bool right) {
  std::printf("%-62s %s\n", what, right ? "right" : "WRONG");
  failures += right ? 0 : 1;
}

}  // namespace

int main() {
  const Scene scene = tandem::make_builtin_scene("cubes-on-plane", 400);
  auto plain = options(1);
  plain.executor = tandem::ExecutorKind::sequential;
  const std::uint64_t expected = Pipeline(plain).step(scene).contact_hash;
  const auto is_right = [&](const StepReport& report) { return report.contact_hash == expected; };

  // The host sets a limit and has an arena. Pipelines respect both.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  tbb::task_arena host_arena(3);

  host_arena.execute([&] {
    flow::graph graph;
    flow::broadcast_node<Message> start(graph);
    DetectionNode detection(graph, options(0));  // 0: as many threads as the host's arena has
    BackgroundDetection background(graph, options(2));
    std::atomic<int> reports = 0, others = 0;
    std::atomic<bool> right = true;
    int threads = 0;
    flow::function_node<StepReport> judge(graph, flow::serial, [&](const StepReport& report) {
      threads = std::max(threads, report.execution.threads);
      right = right && is_right(report);
      ++reports;
    });
    flow::function_node<Message> work(graph, flow::unlimited, [&](Message message) {
      right = right && other_work(*message) > 0;
      ++others;
    });
    flow::make_edge(start, flow::input_port<0>(detection));
    flow::make_edge(start, background.node());
    flow::make_edge(start, work);
    flow::make_edge(flow::output_port<0>(detection), judge);
    flow::make_edge(background.node(), judge);
    for (int i = 0; i < 20; ++i) start.try_put(&scene);
    graph.wait_for_all();
    tell("two pipelines at once as nodes of a graph, beside other work", right && reports == 40 && others == 20);
    tell("a pipeline takes the threads of the arena that it is called in", threads == 3);
  });

  {
    std::vector<Pipeline> pipelines;
    for (int i = 0; i < 4; ++i) pipelines.emplace_back(options(i % 3));
    std::atomic<int> right = 0;
    tbb::parallel_for(0, 4, [&](int i) {
      for (int step = 0; step < 5; ++step)
        right += is_right(pipelines[static_cast<std::size_t>(i)].step(scene)) ? 1 : 0;
    });
    tell("a pipeline in each task of a parallel loop", right == 20);
  }

  {
    tbb::task_arena outer(2), inner(2);
    Pipeline pipeline(options(2));
    bool right = false;
    outer.execute([&] { inner.execute([&] { right = is_right(pipeline.step(scene)); }); });
    tell("in an arena within an arena", right);
  }

  {
    // A step that the host cancels ends early, with an empty answer marked as such; the next step is complete again.
    tbb::task_group_context context;
    flow::graph graph(context);
    bool cancel = true;
    auto own = options(2);
    own.predicate = [&](std::span<tandem::Pair> pairs) {
      if (cancel) context.cancel_group_execution();
      return pairs.size();
    };
    Pipeline pipeline(own);
    StepReport last;
    flow::function_node<Message> node(graph, flow::serial, [&](Message message) { last = pipeline.step(*message); });
    node.try_put(&scene);
    graph.wait_for_all();
    const bool ended = (last.execution.issues & bit(tandem::StepIssue::ended_early)) != 0 && last.contacts == 0;
    cancel = false;
    graph.reset();
    node.try_put(&scene);
    graph.wait_for_all();
    tell("cancelled with the host's tasks, and whole again after that", ended && is_right(last));
  }

  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    Pipeline pipeline(options(4));
    const StepReport report = pipeline.step(scene);
    tell("under a limit of one thread", is_right(report) && report.execution.threads == 1);
  }
  return failures == 0 ? 0 : 1;
}
