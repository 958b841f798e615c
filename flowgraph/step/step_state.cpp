#include "step/step_state.h"

#include <algorithm>
#include <thread>
#include <utility>

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace tandem {
namespace {

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#else
  std::this_thread::yield();
#endif
}

std::int64_t ns(Clock::duration d) { return std::chrono::duration_cast<std::chrono::nanoseconds>(d).count(); }

constexpr std::size_t ordered_stages = PairOrder::stages + 2;

/// Time that the calling thread spends on batches; it is taken out of the tile in which a full queue made it help.
thread_local std::int64_t narrow_ns_of_this_thread = 0;

}  // namespace

double to_ms(std::int64_t ns) { return 1e-6 * static_cast<double>(ns); }

// ---- BatchPool

void BatchPool::begin(std::size_t batch_pairs) {
  std::move(grown_.begin(), grown_.end(), std::back_inserter(batches_));
  if (!grown_.empty())  // some to spare: a load that rises would else grow the pool at every step
    for (std::size_t more = batches_.size() / 2 + 8; more > 0; --more) batches_.push_back(std::make_unique<Batch>());
  grown_.clear();
  batch_pairs_ = batch_pairs;
  next_.store(0, std::memory_order_relaxed);
}

Batch& BatchPool::take() {
  const std::size_t index = next_.fetch_add(1, std::memory_order_relaxed);
  Batch* batch = nullptr;
  if (index < batches_.size()) {
    batch = batches_[index].get();
  } else {
    const std::scoped_lock lock(mutex_);
    batch = grown_.emplace_back(std::make_unique<Batch>()).get();
  }
  batch->clear(batch_pairs_);
  batch->id = index;
  return *batch;
}

std::span<Batch* const> BatchPool::taken() {
  taken_.clear();
  const std::size_t old = std::min(next_.load(std::memory_order_relaxed), batches_.size());
  for (std::size_t i = 0; i < old; ++i) taken_.push_back(batches_[i].get());
  for (const auto& batch : grown_) taken_.push_back(batch.get());
  return taken_;
}

// ---- BatchWriter

void BatchWriter::open() {
  if (batch_ != nullptr) return;
  batch_ = &state_.pool_.take();  // may throw: counted only once it is there
  state_.open_work_.fetch_add(1, std::memory_order_relaxed);
  filter_ = &state_.work_->filter();
  buffer_ = batch_->pairs.data();
  capacity_ = state_.batch_pairs_.most;
  count_ = 0;
}

void BatchWriter::hand_on() {
  state_.candidates_.fetch_add(count_, std::memory_order_relaxed);
  handed_on_ += count_;
  const std::size_t kept = state_.work_->keep({buffer_, count_});
  Batch& batch = *std::exchange(batch_, nullptr);
  batch.count = kept;
  count_ = 0;
  try {
    if (state_.form_ == StepForm::ordered) {  // it stays in the pool until the pairs are put in order
      if (state_.work_->heavy_first(std::span(batch.pairs).first(kept), state_.batch_pairs_.time).all != 0)
        state_.has_heavy_.store(true, std::memory_order_relaxed);
      return state_.close_work();
    }
    if (state_.form_ == StepForm::overlapped && state_.batch_pairs_.heavy != 0) split_off_heavy(batch);
    if (batch.count == 0) return state_.close_work();
    delivery_.deliver(batch);
  } catch (...) {
    state_.close_work();  // nobody has it
    throw;
  }
}

void BatchWriter::split_off_heavy(Batch& batch) {
  const std::span<Pair> pairs = std::span(batch.pairs).first(batch.count);
  const auto [costliest, heavy] = state_.work_->heavy_first(pairs, state_.batch_pairs_.time);
  if (costliest == 0 && heavy == pairs.size() && heavy <= state_.batch_pairs_.heavy) {
    batch.heavy = true;
    return;
  }
  for (std::size_t first = 0, count = 0; first < heavy; first += count) {
    // The costliest one by one: they are begun first so that the last to end is as short as can be.
    count = first < costliest ? 1 : std::min(state_.batch_pairs_.heavy, heavy - first);
    const std::span<const Pair> own = pairs.subspan(first, count);
    Batch& other = state_.pool_.take();
    state_.open_work_.fetch_add(1, std::memory_order_relaxed);
    std::copy(own.begin(), own.end(), other.pairs.begin());
    other.count = own.size();
    other.heavy = true;
    other.costliest = first < costliest;
    try {
      delivery_.deliver(other);
    } catch (...) {
      state_.close_work();
      throw;
    }
  }
  std::copy(pairs.begin() + static_cast<std::ptrdiff_t>(heavy), pairs.end(), pairs.begin());
  batch.count -= heavy;
}

