// The shared array of pairs between broad and narrow phase.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// The shared array of pairs of Avril, Gouranton and Arnaldi (ICAT 2010, section 4.1): the broad phase only puts and
/// the narrow phase only takes, so neither waits for the other's lock. It holds batches and never gets full: segments
/// of doubling size are added as needed and kept from step to step.
class PairArray {
 public:
  ~PairArray();

  /// Removes all batches; not while threads put or take.
  void begin();
  /// Puts a batch. Throws std::bad_alloc, and then the batch is not in the array.
  void put(Batch& batch);
  /// Declares that nothing more will be put. After the last put; more than once does no harm.
  void close();
  /// The next batch, or null when all are taken and it is closed. Sleeps while there is none.
  Batch* take();
  /// The next batch, or null when there is none now.
  Batch* try_take();

 private:
  static constexpr std::size_t first_segment = 256;
  using Slot = std::atomic<Batch*>;
  Slot& slot(std::size_t index);            ///< makes its segment if need be; may throw
  Slot* existing(std::size_t index) const;  ///< null without a segment
  Batch* wait_for(std::size_t index);

  alignas(64) std::atomic<std::size_t> tail_{0};
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::uint32_t> changes_{0};  // puts and the close; sleepers wait on it
  std::atomic<bool> closed_{false};
  std::array<std::atomic<Slot*>, 40> segments_{};
};

}  // namespace tandem
