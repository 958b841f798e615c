#include "joiner.h"

#include <algorithm>

namespace tandem {

namespace {

/// Counts become the positions at which each bucket begins; returns the sum.
std::uint32_t exclusive_prefix(std::vector<std::atomic<std::uint32_t>>& counts) {
  std::uint32_t sum = 0;
  for (auto& count : counts) {
    const std::uint32_t here = count.load(std::memory_order_relaxed);
    count.store(sum, std::memory_order_relaxed);
    sum += here;
  }
  return sum;
}

std::uint32_t next(std::atomic<std::uint32_t>& counter) { return counter.fetch_add(1, std::memory_order_relaxed); }

}  // namespace

void Joiner::begin(std::size_t bodies, ContactList& out) {
  out_ = &out;
  total_ = 0;
  if (cursor_a_.size() != bodies) {
    cursor_a_ = std::vector<std::atomic<std::uint32_t>>(bodies);
    cursor_b_ = std::vector<std::atomic<std::uint32_t>>(bodies);
  } else {
    for (std::size_t i = 0; i < bodies; ++i) {
      cursor_a_[i].store(0, std::memory_order_relaxed);
      cursor_b_[i].store(0, std::memory_order_relaxed);
    }
  }
}

void Joiner::count(const Batch& batch) {
  const auto& results = batch.results;
  for (std::size_t i = 0; i < results.size();) {
    // Pairs of one a mostly come together: one addition for all of them keeps threads off each other's counters.
    std::uint32_t run = 0;
    const std::uint32_t a = results[i].a;
    for (; i < results.size() && results[i].a == a; ++i, ++run) next(cursor_b_[results[i].b]);
    cursor_a_[a].fetch_add(run, std::memory_order_relaxed);
  }
}

std::size_t Joiner::blocks(std::size_t stage) const {
  switch (stage) {
    case 0:
    case 2:
    case 4:
      return 1;
    case 1:
      return (batches_.size() + batches_a_block - 1) / batches_a_block;
    default:
      return (total_ + pairs_a_block - 1) / pairs_a_block;
  }
}

void Joiner::run(std::size_t stage, std::size_t block) {
  switch (stage) {
    case 0:
      return prefix();
    case 1:
      return scatter_by_b(block);
    case 2:
      return scatter_by_a();
    case 3:
      return count_contacts(block);
    case 4:
      return prefix_contacts();
    default:
      return copy(block);
  }
}

void Joiner::prefix() {
  exclusive_prefix(cursor_a_);
  total_ = exclusive_prefix(cursor_b_);
  by_b_.resize(total_);
  sorted_.resize(total_);
  out_->pairs.resize(total_);
  block_contacts_.resize(blocks(3));
}

void Joiner::scatter_by_b(std::size_t block) {
  for (std::size_t i = block * batches_a_block, end = std::min(batches_.size(), i + batches_a_block); i < end; ++i) {
    const auto& results = batches_[i]->results;
    for (std::size_t k = 0; k < results.size(); ++k)
      by_b_[next(cursor_b_[results[k].b])] = {results[k].a, static_cast<std::uint32_t>(i),
                                              static_cast<std::uint32_t>(k), results[k].contact_count};
  }
}

// Within one b each a occurs once, so that the order in which threads filled a bucket leaves no trace here.
void Joiner::scatter_by_a() {
  for (const Ref& ref : by_b_) sorted_[next(cursor_a_[ref.a])] = ref;
}

void Joiner::count_contacts(std::size_t block) {
  std::uint32_t sum = 0;
  for (std::size_t i = block * pairs_a_block, end = std::min(total_, i + pairs_a_block); i < end; ++i)
    sum += sorted_[i].contacts;
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
  for (std::size_t i = block * pairs_a_block, end = std::min(total_, i + pairs_a_block); i < end; ++i) {
    const PairResult& from = result(sorted_[i]);
    PairResult& to = out_->pairs[i];
    to = from;
    to.first_contact = next_contact;
    const auto first = batches_[sorted_[i].batch]->contacts.begin() + from.first_contact;
    std::copy(first, first + from.contact_count, out_->contacts.begin() + next_contact);
    next_contact += from.contact_count;
  }
}

}  // namespace tandem