void BatchWriter::full() {
  hand_on();
  open();
}

void BatchWriter::flush() {
  if (batch_ == nullptr) return;
  if (state_.failed()) return drop();
  try {
    hand_on();
  } catch (...) {
    state_.capture();
    drop();
  }
}

void BatchWriter::drop() {
  if (std::exchange(batch_, nullptr) == nullptr) return;
  count_ = 0;
  state_.close_work();
}

// ---- SharedParts

void SharedParts::work() noexcept {
  for (std::size_t part; (part = next_.fetch_add(1, std::memory_order_relaxed)) < parts_;) {
    try {
      part_(part);
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!error_) error_ = std::current_exception();
      next_.store(parts_, std::memory_order_relaxed);
    }
  }
}

void SharedParts::rethrow() const {
  if (error_) std::rethrow_exception(error_);
}

// ---- StepState

void StepState::begin(StepWork& work, ContactList& contacts, BatchPairs batch_pairs, StepForm form,
                      std::stop_token stop, Timeline* timeline, std::function<bool()> host_cancelled) {
  start_ = Clock::now();
  host_cancelled_ = std::move(host_cancelled);
  work_ = &work;
  contacts_ = &contacts;
  batch_pairs_ = batch_pairs;
  stop_ = std::move(stop);
  timeline_ = timeline;
  for (auto* counter :
       {&update_ns_, &broad_ns_, &join_ns_, &narrow_ns_, &heavy_ns_, &update_end_ns_, &broad_end_ns_, &narrow_end_ns_})
    counter->store(0, std::memory_order_relaxed);
  candidates_.store(0, std::memory_order_relaxed);
  heavy_pairs_.store(0, std::memory_order_relaxed);
  has_heavy_.store(false, std::memory_order_relaxed);
  queue_high_water_.store(0, std::memory_order_relaxed);
  failed_.store(false, std::memory_order_relaxed);
  inexact_.store(false, std::memory_order_relaxed);
  error_ = nullptr;
  form_ = form;
  pool_.begin(batch_pairs.most);
  if (form == StepForm::caller) {  // where there are no tiles, nobody comes to write
    contacts.pairs.clear();
    contacts.contacts.clear();
  }
  if (form == StepForm::overlapped) {
    store_.begin();
    joiner_.begin(work.bodies(), contacts);
  }
  work.work_with(form == StepForm::caller ? nullptr : this);
  const std::size_t stages = work.begin();
  note_slice({"begin", start_, Clock::now(), step_, 0, 0});
  shared_ = stages - 1;
  end_ = stages + (form == StepForm::overlapped ? Joiner::stages : form == StepForm::ordered ? ordered_stages : 0);
  blocks_.assign(end_, 0);
  serial_ = {Clock::now() - start_};
  opening_ = serial_[serial_begin];
  open_stage(0);
}

void StepState::count_serial(std::size_t stage, Clock::duration time) {
  serial_[stage == 0 ? serial_update : stage <= shared_ ? serial_broad : serial_join] += time;
}

// Called by one thread at a time: the one that finished the stage before.
void StepState::open_stage(std::size_t stage) {
  const std::size_t narrow_end = form_ == StepForm::ordered ? end_ - 1 : shared_ + 1;
  Clock::time_point now = Clock::now();
  for (;; ++stage) {
    if (stage == 1) update_end_ns_.store(ns(now - start_), std::memory_order_relaxed);
    if (stage == shared_) shared_start_ = now;
    if (stage == narrow_end) narrow_end_ns_.store(ns(now - shared_start_), std::memory_order_relaxed);
    if (stage == end_) break;
    // After an error what earlier stages should have prepared may be missing: nothing more is asked of the work.
    if (stop_requested()) continue;
    try {
      blocks_[stage] = stage <= shared_ ? work_->blocks(stage) : open_tail(stage - shared_ - 1);
    } catch (...) {
      capture();
      continue;
    }
    const Clock::time_point opened = Clock::now();
    note_slice({"open", now, opened, step_, stage, 0});
    count_serial(stage, opened - now);
    opening_ += opened - now;
    now = opened;
    if (blocks_[stage] != 0) break;
  }
  done_.store(0, std::memory_order_relaxed);
  if (stage == shared_) {
    tiles_left_.store(blocks_[stage], std::memory_order_relaxed);
    open_work_.store(blocks_[stage], std::memory_order_relaxed);
  }
  ticket_.store(std::uint64_t{stage} << 32, std::memory_order_release);
  opened_.fetch_add(1, std::memory_order_release);
  opened_.notify_all();
}

