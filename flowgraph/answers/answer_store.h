#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "tandem/flowgraph/joiner.h"

namespace tandem {

/// Where threads put the answers of a step until they are joined: each fills chunks of its own, so that it goes through
/// memory in a row, where a place for each batch would be a jump to lines that another core wrote last.
class AnswerStore {
 public:
  AnswerStore();

  /// Empty; no thread may be at work.
  void begin();
  /// Chunk of the calling thread, with room for so many results more. Any thread; stays its own until it asks again.
  AnswerChunk& room(std::size_t results);
  /// All chunks since begin(); no thread may be at work.
  std::span<AnswerChunk* const> taken();
  std::size_t memory() const;

 private:
  struct alignas(64) Slot {
    std::atomic<const void*> thread{nullptr};
    AnswerChunk* chunk = nullptr;  // of that thread
  };
  static constexpr std::size_t chunk_results = 256;

  Slot* own_slot();
  AnswerChunk& take();

  std::vector<Slot> slots_;  // of the threads of a step, by their marks
  std::mutex mutex_;         // of what follows, while threads are at work
  std::vector<std::unique_ptr<AnswerChunk>> chunks_;
  std::vector<AnswerChunk*> free_, taken_;
};

}  // namespace tandem
