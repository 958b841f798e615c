// Storage of answers by thread.
#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "tandem/flowgraph/joiner.h"

namespace tandem {

/// Chunks in which the threads of a step keep their answers until these are joined. Each thread appends to chunks of
/// its own: memory that it writes in a row, where a slot for each batch would touch cache lines that another core wrote
/// last.
class AnswerStore {
 public:
  AnswerStore();

  /// Removes all answers; no thread may be at work.
  void begin();
  /// The chunk of the calling thread, with room for so many results more. Any thread; the chunk stays the thread's own
  /// until its next call.
  AnswerChunk& room(std::size_t results);
  /// All chunks since begin(); no thread may be at work.
  std::span<AnswerChunk* const> taken();
  std::size_t memory() const;

 private:
  struct alignas(64) Slot {
    std::atomic<const void*> thread{nullptr};
    AnswerChunk* chunk = nullptr;  // mark of the thread that it belongs to
  };
  static constexpr std::size_t chunk_results = 256;

  Slot* own_slot();
  AnswerChunk& take();

  std::vector<Slot> slots_;  // by the marks of the step's threads
  std::mutex mutex_;         // guards what follows while threads are at work
  std::vector<std::unique_ptr<AnswerChunk>> chunks_;
  std::vector<AnswerChunk*> free_, taken_;
};

}  // namespace tandem
