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

/// Pairs a batch.
struct BatchPairs {
  std::size_t most;
  std::size_t heavy = 0;                           ///< of a batch of heavy pairs; 0: those are left among the others
  std::chrono::nanoseconds time = shortest_batch;  ///< what a batch should take
  std::size_t threads = 0;  ///< that narrow sorted pairs, several batches in a row; 0: one batch at a time
};

/// Batches in a row that one of some threads takes when so many are left: few hand-overs at first, and none waits long
/// at the end, even where the batches to begin with cost a few times as much as the others.
inline std::size_t batches_in_a_row(std::size_t left, std::size_t threads) {
  return threads == 0 ? 1 : std::max<std::size_t>(1, left / (4 * threads));
}

/// Answers of sorted pairs on their way to the list. A thread takes a run of batches, so that what it writes and the
/// bodies that it reads lie together, and threads meet rarely. A run's answers go to their places as soon as those of
/// all runs before it are counted, by the thread that made them, out of the few buffers that it uses again and again:
/// so they are copied while they are in its cache. What is left, because an earlier run was answered later or the list
/// has no room yet, is copied in a stage of its own.
class OrderedAnswers {
 public:
  /// Pairs as a << 32 | b, ascending; they stay until the end of the step. `is_heavy`: which cost far more than others;
  /// empty: none. Batches with such pairs are smaller, and narrowed first.
  void begin(std::span<const std::uint64_t> pairs, BatchPairs batch_pairs, const std::function<bool(Pair)>& is_heavy,
             ContactList& out);
  std::size_t batches() const { return first_.size() - 1; }
  std::size_t runs() const { return runs_.size() - 1; }
  /// The first batch of a run, in the sequence in which they are to be narrowed. Any thread.
  Batch& take(std::size_t turn);
  /// Goes on to the next batch of the run, whose answers follow those that are there; false after the last one.
  bool next(Batch& batch) const;
  /// The answers of a run that was taken and narrowed.
  void put(Batch& batch);

  /// After all runs: gives the list its size; returns the blocks that are left to copy.
  std::size_t open_rest();
  void copy_rest(std::size_t block) { copy(*rest_[block]); }
  std::size_t memory() const;

 private:
  struct Buffer : Batch {
    const void* thread = nullptr;  // the last one that used it
    std::size_t run = 0;
  };
  struct Place {
    std::size_t pair = 0, contact = 0;
  };
  struct Count {
    std::size_t pairs = 0, contacts = 0;
    Buffer* buffer = nullptr;  // with the answers; null: not answered yet
  };

  void cut(BatchPairs batch_pairs, const std::function<bool(Pair)>& is_heavy);
  void group(std::size_t threads);
  void fill(Batch& batch, std::size_t index) const;
  bool has_room(std::size_t run) const;
  void copy(const Buffer& buffer);

  std::span<const std::uint64_t> pairs_;
  std::size_t most_ = 1;
  std::vector<std::uint32_t> first_{0};       // pair of each batch, and the end
  std::vector<std::uint32_t> runs_{0};        // batch of each run, and the end
  std::vector<std::uint32_t> heavy_, turns_;  // runs: with heavy pairs, and all by turns; of one batch each then
  ContactList* out_ = nullptr;
  std::mutex mutex_;                              // of all below, while runs are narrowed
  std::vector<std::unique_ptr<Buffer>> buffers_;  // an address must not change
  std::vector<Buffer*> free_;
  std::vector<Buffer*> waiting_, rest_;  // placed, but not copied: until its thread comes again, to the end
  std::vector<Place> places_;            // of each run and the end; known for the first placed_ + 1
  std::vector<Count> counts_;
  std::size_t placed_ = 0;
};

}  // namespace tandem
