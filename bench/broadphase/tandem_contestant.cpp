// tandem's methods as contestants of the broad-phase bench.
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <vector>

#include "contestant.h"

namespace tandem::bench {
namespace {

/// The pairs of one thread, in batches as an executor takes them.
class ThreadSink final : public PairSink {
 public:
  ThreadSink() : room_(4096) {
    filter_ = &wanted_;
    clear();
  }
  void clear() {
    buffer_ = room_.data();
    capacity_ = PairList::batch;
    count_ = 0;
    first_batch_ = {};
  }
  void filter(const PairFilter& filter) { wanted_ = filter; }
  std::size_t size() const { return static_cast<std::size_t>(buffer_ - room_.data()) + count_; }
  const Pair* data() const { return room_.data(); }
  Clock::time_point first_batch() const { return first_batch_; }

 private:
  void full() override {
    if (first_batch_ == Clock::time_point{}) first_batch_ = Clock::now();
    const std::size_t size = this->size();
    if (size + PairList::batch > room_.size()) room_.resize(2 * room_.size());
    buffer_ = room_.data() + size;
    capacity_ = PairList::batch;
    count_ = 0;
  }
  PairFilter wanted_;
  std::vector<Pair> room_;
  Clock::time_point first_batch_{};
};

class TandemContestant final : public BoxContestant {
 public:
  TandemContestant(BroadPhaseKind kind, int threads)
      : kind_(kind),
        method_(make_broad_phase(kind)),
        arena_(threads),
        threads_(threads),
        sinks_(static_cast<std::size_t>(threads)) {}

  std::string name() const override { return "tandem " + std::string(tandem::name(kind_)); }
  int threads() const override { return threads_; }
  bool filter(const PairFilter& filter) override {
    method_->expect(filter);
    for (ThreadSink& sink : sinks_) sink.filter(filter);
    return true;
  }
  void changes(std::span<const std::uint8_t> changed) override { method_->expect_changes(changed); }
  std::size_t memory() const override { return method_->memory(); }
  std::string note() const override { return std::string(method_->reason()); }

  void step(const BoxArray& boxes, PairList& out) override {
    for (ThreadSink& sink : sinks_) sink.clear();
    const std::size_t stages = method_->begin(boxes);
    for (std::size_t stage = 0; stage + 1 < stages; ++stage)
      each(method_->blocks(stage), [&](std::size_t block, ThreadSink&) { method_->run(stage, block); });
    each(method_->blocks(stages - 1), [&](std::size_t block, ThreadSink& sink) { method_->emit(block, sink); });
    for (const ThreadSink& sink : sinks_)
      if (sink.size() != 0) out.put(sink.data(), sink.size(), sink.first_batch());
  }

 private:
  template <class Work>
  void each(std::size_t blocks, const Work& work) {
    if (threads_ == 1 || blocks < 2) {
      for (std::size_t block = 0; block < blocks; ++block) work(block, sinks_[0]);
      return;
    }
    arena_.execute([&] {
      tbb::parallel_for(
          std::size_t{0}, blocks,
          [&](std::size_t block) {
            work(block, sinks_[static_cast<std::size_t>(tbb::this_task_arena::current_thread_index())]);
          },
          tbb::simple_partitioner());
    });
  }

  BroadPhaseKind kind_;
  std::unique_ptr<BroadPhase> method_;
  tbb::task_arena arena_;
  int threads_;
  std::vector<ThreadSink> sinks_;
};

}  // namespace

std::unique_ptr<BoxContestant> tandem_contestant(BroadPhaseKind kind, int threads) {
  return std::make_unique<TandemContestant>(kind, threads);
}

}  // namespace tandem::bench
