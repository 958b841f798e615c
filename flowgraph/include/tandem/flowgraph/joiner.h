// Merges the answers of several threads into one list.
#pragma once
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// A chunk of answers of one thread, one after the other.
struct AnswerChunk {
  std::vector<PairResult> results;  ///< first_contact counts within the chunk
  std::vector<Contact> contacts;
  const void* thread = nullptr;  ///< the thread that filled it last, by a mark of the executor
};

/// Puts the answers of all threads into canonical order: pairs by (a, b). Results go into a bucket for each a, and each
/// bucket is sorted by itself, in stages of independent blocks like the rest of a step. The order in which answers were
/// found does not matter, since a pair occurs once. The serial part is only sums over bodies and over blocks.
class Joiner {
 public:
  static constexpr std::size_t stages = 6;

  /// Runs all that follows, on the calling thread. `bodies`: one past the largest body index (StepWork::bodies()),
  /// which no result may exceed.
  void join(std::span<AnswerChunk* const> answers, std::size_t bodies, ContactList& out);

  /// Starts a step: its threads count, then its stages run one after the other, each one's blocks on any threads.
  void begin(std::size_t bodies, ContactList& out);
  /// Counts results, best while they are in the cache of the thread that made them. Any thread, any order; all of them
  /// before stage 0.
  void count(std::span<const PairResult> results);
  /// Takes all answers of the step, before stage 0.
  void take(std::span<AnswerChunk* const> answers) { answers_ = answers; }
  /// The number of a stage's blocks; known once the stages before it are done.
  std::size_t blocks(std::size_t stage) const;
  void run(std::size_t stage, std::size_t block);
  std::size_t memory() const;  ///< Bytes held between steps.

 private:
  struct Ref {
    std::uint32_t b, contacts;
    const PairResult* result;
    const Contact* first;
  };
  struct Range {
    std::size_t begin, end;
  };
  static constexpr std::size_t pairs_a_block = 256;

  void prefix();
  void scatter(std::size_t block);
  void sort(std::size_t block);
  void count_contacts(std::size_t block);
  void prefix_contacts();
  void copy(std::size_t block);
  /// The bodies whose buckets begin among a block's 256 results; known once the results are scattered.
  Range buckets(std::size_t block) const;
  std::size_t bucket_end(std::size_t a) const { return cursor_[a].load(std::memory_order_relaxed); }
  std::size_t bucket_begin(std::size_t a) const { return a == 0 ? 0 : bucket_end(a - 1); }

  ContactList* out_ = nullptr;
  std::span<AnswerChunk* const> answers_;
  // For each body: first its count, then the next free place of its bucket
  std::vector<std::atomic<std::uint32_t>> cursor_;
  std::size_t total_ = 0;
  std::vector<Ref> refs_, spare_;
  std::vector<std::uint32_t> block_contacts_;
};

}  // namespace tandem
