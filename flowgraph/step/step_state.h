// The state of a step that its threads share.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string_view>
#include <utility>

#include "step/answer_stages.h"
#include "step/batch_pool.h"
#include "step/batch_writer.h"
#include "step/early_end.h"
#include "step/meters.h"
#include "step/shared_work.h"
#include "step/tickets.h"
#include "tandem/flowgraph/report.h"
#include "tandem/flowgraph/step_work.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem {

/// One step that the threads working on it share. Its stages are those of its work, of which the last one, the shared
/// stage, has tiles that emit pairs, and batches of these pairs that are narrowed; then those that put its answers in
/// order. No thread waits for another to arrive, only for blocks that are being run, so any number of threads completes
/// the step, one included.
///
/// Members: Tickets tell which block is next, AnswerStages where answers go, Meters what is measured, EarlyEnd why the
/// rest is not run, SharedWork what a batch shares with other threads; BatchPool holds the batches.
class StepState final : public Crew, public BatchOwner {
 public:
  /// `form`: any but automatic. `host_cancelled` and `stop` are polled between blocks, by the thread that is about to
  /// run one.
  void begin(StepWork& work, ContactList& contacts, BatchPairs batch_pairs, StepForm form, std::stop_token stop,
             Timeline* timeline, std::function<bool()> host_cancelled = {});
  /// Collects the measurements; throws the first error of the step.
  void end(ExecutionReport& report);
  double work_ms() const { return meters_.work_ms(); }                       ///< Busy time so far, all threads.
  std::size_t memory() const { return pool_.memory() + answers_.memory(); }  ///< Bytes held between steps.

  std::size_t stage() const { return tickets_.stage(); }
  bool finished() const { return stage() == end_; }
  std::size_t end_stage() const { return end_; }
  std::size_t shared_stage() const { return shared_; }
  bool is_broad(std::size_t stage) const { return stage > 0 && stage <= shared_; }
  std::size_t blocks(std::size_t stage) const { return tickets_.blocks(stage); }

  bool all_taken(std::size_t stage) const { return tickets_.all_taken(stage); }
  /// Takes a block (a tile in the shared stage); false when the stage has none left or is over.
  bool take(std::size_t stage, std::size_t& block) { return tickets_.take(stage, block); }
  /// Runs a taken block of a stage other than the shared one.
  void run(std::size_t stage, std::size_t block);
  /// Runs a taken tile.
  void run_tile(std::size_t tile, BatchWriter& writer);
  bool tiles_left() const { return tiles_left_.load(std::memory_order_acquire) != 0; }
  /// Narrows a batch.
  void process(Batch& batch);
  /// Narrows all batches of a step whose shared stage is run by one thread alone, all tiles done: their pairs are
  /// sorted first, so that answers go straight to their places and need no joining.
  void process_in_order(std::span<Batch* const> batches);
  /// Returns when the stage is over. Until then it runs what there is to help with, or else calls more(), which returns
  /// whether it found something to do; sleeps if there is nothing for long.
  template <class More>
  void wait_while(std::size_t stage, More&& more) {
    tickets_.wait_while(stage, [&] { return help() || more(); });
  }
  void wait_while(std::size_t stage) {
    wait_while(stage, [] { return false; });
  }
  /// Wakes the threads that sleep: there is more to do.
  void wake() { tickets_.wake(); }

  /// Works within a batch of another thread, if it has work to share; false if there is none. To be called before
  /// anything else: such a batch may be the longest of all.
  bool help();
  void share(std::size_t parts, const std::function<void(std::size_t)>& part) override;

  StepWork& work() override { return *work_; }
  StepForm form() const override { return answers_.form(); }
  BatchPairs batch_pairs() const override { return batch_pairs_; }
  Batch& open_batch() override;
  void close_work() override;
  void count_candidates(std::size_t pairs) override { meters_.count_candidates(pairs); }
  void saw_heavy() override { answers_.saw_heavy(); }

  std::span<Batch* const> batches() { return pool_.taken(); }
  void count_queue(std::size_t length) noexcept;

  bool failed() const override { return early_end_.found(); }
  void capture() noexcept override { early_end_.capture(); }
  /// Runs the body and keeps what it throws; false if it threw.
  template <class Body>
  bool guard(Body&& body) noexcept {
    return early_end_.guard(std::forward<Body>(body));
  }

 private:
  void open_stage(std::size_t stage);
  std::size_t open_blocks(std::size_t stage);
  Meters::Phase phase_of(std::size_t stage) const;
  bool is_run_of_batches(std::size_t stage) const { return stage == shared_ + 1 + answers_.narrow_stage(); }
  void run_block(std::size_t stage, std::size_t block);
  void run_batches(std::size_t block);
  /// The time it took, to be added to the sum of all.
  Clock::duration narrow(Batch& batch);
  /// Runs the body as a slice of the timeline; an exception ends the step.
  template <class Body>
  Clock::duration timed(std::string_view name, std::uint64_t id, Body&& body) noexcept;
  void slice(std::string_view name, Clock::time_point begin, Clock::time_point end, std::uint64_t id = 0,
             std::uint64_t pairs = 0, bool heavy = false) noexcept;

  StepWork* work_ = nullptr;
  BatchPairs batch_pairs_{0};
  std::size_t filled_ = 0;       // batches of a step on the caller alone that had pairs
  bool from_both_ends_ = false;  // of the stages up to the shared one: who takes which blocks
  std::size_t shared_ = 0, end_ = 0;
  AnswerStages answers_;
  BatchPool pool_;
  EarlyEnd early_end_;
  Tickets tickets_;
  alignas(64) std::atomic<std::size_t> tiles_left_{0};
  Meters meters_;
  SharedWork shared_work_;
};

/// Takes blocks of the stages from the open one up to, not including, `end`, and returns when they are over. No tile of
/// the shared stage may be left.
inline void run_stages(StepState& state, std::size_t end) {
  for (std::size_t stage = state.stage(); stage < end; stage = state.stage()) {
    for (std::size_t block; state.take(stage, block); state.run(stage, block))
      while (state.help()) continue;
    state.wait_while(stage);
  }
}

/// Takes part in the whole step. `may_run(stage)`: this thread helps with the stage; `shared()`: its work in the shared
/// stage.
template <class MayRun, class Shared>
void take_part(StepState& state, MayRun&& may_run, Shared&& shared) {
  for (std::size_t stage = state.stage(); stage != state.end_stage(); stage = state.stage()) {
    if (stage == state.shared_stage())
      shared();
    else if (may_run(stage))
      run_stages(state, stage + 1);
    state.wait_while(stage);
  }
}

}  // namespace tandem