std::size_t StepState::open_tail(std::size_t stage) {
  if (form_ == StepForm::overlapped) {
    if (stage == 0) joiner_.take(store_.taken());
    return joiner_.blocks(stage);
  }
  if (stage == 0) pair_order_.begin(pool_.taken(), work_->bodies());
  if (stage < PairOrder::stages) return pair_order_.open(stage);
  if (stage == PairOrder::stages + 1) return answers_.open_rest();
  std::function<bool(Pair)> is_heavy;
  if (has_heavy_.load(std::memory_order_relaxed))
    is_heavy = [this](Pair pair) { return work_->heavy_first({&pair, 1}, batch_pairs_.time).all != 0; };
  answers_.begin(pair_order_.sorted(), batch_pairs_, is_heavy, *contacts_);
  return answers_.runs();
}

void StepState::run_tail(std::size_t stage, std::size_t block) {
  if (form_ == StepForm::overlapped)
    joiner_.run(stage, block);
  else if (stage < PairOrder::stages)
    pair_order_.run(stage, block);
  else
    answers_.copy_rest(block);
}

bool StepState::all_taken(std::size_t stage) const {
  const std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  return ticket >> 32 != stage || (ticket & 0xffffffffu) >= blocks_[stage];
}

bool StepState::take(std::size_t stage, std::size_t& block) {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  do {
    if (ticket >> 32 != stage) return false;
    block = ticket & 0xffffffffu;
    if (block >= blocks_[stage]) return false;
  } while (!ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acquire));
  return true;
}

void StepState::note_slice(const Timeline::Slice& slice) noexcept {
  if (timeline_ == nullptr) return;
  try {
    timeline_->lane().slices.push_back(slice);
  } catch (...) {
    capture();
  }
}

template <class Body>
Clock::duration StepState::timed(std::string_view name, std::uint64_t id, const std::uint64_t* pairs, Body&& body,
                                 bool heavy) {
  const Clock::time_point begin = Clock::now();
  Clock::time_point end = begin;
  try {
    body();
    end = Clock::now();
  } catch (...) {
    capture();
    return end - begin;
  }
  note_slice({name, begin, end, step_, id, pairs != nullptr ? *pairs : 0, heavy});
  return end - begin;
}

void StepState::run(std::size_t stage, std::size_t block) {
  const bool joining = stage > shared_;
  if (form_ == StepForm::ordered && stage == shared_ + 1 + PairOrder::stages) {
    if (!stop_requested()) narrow_in_place(block);
  } else if (!failed()) {
    const auto time = timed(joining      ? "join"
                            : stage == 0 ? "update"
                                         : "broad prepare",
                            block, nullptr, [&] {
                              if (joining)
                                run_tail(stage - shared_ - 1, block);
                              else
                                work_->run(stage, block);
                            });
    (joining ? join_ns_ : stage == 0 ? update_ns_ : broad_ns_).fetch_add(ns(time), std::memory_order_relaxed);
    if (blocks_[stage] == 1) count_serial(stage, time);
  }
  if (done_.fetch_add(1, std::memory_order_acq_rel) + 1 == blocks_[stage]) open_stage(stage + 1);
}

void StepState::run_tile(std::size_t tile, BatchWriter& writer) {
  if (!stop_requested()) {
    const std::int64_t narrow_before = narrow_ns_of_this_thread;
    std::uint64_t pairs = 0;
    const auto time = timed("broad", tile, &pairs, [&] {
      writer.open();
      const std::uint64_t before = writer.taken();
      work_->emit(tile, writer);
      pairs = writer.taken() - before;
    });
    if (failed()) writer.drop();
    broad_ns_.fetch_add(ns(time) - (narrow_ns_of_this_thread - narrow_before), std::memory_order_relaxed);
  }
  if (tiles_left_.fetch_sub(1, std::memory_order_acq_rel) == 1)
    broad_end_ns_.store(ns(Clock::now() - shared_start_), std::memory_order_relaxed);
  close_work();
}

