// The execution report of a step.
#pragma once
#include <cstdint>
#include <string_view>

#include "tandem/flowgraph/options.h"

namespace tandem {

/// The balancer's action after a step.
enum class BalanceAction : std::uint8_t {
  none,     ///< between two control steps, or the split is fixed
  keep,     ///< measured and changed nothing
  change,   ///< moved threads; the next control step verifies it
  confirm,  ///< the change made it faster and stays
  revert,   ///< the change did not make it faster and was taken back
};
std::string_view name(BalanceAction action);

/// One decision with the times behind it (ms).
struct BalanceDecision {
  std::uint64_t step = 0;
  BalanceAction action = BalanceAction::none;
  Split before, after;
  int control_step = 0;  ///< steps until the next measurement
  /// The times that the rule compared: computing time a thread of the phase (paper), busy times (busy)
  double broad_ms = 0;
  double narrow_ms = 0;
  /// The cost that verification compares: detect time (paper) or detect time per unit of work (busy)
  double measure = 0;
  double measure_before = 0;  ///< the cost before the change, when a change is being verified
  std::string_view reason;
};

/// Bits that tell what a step could not do as asked.
enum class StepIssue : std::uint32_t {
  none = 0,
  inexact = 1u << 0,        ///< the tolerance was not reached for some pair: see PairAnswer::error_bound
  pool_grew = 1u << 1,      ///< the batch pool had to grow (once in a while is fine)
  ran_on_caller = 1u << 2,  ///< too little work to share: the step stayed on the calling thread
  ended_early = 1u << 3,    ///< stopped or cancelled: the answer is empty
  incomplete = 1u << 4      ///< the deadline passed: the answer has what was finished, pair by pair
};
constexpr std::uint32_t bit(StepIssue issue) { return static_cast<std::uint32_t>(issue); }

/// Serial time (ms, wall) by phase: what one thread did while no other could, which is opening stages and running
/// stages of a single block.
struct SerialTimes {
  double begin = 0;   ///< before the first stage
  double update = 0;  ///< poses to boxes
  double broad = 0;   ///< the broad phase's preparation
  double join = 0;    ///< putting pairs and answers in order
  double sum() const { return begin + update + broad + join; }
};

/// Measurements of one step (ms; busy times are summed over threads, waiting excluded).
struct ExecutionReport {
  std::uint64_t candidate_pairs = 0;
  std::uint64_t heavy_pairs = 0;  ///< candidates that were in batches of heavy pairs
  std::uint64_t batches = 0;
  std::uint64_t queue_high_water = 0;  ///< most batches that waited at once
  double update_ms = 0;                ///< wall: poses to boxes
  double broad_ms = 0;                 ///< busy: the broad phase's stages
  double narrow_ms = 0;                ///< busy: the narrow phase
  double heavy_ms = 0;                 ///< busy: the heavy pairs of the narrow phase
  double broad_end_ms = 0;             ///< wall, from the start of the shared phase to the last broad block
  double narrow_end_ms = 0;            ///< wall, to the last narrow batch
  double join_ms = 0;                  ///< wall: putting the results in order
  double detect_ms = 0;                ///< wall, all of the above
  double busy_ms = 0;                  ///< busy: all of the above
  /// Time that workers stayed awake (stay_awake), summed, from the step before to this one
  double awake_ms = 0;
  SerialTimes serial;                  ///< serial part of the step; 0 on the caller alone, where nothing is shared
  int threads = 1;                     ///< threads in all, the caller counted
  Split split;                         ///< split in force in this step; 1-0 when one thread did both phases
  StepForm form = StepForm::caller;    ///< the form in which the step was run
  std::uint32_t issues = 0;            ///< StepIssue bits
  BalanceDecision decision;            ///< taken after this step
};

}  // namespace tandem
