// Kinds and options of executors.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

namespace tandem {

/// The executors: ways to run the same step, with the same answer.
enum class ExecutorKind : std::uint8_t {
  sequential,  ///< the broad phase, then the narrow phase, on the calling thread
  barrier,     ///< both phases parallel with oneTBB; the broad phase ends before the narrow phase begins
  fused,       ///< parallel with oneTBB over tiles of the broad phase, each of which narrows its own pairs at once
  threads,     ///< the paper's design on std::thread alone
  flowgraph,   ///< a flow graph for each phase in an arena of its own, a bounded queue between them, threads balanced
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

/// The rule by which a dynamic split is chosen.
enum class BalanceRule : std::uint8_t {
  paper,  ///< one thread moves at a time, from the phase that ends first to the one that ends last
  busy,   ///< goes at once to the split that the phases' busy times ask for, verified on time per unit of work
};
std::string_view name(BalanceRule rule);

/// The forms of a step: in which order its stages run; the answer is the same.
enum class StepForm : std::uint8_t {
  automatic,   ///< the fastest of the permitted forms, by measured times
  caller,      ///< on the calling thread alone: pairs are sorted, then narrowed
  overlapped,  ///< shared by threads: both phases at once, answers are sorted at the end
  ordered,     ///< shared by threads: pairs are sorted first, so that answers go straight to their places
};
std::string_view name(StepForm form);

struct ExecutionReport;

/// A balancing rule of your own. It is told what was measured in a step whose phases had threads of their own
/// (report.split, broad_ms, narrow_ms, detect_ms, threads, ...) and returns how many threads the broad phase has from
/// the next step on; a number outside of [1, threads - 1] is clamped. It is called on the thread that runs the steps,
/// after each such step; an exception of it is thrown by that step, whose answer is complete. Answers do not depend on
/// the rule.
using BalanceFunction = std::function<int(const ExecutionReport& report)>;

/// How threads are divided between the phases. For executors that divide them: threads, flowgraph.
struct BalanceOptions {
  /// Threads of each phase, both >= 1, with the sum `threads` unless that is 0; at most 1024. Default: dynamic, moved
  /// between the phases as `rule` says.
  Split split{};
  BalanceRule rule = BalanceRule::busy;
  BalanceFunction own_rule{};  ///< replaces `rule` where the split is dynamic; empty: `rule` decides
  /// True: no thread helps the other phase, as in the paper, and steps stay overlapped. Default: threads without work
  /// help.
  bool strict = false;
};

/// How pairs go from the broad to the narrow phase.
struct PairBatchOptions {
  /// Most pairs of a batch, [1, 65536]; fewer where a pair is costly, so that a batch is 15 to 60 us of work.
  std::size_t pairs = 128;
  /// Most batches that wait in the queue, [0, 2^20]; 0: max(16, 4 threads^2).
  std::size_t queue_capacity = 0;
};

/// When threads share a step.
struct SharingOptions {
  /// The form of steps that threads may share; sequential: no step is shared. Not for the executor fused, which has one
  /// form.
  StepForm form = StepForm::automatic;
  /// Milliseconds, [0, 1e6]: a step of less work stays on the calling thread; 0: no step does for this reason.
  double short_step_ms = 0.3;
};

}  // namespace tandem
