// Answers of sorted pairs: cuts the pairs into batches and runs of batches, and copies each run's answers to their
// place in the list.
#include "answers/ordered_answers.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "answers/pair_order.h"
#include "answers/thread_mark.h"

namespace tandem {
namespace {

/// The run of a buffer whose answers the step has not taken yet.
constexpr std::size_t unused = std::numeric_limits<std::size_t>::max();

/// Prefetches the cache lines that are about to be written: plain stores would wait for one after the other.
void prefetch_to_write([[maybe_unused]] const void* data, [[maybe_unused]] std::size_t bytes) {
#if defined(__x86_64__)
  // Inline assembly, since the compiler emits a prefetch for reading unless it is told the processor.
  for (std::size_t at = 0; at < bytes; at += 64)
    asm volatile("prefetchw %0" : : "m"(static_cast<const char*>(data)[at]));
#endif
}

}  // namespace

void OrderedAnswers::begin(std::span<const std::uint64_t> pairs, BatchPairs batch_pairs,
                           const std::function<bool(Pair)>& is_heavy, ContactList& out) {
  pairs_ = pairs;
  most_ = batch_pairs.most;
  cut(batch_pairs, is_heavy);
  group(heavy_.empty() ? batch_pairs.threads : 0);
  out_ = &out;
  places_.resize(runs() + 1);
  counts_.assign(runs(), {});
  placed_ = 0;
  // Buffers: as many as runs are filled at once where the list has no room yet; a step with room uses few of them.
  std::erase_if(buffers_, [](const auto& buffer) { return std::exchange(buffer->run, unused) == unused; });
  for (auto* list : {&waiting_, &rest_, &free_}) {
    list->clear();
    list->reserve(buffers_.size() + runs());
  }
  buffers_.reserve(buffers_.size() + runs());
  for (const auto& buffer : buffers_) free_.push_back(buffer.get());
}

void OrderedAnswers::cut(BatchPairs batch_pairs, const std::function<bool(Pair)>& is_heavy) {
  first_.clear();
  heavy_.clear();
  turns_.clear();
  if (!is_heavy) {
    for (std::size_t at = 0; at < pairs_.size(); at += most_) first_.push_back(static_cast<std::uint32_t>(at));
    first_.push_back(static_cast<std::uint32_t>(pairs_.size()));
    return;
  }
  // A batch is full with `most_` light pairs, or with `most_heavy` heavy ones: each pair takes its share of the
  // product.
  const std::size_t most_heavy = std::clamp<std::size_t>(batch_pairs.heavy, 1, most_), full = most_ * most_heavy;
  std::size_t taken = full;
  for (std::size_t at = 0; at < pairs_.size(); ++at) {
    if (taken >= full) {
      first_.push_back(static_cast<std::uint32_t>(at));
      taken = 0;
    }
    const bool heavy = is_heavy(pair_of(pairs_[at]));
    taken += heavy ? most_ : most_heavy;
    const auto batch = static_cast<std::uint32_t>(first_.size() - 1);
    if (heavy && (heavy_.empty() || heavy_.back() != batch)) heavy_.push_back(batch);
  }
  first_.push_back(static_cast<std::uint32_t>(pairs_.size()));
  turns_ = heavy_;
  auto next_heavy = heavy_.begin();
  for (std::uint32_t batch = 0; batch + 1 < first_.size(); ++batch) {
    if (next_heavy != heavy_.end() && *next_heavy == batch)
      ++next_heavy;
    else
      turns_.push_back(batch);
  }
}

void OrderedAnswers::group(std::size_t threads) {
  runs_.assign(1, 0);
  while (runs_.back() < batches())
    runs_.push_back(runs_.back() + static_cast<std::uint32_t>(batches_in_a_row(batches() - runs_.back(), threads)));
}

void OrderedAnswers::fill(Batch& batch, std::size_t index) const {
  batch.id = index;
  const auto keys = pairs_.subspan(first_[index], first_[index + 1] - first_[index]);
  batch.count = keys.size();
  std::transform(keys.begin(), keys.end(), batch.pairs.begin(), pair_of);
}

Batch& OrderedAnswers::take(std::size_t turn) {
  const std::size_t index = turns_.empty() ? turn : turns_[turn];
  const void* const thread = this_thread_mark();
  Buffer* buffer = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) {
      buffer = buffers_.emplace_back(std::make_unique<Buffer>()).get();
    } else {
      auto own = std::find_if(free_.rbegin(), free_.rend(), [=](const Buffer* b) { return b->thread == thread; });
      if (own == free_.rend()) own = free_.rbegin();
      buffer = *own;
      *own = free_.back();
      free_.pop_back();
    }
  }
  buffer->thread = thread;
  buffer->run = index;
  buffer->clear(most_);
  buffer->heavy = turn < heavy_.size();
  fill(*buffer, runs_[index]);
  return *buffer;
}