Clock::duration StepState::narrow(Batch& batch) {
  if (failed()) return {};
  const std::uint64_t pairs = batch.count;
  const auto time = timed(
      "narrow", batch.id, &pairs, [&] { answer(batch); }, batch.heavy);
  narrow_ns_of_this_thread += ns(time);
  if (batch.heavy) {
    heavy_ns_.fetch_add(ns(time), std::memory_order_relaxed);
    heavy_pairs_.fetch_add(pairs, std::memory_order_relaxed);
    work_->took(batch, std::chrono::duration_cast<std::chrono::nanoseconds>(time));
  }
  if (batch.inexact) inexact_.store(true, std::memory_order_relaxed);
  return time;
}

void StepState::answer(Batch& batch) {
  if (form_ != StepForm::overlapped) return work_->narrow(batch);
  // The batch goes on where this thread's last one stopped.
  AnswerChunk& own = store_.room(batch.count);
  const std::size_t before = own.results.size();
  const auto exchange = [&] {
    batch.results.swap(own.results);
    batch.contacts.swap(own.contacts);
  };
  exchange();
  try {
    work_->narrow(batch);
  } catch (...) {
    exchange();
    throw;
  }
  exchange();
  joiner_.count(std::span(own.results).subspan(before));
}

void StepState::process(Batch& batch) {
  narrow_ns_.fetch_add(ns(narrow(batch)), std::memory_order_relaxed);
  close_work();
}

void StepState::process_in_order(std::span<Batch* const> batches) {
  if (!failed()) {
    const auto time = timed("join", 0, nullptr, [&] {
      pair_order_.sort(batches, work_->bodies());
      auto from = pair_order_.sorted().begin();
      for (Batch* batch : batches)
        for (Pair& pair : std::span(batch->pairs).first(batch->count)) pair = pair_of(*from++);
    });
    join_ns_.fetch_add(ns(time), std::memory_order_relaxed);
  }
  for (Batch* batch : batches) {
    // Each batch goes on where the one before it stopped.
    batch->results.swap(contacts_->pairs);
    batch->contacts.swap(contacts_->contacts);
    narrow_ns_.fetch_add(ns(narrow(*batch)), std::memory_order_relaxed);
    batch->results.swap(contacts_->pairs);
    batch->contacts.swap(contacts_->contacts);
    close_work();
  }
}

void StepState::narrow_in_place(std::size_t block) {
  Batch* batch = nullptr;
  const auto put_in_order = [&](auto&& body) {
    join_ns_.fetch_add(ns(timed("join", block, nullptr, body)), std::memory_order_relaxed);
  };
  put_in_order([&] { batch = &answers_.take(block); });
  if (failed()) return;
  Clock::duration time{};
  do time += narrow(*batch);
  while (!stop_requested() && answers_.next(*batch));
  narrow_ns_.fetch_add(ns(time), std::memory_order_relaxed);
  if (!failed()) put_in_order([&] { answers_.put(*batch); });
}

void StepState::close_work() {
  if (open_work_.fetch_sub(1, std::memory_order_acq_rel) == 1) open_stage(shared_ + 1);
}

void StepState::wait_while(std::size_t stage) {
  constexpr int spins = 1000;  // about 20-50 us: what a sleeping thread would need to wake
  for (int i = 0; i < spins; ++i) {
    if (this->stage() != stage) return;
    if (!help()) pause();
  }
  for (;;) {
    const std::uint32_t opened = opened_.load(std::memory_order_acquire);
    if (this->stage() != stage) return;
    if (!help()) opened_.wait(opened, std::memory_order_acquire);
  }
}

void StepState::share(std::size_t parts, const std::function<void(std::size_t)>& part) {
  SharedParts all(parts, part);
  {
    const std::scoped_lock lock(shared_mutex_);
    shared_parts_.push_back(&all);
    shared_count_.fetch_add(1, std::memory_order_relaxed);
  }
  opened_.fetch_add(1, std::memory_order_release);  // to those who sleep
  opened_.notify_all();
  all.work();
  {
    const std::scoped_lock lock(shared_mutex_);
    std::erase(shared_parts_, &all);
    shared_count_.fetch_sub(1, std::memory_order_relaxed);
  }
  while (all.helpers.load(std::memory_order_acquire) != 0) pause();
  all.rethrow();
}

