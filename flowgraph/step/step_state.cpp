// One step that several threads share: opens its stages, runs their blocks, narrows batches, measures.
#include "step/step_state.h"

#include <utility>

namespace tandem {

void StepState::begin(StepWork& work, ContactList& contacts, BatchPairs batch_pairs, StepForm form,
                      std::stop_token stop, Timeline* timeline, std::function<bool()> host_cancelled) {
  meters_.begin(timeline);
  early_end_.begin(std::move(stop), std::move(host_cancelled));
  work_ = &work;
  batch_pairs_ = batch_pairs;
  pool_.begin(batch_pairs.most);
  answers_.begin(work, form, batch_pairs, contacts);
  work.work_with(form == StepForm::caller ? nullptr : this);
  work.ended_by([this] { return early_end_.check(); });
  const std::size_t stages = work.begin();
  // The data of fewer bodies fits into each core's caches; more threads than two were not measured.
  constexpr std::size_t least_bodies = 16384;
  filled_ = 0;
  from_both_ends_ = batch_pairs.threads == 2 && work.bodies() >= least_bodies;
  slice("begin", meters_.start(), Clock::now());
  shared_ = stages - 1;
  end_ = stages + answers_.stages();
  tickets_.begin(end_);
  meters_.add_begin(Clock::now() - meters_.start());
  open_stage(0);
}

Meters::Phase StepState::phase_of(std::size_t stage) const {
  return stage == 0 ? Meters::update : stage <= shared_ ? Meters::broad : Meters::join;
}

std::size_t StepState::open_blocks(std::size_t stage) {
  return stage <= shared_ ? work_->blocks(stage) : answers_.open(stage - shared_ - 1, pool_.taken());
}

// Opens the next stage; called by one thread at a time, which finished the stage before.
void StepState::open_stage(std::size_t stage) {
  // Pairs are narrowed either in the shared stage or in a later one; the stage after it begins when all pairs are
  // narrowed.
  const std::size_t narrow_end = form() == StepForm::ordered ? shared_ + answers_.narrow_stage() + 2 : shared_ + 1;
  Clock::time_point now = Clock::now();
  std::size_t blocks = 0;
  for (;; ++stage) {
    if (stage == 1) meters_.update_ended(now);
    if (stage == shared_) meters_.shared_stage_began(now);
    if (stage == narrow_end) meters_.narrow_ended(now);
    if (stage == end_) break;
    // After an error the results of earlier stages may be missing: no more calls of the work.
    if (early_end_.check() || !guard([&] { blocks = open_blocks(stage); })) continue;
    const Clock::time_point opened = Clock::now();
    slice("open", now, opened, stage);
    meters_.add_serial(phase_of(stage), opened - now, true);
    now = opened;
    if (blocks != 0) break;
  }
  if (stage == end_) blocks = 0;
  if (stage == shared_) tiles_left_.store(blocks, std::memory_order_relaxed);
  tickets_.open(stage, blocks, stage <= shared_ && from_both_ends_);
}

void StepState::slice(std::string_view name, Clock::time_point begin, Clock::time_point end, std::uint64_t id,
                      std::uint64_t pairs, bool heavy) noexcept {
  guard([&] { meters_.slice(name, begin, end, id, pairs, heavy); });
}

template <class Body>
Clock::duration StepState::timed(std::string_view name, std::uint64_t id, Body&& body) noexcept {
  const Clock::time_point begin = Clock::now();
  if (!guard(body)) return {};
  const Clock::time_point end = Clock::now();
  slice(name, begin, end, id);
  return end - begin;
}

void StepState::run(std::size_t stage, std::size_t block) {
  if (is_run_of_batches(stage))
    run_batches(block);
  else if (!failed())
    run_block(stage, block);
  if (tickets_.finish()) open_stage(stage + 1);
}

void StepState::run_block(std::size_t stage, std::size_t block) {
  const Meters::Phase phase = phase_of(stage);
  const auto name = phase == Meters::join ? "join" : phase == Meters::update ? "update" : "broad prepare";
  const auto time = timed(name, block, [&] {
    if (phase == Meters::join)
      answers_.run(stage - shared_ - 1, block);
    else
      work_->run(stage, block);
  });
  meters_.add(phase, time);
  if (blocks(stage) == 1) meters_.add_serial(phase, time, false);
}

void StepState::run_batches(std::size_t block) {
  if (early_end_.check()) return;
  Batch* batch = nullptr;
  meters_.add(Meters::join, timed("join", block, [&] { batch = &answers_.runs().take(block); }));
  if (failed()) return;
  Clock::duration time{};
  do time += narrow(*batch);
  while (!early_end_.check() && answers_.runs().next(*batch));
  meters_.add(Meters::narrow, time);
  if (!failed()) meters_.add(Meters::join, timed("join", block, [&] { answers_.runs().put(*batch); }));
}

void StepState::run_tile(std::size_t tile, BatchWriter& writer) {
  if (!early_end_.check()) {
    const Clock::duration narrowed = Meters::narrowed_by_this_thread();
    const std::uint64_t before = writer.taken();
    const Clock::time_point begin = Clock::now();
    const bool good = guard([&] {
      writer.open();
      work_->emit(tile, writer);
    });
    const Clock::time_point end = Clock::now();
    if (good) slice("broad", begin, end, tile, writer.taken() - before);
    if (failed()) writer.drop();
    meters_.add(Meters::broad, end - begin - (Meters::narrowed_by_this_thread() - narrowed));
  }
  if (tiles_left_.fetch_sub(1, std::memory_order_acq_rel) == 1) meters_.broad_ended();
  close_work();
}

Batch& StepState::open_batch() {
  Batch& batch = pool_.take();  // May throw, so the batch is counted only afterwards.
  tickets_.add();
  return batch;
}

void StepState::close_work() {
  if (tickets_.finish()) open_stage(shared_ + 1);
}

Clock::duration StepState::narrow(Batch& batch) {
  if (failed()) return {};
  const Clock::time_point begin = Clock::now();
  if (!guard([&] { answers_.narrow(batch); })) return {};
  const Clock::time_point end = Clock::now();
  slice("narrow", begin, end, batch.id, batch.count, batch.heavy);
  Meters::narrowed_by_this_thread() += end - begin;
  if (batch.heavy) {
    meters_.add_heavy(end - begin, batch.count);
    work_->took(batch, std::chrono::duration_cast<std::chrono::nanoseconds>(end - begin));
  }
  if (batch.inexact) meters_.saw_inexact();
  return end - begin;
}

void StepState::process(Batch& batch) {
  meters_.add(Meters::narrow, narrow(batch));
  close_work();
}

void StepState::process_in_order(std::span<Batch* const> batches) {
  if (!failed()) meters_.add(Meters::join, timed("join", 0, [&] { answers_.sort(batches); }));
  for (Batch* batch : batches) {
    if (!failed() && answers_.sorted_left() == 0) {
      close_work();  // the batches before it had room for its pairs
      continue;
    }
    process(*batch);
    ++filled_;
  }
}

bool StepState::help() {
  if (!shared_work_.any()) return false;
  const Clock::time_point begin = Clock::now();
  if (!shared_work_.help()) return false;
  const Clock::time_point end = Clock::now();
  Meters::narrowed_by_this_thread() += end - begin;
  meters_.add(Meters::narrow, end - begin);
  slice("narrow part", begin, end);
  return true;
}

void StepState::share(std::size_t parts, const std::function<void(std::size_t)>& part) {
  shared_work_.share(parts, part, [this] { wake(); });
}

void StepState::count_queue(std::size_t length) noexcept {
  guard([&] { meters_.count_queue(length); });
}

void StepState::end(ExecutionReport& report) {
  const auto batches = pool_.taken();
  if (failed()) answers_.clear();
  report.form = form();
  report.batches = form() == StepForm::ordered  ? answers_.runs().batches()
                   : form() == StepForm::caller ? filled_
                                                : batches.size();
  meters_.write(report);
  if (pool_.grew()) report.issues |= bit(StepIssue::pool_grew);
  if (failed()) report.issues |= bit(StepIssue::ended_early);
  meters_.end();
  early_end_.rethrow();
}

}  // namespace tandem
