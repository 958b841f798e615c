#pragma once
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "answers/answer_store.h"
#include "answers/joiner.h"
#include "answers/ordered_answers.h"
#include "answers/pair_order.h"
#include "tandem/flowgraph/batch.h"
#include "tandem/flowgraph/report.h"
#include "tandem/flowgraph/step_work.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem {

using Clock = std::chrono::steady_clock;

/// Batches, kept from step to step. Taking one is an atomic increment unless the pool has to grow.
class BatchPool {
 public:
  void begin(std::size_t batch_pairs);
  Batch& take();
  /// All batches taken since begin(); not while some thread may take one.
  std::span<Batch* const> taken();
  bool grew() const { return !grown_.empty(); }

 private:
  std::size_t batch_pairs_ = 0;
  std::vector<std::unique_ptr<Batch>> batches_, grown_;
  std::vector<Batch*> taken_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
};

class StepState;

/// Where a filled batch goes; what differs between executors.
class Delivery {
 public:
  virtual ~Delivery() = default;
  virtual void deliver(Batch& batch) = 0;
};

/// One thread's end of the broad phase: fills a batch, over several tiles if need be, and hands it on when full.
class BatchWriter final : public PairSink {
 public:
  BatchWriter(StepState& state, Delivery& delivery) : state_(state), delivery_(delivery) {}
  BatchWriter(const BatchWriter&) = delete;
  BatchWriter& operator=(const BatchWriter&) = delete;

  /// Ready to take pairs. The batch in hand counts as open work until it is delivered and processed, or dropped.
  void open();
  /// Hands on what is there; a no-op with nothing in hand.
  void flush();
  /// Forgets the pairs in hand.
  void drop();
  /// Candidates put so far.
  std::uint64_t taken() const { return handed_on_ + count_; }

 private:
  void full() override;
  void hand_on();
  void split_off_heavy(Batch& batch);

  StepState& state_;
  Delivery& delivery_;
  Batch* batch_ = nullptr;
  std::uint64_t handed_on_ = 0;
};

/// Work that is shared part by part: threads take the next one until there is none.
class SharedParts {
 public:
  SharedParts(std::size_t parts, const std::function<void(std::size_t)>& part) : parts_(parts), part_(part) {}
  bool all_taken() const { return next_.load(std::memory_order_relaxed) >= parts_; }
  /// Takes parts until none is left; what one throws is kept and the rest is not run.
  void work() noexcept;
  /// After the last thread has left: throws what a part threw.
  void rethrow() const;

  std::atomic<int> helpers{0};  ///< that have not left yet

 private:
  std::size_t parts_;
  const std::function<void(std::size_t)>& part_;
  std::atomic<std::size_t> next_{0};
  std::mutex mutex_;
  std::exception_ptr error_;
};

/// The state of one step that the threads working on it share. Threads take blocks of the current stage until it is
/// used up; whoever finishes the last one opens the next stage. No thread waits for another to arrive, only for
/// blocks that are being worked on, so any number of threads gets the step done, one included.
///
/// Stages: those of the work (the last one is the shared phase: tiles that emit and batches that are narrowed), then
/// the joiner's. In StepForm::ordered no batch is narrowed in the shared phase: stages follow that put the pairs in
/// order, narrow them, and copy the answers that are not in their places yet. After an error or a stop request the rest
/// of the blocks are counted off without being run.
class StepState final : public Crew {
 public:
  /// `host_cancelled` is polled between blocks, like `stop`, by whatever thread is about to run one.
  /// `form`: not automatic.
  void begin(StepWork& work, ContactList& contacts, BatchPairs batch_pairs, StepForm form, std::stop_token stop,
             Timeline* timeline, std::function<bool()> host_cancelled = {});
  /// Collects what was measured; throws the first error of the step.
  void end(ExecutionReport& report);

  std::size_t stage() const { return ticket_.load(std::memory_order_acquire) >> 32; }
  bool finished() const { return stage() == end_; }
  std::size_t end_stage() const { return end_; }
  std::size_t shared_stage() const { return shared_; }
  bool is_broad(std::size_t stage) const { return stage > 0 && stage <= shared_; }

  StepForm form() const { return form_; }

  /// No block of the stage is left to take.
  bool all_taken(std::size_t stage) const;
  /// Takes a block (a tile in the shared stage); false when the stage has none left or is over.
  bool take(std::size_t stage, std::size_t& block);
  /// Runs a taken block of a stage other than the shared one.
  void run(std::size_t stage, std::size_t block);
  /// Runs a taken tile.
  void run_tile(std::size_t tile, BatchWriter& writer);
  /// Narrow phase of a batch.
  void process(Batch& batch);
  /// Narrow phase of all batches of a step whose shared stage is on one thread alone, all tiles done: their pairs are
  /// put in order first, so that answers go to their places at once and nothing is left to join.
  void process_in_order(std::span<Batch* const> batches);
  bool tiles_left() const { return tiles_left_.load(std::memory_order_acquire) != 0; }