bool OrderedAnswers::next(Batch& batch) const {
  if (batch.id + 1 == runs_[static_cast<Buffer&>(batch).run + 1]) return false;
  fill(batch, batch.id + 1);
  return true;
}

void OrderedAnswers::put(Batch& batch) {
  Buffer& buffer = static_cast<Buffer&>(batch);
  std::array<Buffer*, 8> own{};
  std::size_t count = 0;
  {
    const std::scoped_lock lock(mutex_);
    counts_[buffer.run] = {batch.results.size(), batch.contacts.size(), &buffer};
    for (; placed_ < runs() && counts_[placed_].buffer != nullptr; ++placed_) {
      const Count& here = counts_[placed_];
      places_[placed_ + 1] = {places_[placed_].pair + here.pairs, places_[placed_].contact + here.contacts};
      (has_room(placed_) ? waiting_ : rest_).push_back(here.buffer);
    }
    const auto others = std::partition(waiting_.begin(), waiting_.end(),
                                       [&](const Buffer* waiting) { return waiting->thread != buffer.thread; });
    for (; count < own.size() && waiting_.end() != others; waiting_.pop_back()) own[count++] = waiting_.back();
  }
  for (Buffer* done : std::span(own).first(count)) copy(*done);
  const std::scoped_lock lock(mutex_);
  for (Buffer* done : std::span(own).first(count)) free_.push_back(done);
}

std::size_t OrderedAnswers::open_rest() {
  out_->pairs.resize(places_[runs()].pair);
  out_->contacts.resize(places_[runs()].contact);
  rest_.insert(rest_.end(), waiting_.begin(), waiting_.end());
  return rest_.size();
}

bool OrderedAnswers::has_room(std::size_t run) const {
  const Place end = places_[run + 1];
  return end.pair <= out_->pairs.size() && end.contact <= out_->contacts.size();
}

void OrderedAnswers::copy(const Buffer& buffer) {
  const Place place = places_[buffer.run];
  prefetch_to_write(out_->contacts.data() + place.contact, buffer.contacts.size() * sizeof(Contact));
  prefetch_to_write(out_->pairs.data() + place.pair, buffer.results.size() * sizeof(PairResult));
  std::copy(buffer.contacts.begin(), buffer.contacts.end(),
            out_->contacts.begin() + static_cast<std::ptrdiff_t>(place.contact));
  auto to = out_->pairs.begin() + static_cast<std::ptrdiff_t>(place.pair);
  for (const PairResult& result : buffer.results) {
    *to = result;
    to->first_contact += static_cast<std::uint32_t>(place.contact);
    ++to;
  }
}

std::size_t OrderedAnswers::memory() const {
  std::size_t bytes =
      (first_.capacity() + runs_.capacity() + heavy_.capacity() + turns_.capacity()) * sizeof(std::uint32_t) +
      places_.capacity() * sizeof(Place) + counts_.capacity() * sizeof(Count);
  for (const auto& buffer : buffers_) bytes += sizeof(Buffer) + buffer->memory();
  return bytes;
}

}  // namespace tandem
