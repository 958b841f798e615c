// A step as a node of a flow graph, with a stream of batches.
#include "tandem/engine/step_node.h"

#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>

#include "catch.h"
#include "settled_scene.h"
#include "tandem/engine/response.h"

using namespace tandem;

namespace {

// The collected batches, and the list that they must equal.
struct Gathered {
  std::mutex mutex;
  std::vector<ContactList> batches;

  AnswerListener listener() {
    return [this](std::span<const PairResult> pairs, std::span<const Contact> contacts) {
      ContactList copy{{pairs.begin(), pairs.end()}, {contacts.begin(), contacts.end()}};
      const std::lock_guard lock(mutex);
      batches.push_back(std::move(copy));
    };
  }
  ContactList sorted() const {
    std::vector<std::pair<const ContactList*, const PairResult*>> all;
    for (const ContactList& batch : batches)
      for (const PairResult& pair : batch.pairs) all.emplace_back(&batch, &pair);
    std::sort(all.begin(), all.end(), [](const auto& x, const auto& y) {
      return std::pair(x.second->a, x.second->b) < std::pair(y.second->a, y.second->b);
    });
    ContactList out;
    for (const auto& [batch, pair] : all) {
      PairResult copy = *pair;
      copy.first_contact = static_cast<std::uint32_t>(out.contacts.size());
      for (const Contact& contact : batch->of(*pair)) out.contacts.push_back(contact);
      out.pairs.push_back(copy);
    }
    return out;
  }
};

}  // namespace

TEST_CASE("step node: a listener hears every answer of the list once, with any executor and request") {
  for (const auto* name : {"tori-and-cubes", "spheres-on-plane"}) {
    const Scene scene = test::settled_scene(name, 200, 40);
    for (const ExecutorKind executor : executor_kinds)
      for (const Request request : {Request::collide, Request::distance, Request::contacts}) {
        Gathered gathered;
        Pipeline pipeline({.executor = executor,
                           .threads = 3,
                           .answer = {.request = request, .margin = 0.01},
                           .on_answers = gathered.listener()});
        for (int step = 0; step < 3; ++step) {
          gathered.batches.clear();
          pipeline.step(scene);
          REQUIRE(!pipeline.contacts().pairs.empty());
          REQUIRE(hash(gathered.sorted()) == hash(pipeline.contacts()));
        }
      }
  }
}

TEST_CASE("step node: of kept contacts a listener hears those that were computed") {
  Scene scene = test::settled_scene("cubes-on-plane", 100, 60);
  Gathered gathered;
  Pipeline pipeline({.answer = {.margin = 0.01, .keep_contacts = 1e-3}, .on_answers = gathered.listener()});
  pipeline.step(scene);
  CHECK(gathered.sorted().pairs.size() == pipeline.contacts().pairs.size());
  for (int step = 0; step < 3; ++step) {
    gathered.batches.clear();
    pipeline.step(scene);
  }
  CHECK(gathered.sorted().pairs.size() < pipeline.contacts().pairs.size());
}

TEST_CASE("step node: several in one graph send batches that make up their lists") {
  const Scene scene = test::settled_scene("tori-and-cubes", 150, 40);
  Pipeline plain({.executor = ExecutorKind::sequential, .threads = 1});
  plain.step(scene);
  const std::uint64_t expected = hash(plain.contacts());

  tbb::flow::graph graph;
  std::vector<std::unique_ptr<flow::StepNode>> nodes;
  std::vector<std::unique_ptr<tbb::flow::function_node<flow::AnswerBatch>>> takers;
  std::vector<std::unique_ptr<tbb::flow::function_node<flow::StepAnswer>>> ends;
  std::atomic<std::uint64_t> batches = 0, pairs = 0, told = 0;
  std::atomic<int> right = 0;
  for (int i = 0; i < 3; ++i) {
    nodes.push_back(std::make_unique<flow::StepNode>(graph, PipelineOptions{.threads = i}));
    takers.push_back(std::make_unique<tbb::flow::function_node<flow::AnswerBatch>>(
        graph, tbb::flow::unlimited, [&](const flow::AnswerBatch& batch) {
          ++batches;
          pairs += batch.answers->pairs.size();
        }));
    ends.push_back(std::make_unique<tbb::flow::function_node<flow::StepAnswer>>(
        graph, tbb::flow::serial, [&](const flow::StepAnswer& end) {
          told += end.batches;
          right += hash(*end.list) == expected && end.report.colliding_pairs > 0;
        }));
    tbb::flow::make_edge(tbb::flow::output_port<0>(*nodes.back()), *takers.back());
    tbb::flow::make_edge(tbb::flow::output_port<1>(*nodes.back()), *ends.back());
  }
  for (int step = 0; step < 5; ++step)
    for (auto& node : nodes) tbb::flow::input_port<0>(*node).try_put({&scene});
  graph.wait_for_all();
  CHECK(right == 15);
  CHECK(batches == told);
  CHECK(pairs == 15 * plain.contacts().pairs.size());
}

