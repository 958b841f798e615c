#pragma once
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
};

/// Answers of sorted pairs on their way to the list. A batch's answers go to their places as soon as those of all
/// batches before it are counted, by the thread that made them, out of the few buffers that it uses again and again:
/// so they are copied while they are in its cache. What is left, because an earlier batch was answered later or the
/// list has no room yet, is copied in a stage of its own.
class OrderedAnswers {
 public:
  /// Pairs as a << 32 | b, ascending; they stay until the end of the step. `is_heavy`: which cost far more than others;
  /// empty: none. Batches with such pairs are smaller, and narrowed first.
  void begin(std::span<const std::uint64_t> pairs, BatchPairs batch_pairs, const std::function<bool(Pair)>& is_heavy,
             ContactList& out);
  std::size_t batches() const { return batches_; }
  /// The pairs of a batch, in the sequence in which they are to be narrowed. Any thread.
  Batch& take(std::size_t turn);
  /// A batch that was taken and narrowed.
  void put(Batch& batch);

  /// After all batches: gives the list its size; returns the blocks that are left to copy.
  std::size_t open_rest();
  void copy_rest(std::size_t block) { copy(*rest_[block]); }

 private:
  struct Buffer : Batch {
    const void* thread = nullptr;  // the last one that used it
  };
  struct Place {
    std::size_t pair = 0, contact = 0;
  };
  struct Count {
    std::size_t pairs = 0, contacts = 0;
    Buffer* buffer = nullptr;  // with the answers; null: not answered yet
  };

  void cut(BatchPairs batch_pairs, const std::function<bool(Pair)>& is_heavy);
  bool has_room(std::size_t batch) const;
  void copy(const Buffer& buffer);

  std::span<const std::uint64_t> pairs_;
  std::size_t most_ = 1, batches_ = 0;
  std::vector<std::uint32_t> first_;          // pair of each batch, and the end
  std::vector<std::uint32_t> heavy_, turns_;  // batches: with heavy pairs, and all by turns
  ContactList* out_ = nullptr;
  std::mutex mutex_;                              // of all below, while batches are narrowed
  std::vector<std::unique_ptr<Buffer>> buffers_;  // an address must not change
  std::vector<Buffer*> free_;
  std::vector<Buffer*> waiting_, rest_;  // placed, but not copied: until its thread comes again, to the end
  std::vector<Place> places_;            // of each batch and the end; known for the first placed_ + 1
  std::vector<Count> counts_;
  std::size_t placed_ = 0;
};

}  // namespace tandem
