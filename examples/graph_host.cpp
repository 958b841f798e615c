// A host whose islands (bodies that touch, directly or through others) are joined while the narrow phase still runs:
// the answers come as a stream out of a node of its flow graph. Prints what it did; exit code 1 when the islands were
// not those of the finished list.
#include <oneapi/tbb/flow_graph.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <vector>

#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/response.h"
#include "tandem/engine/step_node.h"

namespace {

namespace flow = tbb::flow;
using tandem::Scene;
using tandem::flow::AnswerBatch;
using tandem::flow::StepAnswer;

/// Sets of bodies, joined by pairs (union-find with path halving). A set is named by its least body.
class Islands {
 public:
  explicit Islands(const Scene& scene) : is_static_(scene.is_static()), parent_(scene.indices()) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  void join(const tandem::ContactList& answers) {
    for (const tandem::PairResult& pair : answers.pairs)
      if (pair.answer.collide && !is_static_[pair.a] && !is_static_[pair.b]) join(pair.a, pair.b);
  }
  std::vector<std::uint32_t> names() {
    std::vector<std::uint32_t> out(parent_.size());
    for (std::uint32_t i = 0; i < out.size(); ++i) out[i] = find(i);
    return out;
  }

 private:
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  std::span<const std::uint8_t> is_static_;
  std::vector<std::uint32_t> parent_;
};

/// Steps a scene; islands grow with each batch, and are complete when as many have come as were sent.
class Host {
 public:
  explicit Host(Scene& scene) : scene_(scene), detection_(graph_, options(scene)), islands_(scene) {
    flow::make_edge(flow::output_port<0>(detection_), batches_);
    flow::make_edge(flow::output_port<1>(detection_), ends_);
    flow::make_edge(batches_, flow::input_port<0>(either_));
    flow::make_edge(ends_, flow::input_port<1>(either_));
    flow::make_edge(either_, join_);
  }

  const StepAnswer& step() {
    islands_ = Islands(scene_);
    joined_ = before_end_ = 0;
    end_ = {};
    flow::input_port<0>(detection_).try_put({&scene_});
    graph_.wait_for_all();
    return end_;
  }
  bool whole() const { return joined_ == end_.batches; }
  std::uint64_t before_end() const { return before_end_; }
  Islands& islands() { return islands_; }

 private:
  using Either = flow::indexer_node<AnswerBatch, StepAnswer>;

  static tandem::PipelineOptions options(const Scene& scene) {
    tandem::PipelineOptions out;
    out.answer.margin = recommended_margin(scene);
    return out;
  }
  void take(const Either::output_type& message) {
    if (message.tag() == 1) {
      end_ = flow::cast_to<StepAnswer>(message);
    } else {
      islands_.join(*flow::cast_to<AnswerBatch>(message).answers);
      ++joined_;
      before_end_ += end_.list ? 0 : 1;
    }
  }

  Scene& scene_;
  flow::graph graph_;
  tandem::flow::StepNode detection_;
  flow::queue_node<AnswerBatch> batches_{graph_};
  flow::queue_node<StepAnswer> ends_{graph_};
  Either either_{graph_};
  flow::function_node<Either::output_type> join_{graph_, flow::serial,
                                                 [this](const Either::output_type& m) { take(m); }};
  Islands islands_;
  StepAnswer end_;
  std::uint64_t joined_ = 0, before_end_ = 0;  // batches; those joined before the end of the step
};

}  // namespace

int main() {
  Scene scene = tandem::make_builtin_scene("tori-on-plane", 300);
  Host host(scene);
  tandem::Response response;
  std::uint64_t batches = 0, before_end = 0;
  for (int step = 0; step < 90; ++step) {
    const StepAnswer& end = host.step();
    Islands after(scene);
    after.join(*end.list);
    if (!host.whole() || host.islands().names() != after.names()) {
      std::printf("WRONG: other islands in step %d\n", step);
      return 1;
    }
    batches += end.batches;
    before_end += host.before_end();
    response.step(scene, *end.list);
  }
  auto names = host.islands().names();
  std::sort(names.begin(), names.end());
  const auto islands = std::unique(names.begin(), names.end()) - names.begin();
  std::printf("%td islands of %zu bodies after 90 steps; %llu of %llu batches were joined before their step was done\n",
              islands, scene.bodies(), static_cast<unsigned long long>(before_end),
              static_cast<unsigned long long>(batches));
}