TEST_CASE("step node: what a listener throws leaves wait_for_all, and the next step is whole") {
  const Scene scene = test::settled_scene("cubes-on-plane", 150, 60);
  std::atomic<bool> throws = true;
  PipelineOptions options;
  options.on_answers = [&](std::span<const PairResult>, std::span<const Contact>) {
    if (throws) throw std::runtime_error("enough");
  };
  tbb::flow::graph graph;
  flow::StepNode node(graph, options);
  std::uint64_t contacts = 0;
  tbb::flow::function_node<flow::StepAnswer> end(graph, tbb::flow::serial,
                                                 [&](const flow::StepAnswer& s) { contacts = s.report.contacts; });
  tbb::flow::make_edge(tbb::flow::output_port<1>(node), end);
  tbb::flow::input_port<0>(node).try_put({&scene});
  CHECK_THROWS_WITH(graph.wait_for_all(), "enough");
  CHECK(contacts == 0);
  throws = false;
  graph.reset();
  tbb::flow::input_port<0>(node).try_put({&scene});
  graph.wait_for_all();
  CHECK(contacts > 0);
}

TEST_CASE("step node: a stop request ends the step with an empty list") {
  const Scene scene = test::settled_scene("cubes-on-plane", 100, 60);
  tbb::flow::graph graph;
  flow::StepNode node(graph, {});
  bool ended = false;
  tbb::flow::function_node<flow::StepAnswer> end(graph, tbb::flow::serial, [&](const flow::StepAnswer& s) {
    ended = (s.report.execution.issues & bit(StepIssue::ended_early)) != 0 && s.list->pairs.empty();
  });
  tbb::flow::make_edge(tbb::flow::output_port<1>(node), end);
  std::stop_source stop;
  stop.request_stop();
  tbb::flow::input_port<0>(node).try_put({&scene, stop.get_token()});
  graph.wait_for_all();
  CHECK(ended);
}

TEST_CASE("step node: a deadline that has passed leaves a marked list, and the next step is whole") {
  const Scene scene = test::settled_scene("cubes-on-plane", 100, 60);
  tbb::flow::graph graph;
  flow::StepNode node(graph, {});
  std::vector<bool> incomplete;
  std::vector<std::uint64_t> contacts;
  tbb::flow::function_node<flow::StepAnswer> end(graph, tbb::flow::serial, [&](const flow::StepAnswer& s) {
    incomplete.push_back((s.report.execution.issues & bit(StepIssue::incomplete)) != 0);
    contacts.push_back(s.report.contacts);
  });
  tbb::flow::make_edge(tbb::flow::output_port<1>(node), end);
  for (const bool late : {true, false}) {
    flow::StepRequest request{&scene};
    if (late) request.deadline = std::chrono::steady_clock::now();
    tbb::flow::input_port<0>(node).try_put(request);
    graph.wait_for_all();
  }
  REQUIRE(incomplete.size() == 2);
  CHECK(incomplete[0]);
  CHECK(contacts[0] == 0);
  CHECK(!incomplete[1]);
  CHECK(contacts[1] > 0);
}
