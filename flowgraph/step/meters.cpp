// Times and counts of a step, gathered from its threads.
#include "step/meters.h"

namespace tandem {

void Meters::begin(Timeline* timeline) {
  start_ = shared_start_ = Clock::now();
  timeline_ = timeline;
  serial_ = {};
  begin_ = opening_ = update_end_ = broad_end_ = narrow_end_ = {};
  for (Busy& busy : busy_) busy.ns.store(0, std::memory_order_relaxed);
  heavy_ns_.store(0, std::memory_order_relaxed);
  heavy_pairs_.store(0, std::memory_order_relaxed);
  candidates_.store(0, std::memory_order_relaxed);
  queue_high_water_.store(0, std::memory_order_relaxed);
  inexact_.store(false, std::memory_order_relaxed);
}

void Meters::add_heavy(Clock::duration time, std::size_t pairs) {
  heavy_ns_.fetch_add(to_ns(time), std::memory_order_relaxed);
  heavy_pairs_.fetch_add(pairs, std::memory_order_relaxed);
}

void Meters::add_serial(Phase phase, Clock::duration time, bool opening) {
  serial_[phase] += time;
  if (opening) opening_ += time;
}

void Meters::add_begin(Clock::duration time) {
  begin_ += time;
  opening_ += time;
}

void Meters::count_queue(std::size_t length) {
  std::size_t high = queue_high_water_.load(std::memory_order_relaxed);
  while (length > high && !queue_high_water_.compare_exchange_weak(high, length, std::memory_order_relaxed)) {
  }
  if (timeline_ != nullptr) timeline_->count("queue", static_cast<double>(length));
}

void Meters::slice(std::string_view name, Clock::time_point begin, Clock::time_point end, std::uint64_t id,
                   std::uint64_t pairs, bool heavy) {
  if (timeline_ != nullptr) timeline_->lane().slices.push_back({name, begin, end, step_, id, pairs, heavy});
}

Clock::duration& Meters::narrowed_by_this_thread() {
  thread_local Clock::duration time{};
  return time;
}

double Meters::work_ms() const { return busy_ms(update) + busy_ms(broad) + busy_ms(narrow) + busy_ms(join); }

void Meters::write(ExecutionReport& report) const {
  const Clock::duration total = Clock::now() - start_;
  report.candidate_pairs = candidates_.load(std::memory_order_relaxed);
  report.heavy_pairs = heavy_pairs_.load(std::memory_order_relaxed);
  report.queue_high_water = queue_high_water_.load(std::memory_order_relaxed);
  report.update_ms = to_ms(update_end_);
  report.broad_ms = busy_ms(broad);
  report.narrow_ms = busy_ms(narrow);
  report.heavy_ms = to_ms(heavy_ns_.load(std::memory_order_relaxed));
  report.broad_end_ms = to_ms(broad_end_);
  report.narrow_end_ms = to_ms(narrow_end_);
  report.join_ms = to_ms(total - (shared_start_ - start_) - narrow_end_);
  report.detect_ms = to_ms(total);
  report.busy_ms = work_ms() + to_ms(opening_);
  if (report.form != StepForm::caller)
    report.serial = {to_ms(begin_), to_ms(serial_[update]), to_ms(serial_[broad]), to_ms(serial_[join])};
  if (inexact_.load(std::memory_order_relaxed)) report.issues |= bit(StepIssue::inexact);
}

}  // namespace tandem
