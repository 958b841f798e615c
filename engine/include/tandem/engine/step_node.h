// A step as a node of a oneTBB flow graph.
#pragma once
#include <oneapi/tbb/flow_graph.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <stop_token>
#include <tuple>
#include <utility>

#include "tandem/engine/pipeline.h"

namespace tandem::flow {

/// The request to start a step. The scene must not change until the step's StepAnswer has arrived.
struct StepRequest {
  const Scene* scene = nullptr;  ///< must not be null; else the step throws std::invalid_argument
  std::stop_token stop{};
  /// As for Pipeline::step: pairs finished by then are the answer (StepIssue::incomplete).
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// Answers of a step that is still running, in no order: messages of several threads may overtake each other, and a
/// StepAnswer may overtake them.
struct AnswerBatch {
  std::uint64_t step = 0;  ///< as StepReport::step
  std::shared_ptr<const ContactList> answers;
};

/// The end of a step: all answers in canonical order, and the report.
struct StepAnswer {
  StepReport report;
  std::shared_ptr<const ContactList> list;
  /// Number of AnswerBatch messages of the step: by counting them a receiver knows when all have arrived.
  std::uint64_t batches = 0;
};

/// Collision detection as a node of a host's oneTBB flow graph: takes a StepRequest; emits batches of answers at port 0
/// while others are still being computed, and the step's end at port 1. A node runs one step at a time; several nodes
/// of one graph run concurrently. The step uses the threads of the graph's arena. A step cancelled by the graph ends
/// early (StepIssue::ended_early); an exception cancels the graph and leaves wait_for_all, as for any node. Programs
/// that use it link TBB::tbb.
class StepNode : public tbb::flow::composite_node<std::tuple<StepRequest>, std::tuple<AnswerBatch, StepAnswer>> {
  using Base = tbb::flow::composite_node<std::tuple<StepRequest>, std::tuple<AnswerBatch, StepAnswer>>;

 public:
  /// Throws what Pipeline's constructor throws. A listener of the host is called, too.
  StepNode(tbb::flow::graph& graph, PipelineOptions options)
      : Base(graph),
        listener_(std::move(options.on_answers)),
        pipeline_(listening(std::move(options))),
        step_(graph, tbb::flow::serial,
              [this](const StepRequest& request, Step::output_ports_type&) { run(request); }) {
    Base::set_external_ports(Base::input_ports_type(step_), Base::output_ports_type(tbb::flow::output_port<0>(step_),
                                                                                    tbb::flow::output_port<1>(step_)));
  }

 private:
  using Step = tbb::flow::multifunction_node<StepRequest, std::tuple<AnswerBatch, StepAnswer>>;

  PipelineOptions listening(PipelineOptions options) {
    options.on_answers = [this](std::span<const PairResult> pairs, std::span<const Contact> contacts) {
      send(pairs, contacts);
    };
    return options;
  }

  void run(const StepRequest& request) {
    batches_ = 0;
    if (request.scene == nullptr) throw std::invalid_argument("StepRequest: scene is null, allowed: a scene");
    const StepReport report = pipeline_.step(*request.scene, request.stop, request.deadline);
    number_ = report.step + 1;
    tbb::flow::output_port<1>(step_).try_put(
        {report, std::make_shared<const ContactList>(pipeline_.contacts()), batches_});
  }

  void send(std::span<const PairResult> pairs, std::span<const Contact> contacts) {
    if (listener_) listener_(pairs, contacts);
    auto copy = std::make_shared<ContactList>();
    copy->pairs.assign(pairs.begin(), pairs.end());
    for (PairResult& pair : copy->pairs) {
      const auto own = contacts.subspan(pair.first_contact, pair.contact_count);
      pair.first_contact = static_cast<std::uint32_t>(copy->contacts.size());
      copy->contacts.insert(copy->contacts.end(), own.begin(), own.end());
    }
    ++batches_;
    tbb::flow::output_port<0>(step_).try_put({number_, std::move(copy)});
  }

  AnswerListener listener_;
  Pipeline pipeline_;
  Step step_;
  std::atomic<std::uint64_t> batches_{0};
  std::uint64_t number_ = 0;  // of the running step
};

}  // namespace tandem::flow
