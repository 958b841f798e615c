#include "ordered_answers.h"

#include <algorithm>
#include <array>

#include "pair_order.h"
#include "thread_mark.h"

namespace tandem {
namespace {

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

void OrderedAnswers::begin(std::span<const std::uint64_t> pairs, BatchPairs batch_pairs,
                           const std::function<bool(Pair)>& is_heavy, ContactList& out) {
  pairs_ = pairs;
  most_ = batch_pairs.most;
  cut(batch_pairs, is_heavy);
  batches_ = first_.size() - 1;
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

void OrderedAnswers::cut(BatchPairs batch_pairs, const std::function<bool(Pair)>& is_heavy) {
  first_.clear();
  heavy_.clear();
  turns_.clear();
  if (!is_heavy) {
    for (std::size_t at = 0; at < pairs_.size(); at += most_) first_.push_back(static_cast<std::uint32_t>(at));
    first_.push_back(static_cast<std::uint32_t>(pairs_.size()));
    return;
  }
  const double light_share = 1.0 / static_cast<double>(most_);
  const double heavy_share = 1.0 / static_cast<double>(std::max(batch_pairs.heavy, std::size_t{1}));
  double full = 1;
  for (std::size_t at = 0; at < pairs_.size(); ++at) {
    if (full > 0.999) {
      first_.push_back(static_cast<std::uint32_t>(at));
      full = 0;
    }
    const bool heavy = is_heavy(pair_of(pairs_[at]));
    full += heavy ? std::max(heavy_share, light_share) : light_share;
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
  Batch& batch = *buffer;
  batch.clear(most_);
  batch.id = index;
  batch.heavy = turn < heavy_.size();
  const auto keys = pairs_.subspan(first_[index], first_[index + 1] - first_[index]);
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