  /// Work within a batch of another thread, if it has parts to share; false if there is none. To be looked for before
  /// anything else: such a batch may be the longest of all.
  bool help();
  void share(std::size_t parts, const std::function<void(std::size_t)>& part) override;

  /// Returns when the stage is over and helps until then: spins for about as long as a short block lasts, then sleeps.
  void wait_while(std::size_t stage);
  void count_queue(std::size_t length) noexcept;

  /// Notes the exception being handled, if it is the first: the rest of the step is counted off.
  void capture() noexcept;

  // For executors that drive the stages themselves.
  std::size_t blocks(std::size_t stage) const { return blocks_[stage]; }
  std::span<Batch* const> batches() { return pool_.taken(); }
  std::vector<Batch*>& shelf() { return shelf_; }  ///< room for batches that wait, kept from step to step
  double work_ms() const;                          ///< busy time so far, all blocks

 private:
  friend class BatchWriter;

  /// What it took, to be added to the sum of all.
  Clock::duration narrow(Batch& batch);
  void answer(Batch& batch);
  bool failed() const { return failed_.load(std::memory_order_relaxed); }
  void cancel() { failed_.store(true, std::memory_order_relaxed); }
  /// True when no more blocks are to be run: after an error, a stop request or the host's cancellation.
  bool stop_requested();
  void open_stage(std::size_t stage);
  void count_serial(std::size_t stage, Clock::duration time);
  std::size_t open_tail(std::size_t stage);
  void run_tail(std::size_t stage, std::size_t block);
  void narrow_in_place(std::size_t block);
  void close_work();
  template <class Body>
  Clock::duration timed(std::string_view name, std::uint64_t id, const std::uint64_t* pairs, Body&& body,
                        bool heavy = false);
  void note_slice(const Timeline::Slice& slice) noexcept;

  StepWork* work_ = nullptr;
  ContactList* contacts_ = nullptr;
  Timeline* timeline_ = nullptr;
  std::stop_token stop_;
  std::function<bool()> host_cancelled_;
  BatchPairs batch_pairs_{0};
  std::uint64_t step_ = 0;
  std::size_t shared_ = 0, end_ = 0;
  std::vector<std::size_t> blocks_;
  AnswerStore store_;  // of StepForm::overlapped
  Joiner joiner_;
  PairOrder pair_order_;
  OrderedAnswers answers_;
  StepForm form_ = StepForm::caller;
  BatchPool pool_;
  std::vector<Batch*> shelf_;
  Clock::time_point start_, shared_start_;
  enum SerialPhase : std::uint8_t { serial_begin, serial_update, serial_broad, serial_join };
  std::array<Clock::duration, 4> serial_{};  // written by the one thread that opens a stage or has its only block
  Clock::duration opening_{};                // of that, what is no block

  // Stage in the high half, next block in the low half: a block can only be taken of the stage it belongs to.
  alignas(64) std::atomic<std::uint64_t> ticket_{0};
  alignas(64) std::atomic<std::size_t> done_{0};
  alignas(64) std::atomic<std::uint32_t> opened_{0};   // changes with each stage; sleepers wait on it
  alignas(64) std::atomic<std::size_t> open_work_{0};  // of the shared stage: unfinished tiles and open batches
  alignas(64) std::atomic<std::size_t> tiles_left_{0};
  alignas(64) std::atomic<std::int64_t> update_ns_{0};
  std::atomic<std::int64_t> broad_ns_{0}, join_ns_{0};
  alignas(64) std::atomic<std::int64_t> narrow_ns_{0};
  std::atomic<std::int64_t> heavy_ns_{0};
  std::atomic<std::uint64_t> heavy_pairs_{0};
  std::atomic<bool> has_heavy_{false};  // in StepForm::ordered
  std::atomic<std::uint64_t> candidates_{0};
  std::atomic<std::size_t> queue_high_water_{0};
  std::atomic<bool> failed_{false}, inexact_{false};
  std::atomic<std::int64_t> update_end_ns_{0}, broad_end_ns_{0}, narrow_end_ns_{0};
  alignas(64) std::atomic<int> shared_count_{0};
  std::mutex shared_mutex_;
  std::vector<SharedParts*> shared_parts_;  // of blocks at work
  std::mutex error_mutex_;
  std::exception_ptr error_;
};

/// Takes part in a step until it is finished, or until `shared` says to leave. `may_run(stage)` tells which stages
/// this thread helps with; `shared()` is its part in the shared phase and returns whether to stay.
template <class MayRun, class Shared>
void take_part(StepState& state, MayRun&& may_run, Shared&& shared) {
  for (std::size_t stage = state.stage(); stage != state.end_stage(); stage = state.stage()) {
    if (stage == state.shared_stage()) {
      if (!shared()) return;
    } else if (may_run(stage)) {
      for (std::size_t block; state.take(stage, block); state.run(stage, block))
        while (state.help()) continue;
    }
    state.wait_while(stage);
  }
}

/// The whole step on the calling thread: broad, then narrow; in order, unless the step was begun as one of several
/// threads, whose answers are joined.
void run_on_caller(StepState& state);

double to_ms(std::int64_t ns);

}  // namespace tandem
