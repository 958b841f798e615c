#include "ordered_answers.h"

#include <algorithm>
#include <array>

#include "pair_order.h"

namespace tandem {
namespace {

/// Differs between any two threads that are at work.
const void* this_thread_mark() {
  static thread_local const char mark = 0;
  return &mark;
}

/// Asks for the lines that are about to be written: stores alone wait for one after the other.
void prefetch_to_write(const void* data, std::size_t bytes) {
#if defined(__GNUC__) && defined(__x86_64__)
  // By hand: unless told of the processor the compiler emits a prefetch for reading.
  for (std::size_t at = 0; at < bytes; at += 64)
    asm volatile("prefetchw %0" : : "m"(static_cast<const char*>(data)[at]));
#else
  static_cast<void>(data);
  static_cast<void>(bytes);
#endif
}

}  // namespace

void OrderedAnswers::begin(std::span<const std::uint64_t> pairs, std::size_t batch_pairs, ContactList& out) {
  pairs_ = pairs;
  batch_pairs_ = batch_pairs;
  batches_ = (pairs.size() + batch_pairs - 1) / batch_pairs;
  out_ = &out;
  places_.resize(batches_ + 1);
  counts_.assign(batches_, {});
  placed_ = 0;
  for (auto* list : {&waiting_, &rest_, &free_}) {
    list->clear();
    list->reserve(buffers_.size() + batches_);
  }
  buffers_.reserve(buffers_.size() + batches_);
  for (const auto& buffer : buffers_) free_.push_back(buffer.get());
}

Batch& OrderedAnswers::take(std::size_t index) {
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
  Batch& batch = *buffer;
  batch.clear(batch_pairs_);
  batch.id = index;
  const auto keys = pairs_.subspan(index * batch_pairs_, std::min(batch_pairs_, pairs_.size() - index * batch_pairs_));
  batch.count = keys.size();
  std::transform(keys.begin(), keys.end(), batch.pairs.begin(), pair_of);
  return batch;
}

void OrderedAnswers::put(Batch& batch) {
  Buffer& buffer = static_cast<Buffer&>(batch);
  std::array<Buffer*, 8> own{};
  std::size_t count = 0;
  {
    const std::scoped_lock lock(mutex_);
    counts_[batch.id] = {batch.results.size(), batch.contacts.size(), &buffer};
    for (; placed_ < batches_ && counts_[placed_].buffer != nullptr; ++placed_) {
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
  out_->pairs.resize(places_[batches_].pair);
  out_->contacts.resize(places_[batches_].contact);
  rest_.insert(rest_.end(), waiting_.begin(), waiting_.end());
  return rest_.size();
}

bool OrderedAnswers::has_room(std::size_t batch) const {
  const Place end = places_[batch + 1];
  return end.pair <= out_->pairs.size() && end.contact <= out_->contacts.size();
}

void OrderedAnswers::copy(const Buffer& buffer) {
  const Place place = places_[buffer.id];
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

}  // namespace tandem
