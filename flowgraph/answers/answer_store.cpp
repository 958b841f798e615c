// Stores of a step's answers: one chunk a thread, found by a hash of the thread's mark.
#include "answers/answer_store.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <thread>
#include <utility>

#include "answers/thread_mark.h"

namespace tandem {

// Slots: four times the number of cores, so that a thread finds a free slot soon even where a host has more threads
// than cores.
AnswerStore::AnswerStore() : slots_(std::bit_ceil(4 * std::max(4u, std::thread::hardware_concurrency()))) {}

void AnswerStore::begin() {
  for (Slot& slot : slots_) {
    slot.thread.store(nullptr, std::memory_order_relaxed);
    slot.chunk = nullptr;
  }
  taken_.clear();
  free_.clear();
  for (const auto& chunk : chunks_) free_.push_back(chunk.get());
}

AnswerStore::Slot* AnswerStore::own_slot() {
  const void* const mark = this_thread_mark();
  // The marks of threads lie memory pages apart, so they differ in their middle bits: those make the hash.
  std::size_t at = std::bit_cast<std::uintptr_t>(mark) * 0x9e3779b97f4a7c15u >> 40;
  for (std::size_t tries = 0; tries < slots_.size(); ++tries, ++at) {
    Slot& slot = slots_[at & (slots_.size() - 1)];
    const void* owner = slot.thread.load(std::memory_order_relaxed);
    if (owner == mark) return &slot;
    if (owner == nullptr && slot.thread.compare_exchange_strong(owner, mark, std::memory_order_relaxed)) return &slot;
  }
  return nullptr;
}

AnswerChunk& AnswerStore::room(std::size_t results) {
  Slot* const slot = own_slot();
  if (slot == nullptr) return take();
  if (slot->chunk == nullptr || slot->chunk->results.size() + results > chunk_results) slot->chunk = &take();
  return *slot->chunk;
}

AnswerChunk& AnswerStore::take() {
  const void* const mark = this_thread_mark();
  AnswerChunk* chunk = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) {
      chunk = chunks_.emplace_back(std::make_unique<AnswerChunk>()).get();
      free_.reserve(chunks_.capacity());
      taken_.reserve(chunks_.capacity());
      chunk->results.reserve(chunk_results);
      chunk->contacts.reserve(chunk_results);
    } else {
      auto own = std::find_if(free_.begin(), free_.end(), [=](const AnswerChunk* c) { return c->thread == mark; });
      if (own == free_.end()) own = free_.end() - 1;
      chunk = std::exchange(*own, free_.back());
      free_.pop_back();
    }
    taken_.push_back(chunk);
  }
  chunk->thread = mark;
  chunk->results.clear();
  chunk->contacts.clear();
  return *chunk;
}

std::span<AnswerChunk* const> AnswerStore::taken() { return taken_; }

std::size_t AnswerStore::memory() const {
  std::size_t bytes = slots_.capacity() * sizeof(Slot);
  for (const auto& chunk : chunks_)
    bytes += sizeof(AnswerChunk) + chunk->results.capacity() * sizeof(PairResult) +
             chunk->contacts.capacity() * sizeof(Contact);
  return bytes;
}

}  // namespace tandem
