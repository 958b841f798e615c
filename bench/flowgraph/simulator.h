// A simulator of executors: replays measured block times on virtual cores.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

#include "flowgraph/executors/batch_queue.h"  // what the executors keep from step to step
#include "flowgraph/step/batch_size.h"
#include "flowgraph/step/step_form.h"
#include "measurement/balancer.h"
#include "tandem/flowgraph/measured_step.h"

namespace tandem::bench {

/// The costs of this machine's threads and queues (ns), measured.
struct MachineCosts {
  double task = 0;       ///< taking and timing a block, tile or batch
  double message = 0;    ///< putting a batch into the queue and taking it out
  double wake = 0;       ///< from the start of a step to a sleeping worker's first instruction
  double resize = 0;     ///< making both arenas anew, on the caller
  double move = 0;       ///< from a new arena to the first task of a worker that was in the old one
  double hand_over = 0;  ///< from the end of a stage, or a batch in the queue, to a thread that spins for it
  double sharing = 1;    ///< factor for data that another core wrote before or will read, >= 1
  double slowdown = 1;   ///< factor for a thread while all others work, too (shared caches, memory, clock), >= 1
};

enum class Policy : std::uint8_t { sequential, barrier, fused, strict, conserving };

/// The times of a step on virtual cores.
struct SimulatedStep {
  double ns = 0;
  double broad_ns = 0, narrow_ns = 0;  ///< busy, summed over threads
  Split split;
  StepForm form = StepForm::caller;
};

/// Runs recorded steps on P virtual cores: an event simulation of the executors' rules in which every tile and batch
/// costs what it cost when it was recorded. Keeps the state that the executor keeps from step to step: the balance, the
/// size of batches and the form of the steps.
class Simulator {
 public:
  /// `fixed` dynamic: balanced by `rule`. threads >= 2 except for Policy::sequential. `wanted`: as in PipelineOptions;
  /// Policy::strict always overlaps, Policy::fused never sorts pairs first.
  Simulator(Policy policy, int threads, Split fixed, BalanceRule rule, const MachineCosts& costs,
            StepForm wanted = StepForm::automatic);
  SimulatedStep step(const MeasuredForms& forms);
  const BalanceDecision& decision() const { return decision_; }

 private:
  struct Thread;
  class Shared;

  struct OrderedBatch {
    double ns = 0;
    std::uint64_t pairs = 0;
    bool heavy = false;
  };
  static constexpr double small_step_ms = 0.3;

  double stage(const MeasuredStep::Stage& stage, const std::vector<Thread>& threads, double from,
               bool narrow_helps) const;
  std::vector<OrderedBatch> ordered_batches(const MeasuredStep& work) const;
  double ordered_phase(const MeasuredStep& work, const std::vector<Thread>& threads, double now, SimulatedStep& result,
                       ExecutionReport& report) const;

  Policy policy_;
  int threads_;
  MachineCosts costs_;
  Balancer balancer_;
  BatchSize batch_size_{128};
  FormChooser form_;
  Split before_;
  double costliest_ns_ = 0;  // of the pairs of the step before
  std::uint64_t step_ = 0;
  BalanceDecision decision_;
};

}  // namespace tandem::bench
