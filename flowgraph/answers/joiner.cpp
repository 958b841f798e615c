// Puts the answers of all threads into canonical order: a bucket for each first body, buckets sorted in parallel.
#include "tandem/flowgraph/joiner.h"

#include <algorithm>

#include "answers/key_sort.h"

namespace tandem {
namespace {

void prefetch(const void* data, std::size_t bytes) {
  for (std::size_t at = 0; at < bytes; at += 64) __builtin_prefetch(static_cast<const char*>(data) + at);
}

}  // namespace

void Joiner::begin(std::size_t bodies, ContactList& out) {
  out_ = &out;
  total_ = 0;
  if (cursor_.size() != bodies)
    cursor_ = std::vector<std::atomic<std::uint32_t>>(bodies);
  else
    for (auto& count : cursor_) count.store(0, std::memory_order_relaxed);
}

void Joiner::count(std::span<const PairResult> results) {
  for (std::size_t i = 0; i < results.size();) {
    // Pairs with the same a mostly come one after the other: one addition for all of them keeps threads from contending
    // for the counters.
    std::uint32_t run = 0;
    const std::uint32_t a = results[i].a;
    for (; i < results.size() && results[i].a == a; ++i) ++run;
    cursor_[a].fetch_add(run, std::memory_order_relaxed);
  }
}

void Joiner::join(std::span<AnswerChunk* const> answers, std::size_t bodies, ContactList& out) {
  begin(bodies, out);
  for (const AnswerChunk* chunk : answers) count(chunk->results);
  take(answers);
  for (std::size_t stage = 0; stage < stages; ++stage)
    for (std::size_t block = 0, end = blocks(stage); block < end; ++block) run(stage, block);
}

std::size_t Joiner::blocks(std::size_t stage) const {
  switch (stage) {
    case 0:
    case 4:
      return 1;
    case 1:
      return answers_.size();
    default:
      return (total_ + pairs_a_block - 1) / pairs_a_block;
  }
}

void Joiner::run(std::size_t stage, std::size_t block) {
  switch (stage) {
    case 0:
      return prefix();
    case 1:
      return scatter(block);
    case 2:
      return sort(block);
    case 3:
      return count_contacts(block);
    case 4:
      return prefix_contacts();
    default:
      return copy(block);
  }
}

void Joiner::prefix() {
  std::uint32_t sum = 0;
  for (auto& count : cursor_) {
    const std::uint32_t here = count.load(std::memory_order_relaxed);
    count.store(sum, std::memory_order_relaxed);
    sum += here;
  }
  total_ = sum;
  refs_.resize(total_);
  spare_.resize(total_);
  out_->pairs.resize(total_);
  block_contacts_.resize(blocks(2));
}

void Joiner::scatter(std::size_t block) {
  const auto& results = answers_[block]->results;
  for (std::size_t k = 0; k < results.size();) {
    const std::uint32_t a = results[k].a;
    std::size_t run_end = k;
    while (run_end < results.size() && results[run_end].a == a) ++run_end;
    const auto run = static_cast<std::uint32_t>(run_end - k);
    for (std::size_t at = cursor_[a].fetch_add(run, std::memory_order_relaxed); k < run_end; ++k, ++at)
      refs_[at] = {results[k].b, results[k].contact_count, &results[k],
                   answers_[block]->contacts.data() + results[k].first_contact};
  }
}

Joiner::Range Joiner::buckets(std::size_t block) const {
  // The bucket that begins at or after a position is the one after the last that ends before it.
  const auto first_from = [this](std::size_t position) {
    if (position == 0) return std::size_t{0};
    const auto at = std::lower_bound(cursor_.begin(), cursor_.end(), position, [](const auto& end, std::size_t p) {
      return end.load(std::memory_order_relaxed) < p;
    });
    return std::min(static_cast<std::size_t>(at - cursor_.begin()) + 1, cursor_.size());
  };
  return {first_from(block * pairs_a_block), first_from(std::min(total_, (block + 1) * pairs_a_block))};
}

// For one a each b occurs once, so the sorted order does not depend on the order in which threads filled the bucket.
void Joiner::sort(std::size_t block) {
  const Range own = buckets(block);
  for (std::size_t a = own.begin; a < own.end; ++a) {
    const std::size_t begin = bucket_begin(a), count = bucket_end(a) - begin;
    sort_by_key(std::span(refs_).subspan(begin, count), std::span(spare_).subspan(begin, count),
                [](const Ref& ref) { return ref.b; });
  }
}

void Joiner::count_contacts(std::size_t block) {
  std::uint32_t sum = 0;
  for (std::size_t i = block * pairs_a_block, end = std::min(total_, i + pairs_a_block); i < end; ++i)
    sum += refs_[i].contacts;
  block_contacts_[block] = sum;
}

void Joiner::prefix_contacts() {
  std::uint32_t sum = 0;
  for (std::uint32_t& contacts : block_contacts_) {
    const std::uint32_t here = contacts;
    contacts = sum;
    sum += here;
  }
  out_->contacts.resize(sum);
}

void Joiner::copy(std::size_t block) {
  std::uint32_t next_contact = block_contacts_[block];
  // The results were written by other threads' cores, so each copy would wait for its cache line: prefetch in the order
  // of reading.
  constexpr std::size_t ahead = 8;
  for (std::size_t i = block * pairs_a_block, end = std::min(total_, i + pairs_a_block); i < end; ++i) {
    const Ref& from = refs_[i];
    if (i + ahead < end) {
      prefetch(refs_[i + ahead].result, sizeof(PairResult));
      prefetch(refs_[i + ahead].first, refs_[i + ahead].contacts * sizeof(Contact));
    }
    out_->pairs[i] = *from.result;
    out_->pairs[i].first_contact = next_contact;
    std::copy(from.first, from.first + from.contacts, out_->contacts.begin() + next_contact);
    next_contact += from.contacts;
  }
}

std::size_t Joiner::memory() const {
  return cursor_.capacity() * sizeof(cursor_[0]) + (refs_.capacity() + spare_.capacity()) * sizeof(Ref) +
         block_contacts_.capacity() * sizeof(block_contacts_[0]);
}

}  // namespace tandem