bool StepState::help() {
  if (shared_count_.load(std::memory_order_relaxed) == 0) return false;
  SharedParts* some = nullptr;
  {
    const std::scoped_lock lock(shared_mutex_);
    const auto at = std::find_if(shared_parts_.begin(), shared_parts_.end(),
                                 [](const SharedParts* parts) { return !parts->all_taken(); });
    if (at == shared_parts_.end()) return false;
    some = *at;
    some->helpers.fetch_add(1, std::memory_order_relaxed);
  }
  const Clock::time_point begin = Clock::now();
  some->work();
  const Clock::time_point end = Clock::now();
  some->helpers.fetch_sub(1, std::memory_order_release);
  narrow_ns_of_this_thread += ns(end - begin);
  narrow_ns_.fetch_add(ns(end - begin), std::memory_order_relaxed);
  note_slice({"narrow part", begin, end, step_, 0, 0});
  return true;
}

void StepState::count_queue(std::size_t length) noexcept {
  std::size_t high = queue_high_water_.load(std::memory_order_relaxed);
  while (length > high && !queue_high_water_.compare_exchange_weak(high, length, std::memory_order_relaxed)) {
  }
  try {
    if (timeline_ != nullptr) timeline_->count("queue", static_cast<double>(length));
  } catch (...) {
    capture();
  }
}

bool StepState::stop_requested() {
  if (!failed() && (stop_.stop_requested() || (host_cancelled_ && host_cancelled_()))) cancel();
  return failed();
}

void StepState::capture() noexcept {
  const std::scoped_lock lock(error_mutex_);
  if (!error_) error_ = std::current_exception();
  failed_.store(true, std::memory_order_relaxed);
}

double StepState::work_ms() const {
  return to_ms(update_ns_.load(std::memory_order_relaxed) + broad_ns_.load(std::memory_order_relaxed) +
               narrow_ns_.load(std::memory_order_relaxed) + join_ns_.load(std::memory_order_relaxed));
}

void StepState::end(ExecutionReport& report) {
  const auto batches = pool_.taken();
  if (failed()) {
    contacts_->pairs.clear();
    contacts_->contacts.clear();
  }
  report.candidate_pairs = candidates_.load(std::memory_order_relaxed);
  report.heavy_pairs = heavy_pairs_.load(std::memory_order_relaxed);
  report.heavy_ms = to_ms(heavy_ns_.load(std::memory_order_relaxed));
  report.form = form_;
  report.batches = form_ == StepForm::ordered ? answers_.batches() : batches.size();
  report.queue_high_water = queue_high_water_.load(std::memory_order_relaxed);
  report.update_ms = to_ms(update_end_ns_.load(std::memory_order_relaxed));
  report.broad_ms = to_ms(broad_ns_.load(std::memory_order_relaxed));
  report.narrow_ms = to_ms(narrow_ns_.load(std::memory_order_relaxed));
  report.broad_end_ms = to_ms(broad_end_ns_.load(std::memory_order_relaxed));
  report.narrow_end_ms = to_ms(narrow_end_ns_.load(std::memory_order_relaxed));
  const std::int64_t total = ns(Clock::now() - start_);
  report.detect_ms = to_ms(total);
  report.busy_ms = work_ms() + to_ms(ns(opening_));
  if (form_ != StepForm::caller)
    report.serial = {to_ms(ns(serial_[serial_begin])), to_ms(ns(serial_[serial_update])),
                     to_ms(ns(serial_[serial_broad])), to_ms(ns(serial_[serial_join]))};
  report.join_ms = to_ms(total - ns(shared_start_ - start_)) - report.narrow_end_ms;
  report.issues |= (inexact_.load(std::memory_order_relaxed) ? bit(StepIssue::inexact) : 0u) |
                   (pool_.grew() ? bit(StepIssue::pool_grew) : 0u) | (failed() ? bit(StepIssue::ended_early) : 0u);
  ++step_;
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void run_on_caller(StepState& state) {
  struct Shelf final : Delivery {
    explicit Shelf(std::vector<Batch*>& batches) : ready(batches) { ready.clear(); }
    void deliver(Batch& batch) override { ready.push_back(&batch); }
    std::vector<Batch*>& ready;
  } shelf(state.shelf());
  take_part(
      state, [](std::size_t) { return true; },
      [&] {
        BatchWriter writer(state, shelf);
        for (std::size_t tile; state.take(state.shared_stage(), tile);) state.run_tile(tile, writer);
        writer.flush();
        if (state.form() == StepForm::caller)
          state.process_in_order(shelf.ready);
        else
          for (Batch* batch : shelf.ready) state.process(*batch);
        return true;
      });
}

}  // namespace tandem
