// Sorted pairs, narrowed in runs of batches whose answers are written in the order of the list.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// Sizes of batches, in pairs.
struct BatchPairs {
  std::size_t most;
  /// Pairs of a batch of heavy pairs; 0: heavy pairs are left among the others.
  std::size_t heavy = 0;
  std::chrono::nanoseconds time = shortest_batch;  ///< time that a batch should take
  /// Threads that narrow sorted pairs in runs of several batches; 0: every run is one batch.
  std::size_t threads = 0;
};

/// Batches of the next run, for this number of threads with so many batches left: long runs first, so that few are
/// handed over, and short ones at the end, so that no thread waits long for the last, even where the first batches cost
/// a few times as much as the others.
inline std::size_t batches_in_a_row(std::size_t left, std::size_t threads) {
  return threads == 0 ? 1 : std::max<std::size_t>(1, left / (4 * threads));
}

/// Answers of sorted pairs on their way to the list of contacts. A thread takes a run of consecutive batches, so the
/// bodies that it reads and the answers that it writes lie together, and threads contend rarely. The thread that
/// narrowed a run copies its answers to their places as soon as the answers of all earlier runs are counted, while they
/// are in its cache; it reuses a few buffers. Runs that cannot be copied then, because an earlier run was answered
/// later or the list has no room yet, are copied in a stage of their own.
class OrderedAnswers {
 public:
  /// Sets the pairs, a << 32 | b in ascending order; they stay until the end of the step. `is_heavy`: tells the
  /// pairs that cost far more than others; empty: none do. Batches with such pairs are smaller, and narrowed first.
  void begin(std::span<const std::uint64_t> pairs, BatchPairs batch_pairs, const std::function<bool(Pair)>& is_heavy,
             ContactList& out);
  std::size_t batches() const { return first_.size() - 1; }
  std::size_t runs() const { return runs_.size() - 1; }
  /// The first batch of a run, in the order in which runs are to be narrowed. Any thread.
  Batch& take(std::size_t turn);
  /// Goes on to the next batch of the run, whose answers follow those that are there; false after the last one.
  bool next(Batch& batch) const;
  /// Counts the answers of a run that was taken and narrowed, and copies what can be copied.
  void put(Batch& batch);

  /// After all runs: sizes the list; returns the number of blocks that are left to copy.
  std::size_t open_rest();
  void copy_rest(std::size_t block) { copy(*rest_[block]); }
  std::size_t memory() const;

 private:
  struct Buffer : Batch {
    const void* thread = nullptr;  // the last thread that used it
    std::size_t run = 0;
  };
  struct Place {
    std::size_t pair = 0, contact = 0;
  };
  struct Count {
    std::size_t pairs = 0, contacts = 0;
    Buffer* buffer = nullptr;  // the buffer with the answers; null: not answered yet
  };

  void cut(BatchPairs batch_pairs, const std::function<bool(Pair)>& is_heavy);
  void group(std::size_t threads);
  void fill(Batch& batch, std::size_t index) const;
  bool has_room(std::size_t run) const;
  void copy(const Buffer& buffer);

  std::span<const std::uint64_t> pairs_;
  std::size_t most_ = 1;
  std::vector<std::uint32_t> first_{0};       // the first pair of each batch, and the end
  std::vector<std::uint32_t> runs_{0};        // the first batch of each run, and the end
  std::vector<std::uint32_t> heavy_, turns_;  // batches with heavy pairs; all batches, those first
  ContactList* out_ = nullptr;
  std::mutex mutex_;                              // guards all below while runs are narrowed
  std::vector<std::unique_ptr<Buffer>> buffers_;  // by pointer, since addresses must not change
  std::vector<Buffer*> free_;
  std::vector<Buffer*> waiting_, rest_;  // buffers placed but not copied: until their thread comes again, or the end
  // Position of each run's first answer, and the end; known for the first placed_ + 1.
  std::vector<Place> places_;
  std::vector<Count> counts_;
  std::size_t placed_ = 0;
};

}  // namespace tandem
