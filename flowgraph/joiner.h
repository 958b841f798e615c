#pragma once
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// Puts the results of all batches into canonical order: pairs by (a, b). A counting sort on b and then on a, in
/// stages of independent blocks like the rest of a step; the order of the batches does not matter, since a pair
/// occurs once. The serial stages take about 5 ns a pair in all.
class Joiner {
 public:
  static constexpr std::size_t stages = 6;

  void begin(std::size_t bodies, ContactList& out);
  /// Counts the results of a batch, while they are still in the cache of the thread that made them. Any thread, any
  /// order; every batch before stage 0.
  void count(const Batch& batch);
  /// The batches of the step; known before stage 0.
  void take(std::span<Batch* const> batches) { batches_ = batches; }
  std::size_t blocks(std::size_t stage) const;
  void run(std::size_t stage, std::size_t block);

 private:
  struct Ref {
    std::uint32_t a, batch, index, contacts;
  };
  static constexpr std::size_t batches_a_block = 8;
  static constexpr std::size_t pairs_a_block = 256;

  void prefix();
  void scatter_by_b(std::size_t block);
  void scatter_by_a();
  void count_contacts(std::size_t block);
  void prefix_contacts();
  void copy(std::size_t block);
  const PairResult& result(const Ref& ref) const { return batches_[ref.batch]->results[ref.index]; }

  ContactList* out_ = nullptr;
  std::span<Batch* const> batches_;
  std::vector<std::atomic<std::uint32_t>> cursor_b_;
  std::vector<std::atomic<std::uint32_t>> cursor_a_;
  std::size_t total_ = 0;
  std::vector<Ref> by_b_, sorted_;
  std::vector<std::uint32_t> block_contacts_;
};

}  // namespace tandem
