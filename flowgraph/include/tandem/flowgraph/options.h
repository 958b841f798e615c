#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

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

struct ExecutionReport;

/// A rule of one's own: told what a step measured whose phases had threads of their own (report.split, broad_ms,
/// narrow_ms, detect_ms, threads, ...), it says how many threads the broad phase has from the next step on; what is
/// outside of [1, threads - 1] is taken for the nearest. Called on the thread that runs the steps, after each such
/// step; what it throws is thrown by that step, whose answer is there. Answers do not depend on it.
using BalanceFunction = std::function<int(const ExecutionReport& report)>;

/// Which threads work on which phase. For executors that divide them: threads, flowgraph.
struct BalanceOptions {
  /// Threads for each phase, both >= 1, with the sum `threads` unless that is 0; at most 1024. Default: dynamic, moved
  /// between the phases as `rule` says.
  Split split{};
  BalanceRule rule = BalanceRule::busy;
  BalanceFunction own_rule{};  ///< in place of `rule` where the split is dynamic; empty: none
  /// No help across the phases, as in the paper; steps stay overlapped. Default: work is conserved.
  bool strict = false;
};

/// How pairs go from the broad to the narrow phase.
struct PairBatchOptions {
  /// Pairs a batch at most, [1, 65536]; fewer where a pair is costly, so that a batch is 15 to 60 us of work.
  std::size_t pairs = 128;
  /// Batches that wait at most, [0, 2^20]; 0: max(16, 4 threads^2).
  std::size_t queue_capacity = 0;
};

/// When threads share a step.
struct SharingOptions {
  /// How the steps are run that several threads may share; sequential: all. Not for fused, which has one form.
  StepForm form = StepForm::automatic;
  /// Milliseconds, [0, 1e6]: a step of less work stays on the caller; 0: no step does.
  double short_step_ms = 0.3;
};

}  // namespace tandem
