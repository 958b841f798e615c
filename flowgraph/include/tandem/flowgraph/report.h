#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tandem {

/// Ways to run the same step; one answer.
enum class ExecutorKind : std::uint8_t {
  sequential,  ///< broad, then narrow, on the calling thread
  barrier,     ///< both phases parallel with oneTBB, the broad one ends before the narrow one begins
  fused,       ///< parallel with oneTBB over tiles of the broad phase, each of which narrows its own pairs at once
  threads,     ///< the paper's design on std::thread alone
  flowgraph,   ///< the two phases as graphs in two arenas, a bounded queue between, balanced
};
inline constexpr ExecutorKind executor_kinds[] = {ExecutorKind::sequential, ExecutorKind::barrier, ExecutorKind::fused,
                                                  ExecutorKind::threads, ExecutorKind::flowgraph};
std::string_view name(ExecutorKind kind);

/// Threads for the broad and the narrow phase; both 0 means "dynamic".
struct Split {
  int broad = 0;
  int narrow = 0;
  bool dynamic() const { return broad == 0 && narrow == 0; }
  friend bool operator==(Split, Split) = default;
};

/// How a dynamic split is found.
enum class BalanceRule : std::uint8_t {
  paper,  ///< one thread moves at a time, from the phase that ends first to the one that ends last
  busy,   ///< at once to the split that the phases' busy times ask for, verified on time per unit of work
};
std::string_view name(BalanceRule rule);

/// Ways to run a step's stages; one answer.
enum class StepForm : std::uint8_t {
  automatic,   ///< the fastest of those that may be, by measured times
  caller,      ///< on the calling thread alone: pairs are put in order, then narrowed
  overlapped,  ///< shared: both phases at once, answers are put in order at last
  ordered,     ///< shared: pairs are put in order first, so that answers go to their places
};
std::string_view name(StepForm form);

/// What the balancer did after a step.
enum class BalanceAction : std::uint8_t {
  none,     ///< between two control steps, or the split is fixed
  keep,     ///< looked and changed nothing
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
  int control_step = 0;  ///< steps until the next look
  double broad_ms = 0;   ///< what the rule compared: computing time a thread of the phase (paper), busy times (busy)
  double narrow_ms = 0;
  double measure = 0;  ///< detect time (paper) or detect time per unit of work (busy): what verification compares
  double measure_before = 0;  ///< the same before the change, when one is being verified
  std::string_view reason;
};

/// Bits: what went short in a step.
enum class StepIssue : std::uint32_t {
  none = 0,
  inexact = 1u << 0,        ///< the tolerance was not reached for some pair: see PairAnswer::error_bound
  pool_grew = 1u << 1,      ///< the batch pool had to grow (once in a while is fine)
  ran_on_caller = 1u << 2,  ///< too little work to share: the step stayed on the calling thread
  ended_early = 1u << 3     ///< stopped or cancelled: the answer is empty
};
constexpr std::uint32_t bit(StepIssue issue) { return static_cast<std::uint32_t>(issue); }

/// What one thread did while no other could (ms, wall), by phase: opening stages, and stages of a single block.
struct SerialTimes {
  double begin = 0;   ///< before the first stage
  double update = 0;  ///< poses to boxes
  double broad = 0;   ///< the broad phase's preparation
  double join = 0;    ///< putting pairs and answers in order
  double sum() const { return begin + update + broad + join; }
};

/// What one step measured (ms; busy times are summed over threads, waiting excluded).
struct ExecutionReport {
  std::uint64_t candidate_pairs = 0;
  std::uint64_t heavy_pairs = 0;  ///< of them, in batches of their own
  std::uint64_t batches = 0;
  std::uint64_t queue_high_water = 0;  ///< batches waiting at most
  double update_ms = 0;                ///< wall: poses to boxes
  double broad_ms = 0;                 ///< busy: the broad phase's stages
  double narrow_ms = 0;                ///< busy
  double heavy_ms = 0;                 ///< busy: of the narrow phase, the heavy pairs
  double broad_end_ms = 0;             ///< wall, from the start of the shared phase to the last broad block
  double narrow_end_ms = 0;            ///< wall, to the last narrow batch
  double join_ms = 0;                  ///< wall: putting the results in order
  double detect_ms = 0;                ///< wall, all of the above
  double busy_ms = 0;                  ///< busy: all of the above
  SerialTimes serial;                  ///< of it; 0 on the caller alone, where nothing is shared
  int threads = 1;                     ///< in all, the caller counted
  Split split;                         ///< in force in this step; 1-0 when one thread did both
  StepForm form = StepForm::caller;    ///< how it was run
  std::uint32_t issues = 0;            ///< StepIssue bits
  BalanceDecision decision;            ///< taken after this step
};

}  // namespace tandem
