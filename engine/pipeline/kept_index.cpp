// The table of kept pairs, sorted by (a, b), and the index of each body's entries in it.
#include <algorithm>
#include <bit>
#include <utility>

#include "pipeline/kept_contacts.h"

namespace tandem {
namespace {

/// Inserts from(k) before places[k] (ascending), for all k, and leaves elements before the first place untouched.
template <class T, class From>
void insert(std::span<const std::size_t> places, const From& from, std::vector<T>& values) {
  std::size_t end = values.size();
  values.resize(end + places.size());
  const auto at = [&](std::size_t place) { return values.begin() + static_cast<std::ptrdiff_t>(place); };
  for (std::size_t k = places.size(); k-- > 0; end = places[k]) {
    std::move_backward(at(places[k]), at(end), at(end + k + 1));
    values[places[k] + k] = from(k);
  }
}

/// The begins of rows of values that are sorted by row, and the end of the last.
template <class T, class RowOf>
void count_rows(std::size_t rows, const RowOf& row_of, const std::vector<T>& values,
                std::vector<std::uint32_t>& begins) {
  begins.assign(rows + 1, 0);
  for (const T& value : values) ++begins[row_of(value) + 1];
  for (std::size_t row = 1; row < begins.size(); ++row) begins[row] += begins[row - 1];
}

/// The begins of the rows after the insertion of further values, sorted by row.
template <class T, class RowOf>
void add_to_rows(const std::vector<T>& values, const RowOf& row_of, std::vector<std::uint32_t>& begins) {
  std::uint32_t before = 0;
  for (std::size_t row = 0; row < begins.size() && !values.empty(); ++row) {
    while (before < values.size() && row_of(values[before]) < row) ++before;
    begins[row] += before;
  }
}

}  // namespace

/// Removes pairs that are no longer candidates, once they are many.
void KeptContacts::forget_gone() {
  if (keys_.size() <= candidates_ + candidates_ / 4 + 64) return;
  std::size_t end = 0;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const Entry& entry = entries_[i];
    if (!entry.candidate && entry.as_of != step_) {
      if (entry.detail != none) free_details_.push_back(entry.detail);
      continue;
    }
    keys_[end] = keys_[i];
    entries_[end] = entry;
    listed_[end] = listed_[i];
    marked_[end] = marked_[i];
    largest_[end++] = largest_[i];
  }
  keys_.resize(end);
  entries_.resize(end);
  listed_.resize(end);
  marked_.resize(end);
  largest_.resize(end);
  rows_.clear();
  columns_.clear();
}

void KeptContacts::insert_new_pairs() {
  for (const auto& [entry, place] : adopted_) entries_[entry].detail = put_detail(std::move(new_details_[place]));
  adopted_.clear();
  forget_gone();
  const auto by_key = [](const NewPair& x, const NewPair& y) { return x.key < y.key; };
  if (!std::is_sorted(new_pairs_.begin(), new_pairs_.end(), by_key))
    std::sort(new_pairs_.begin(), new_pairs_.end(), by_key);
  places_.clear();
  auto place = keys_.begin();
  for (NewPair& added : new_pairs_) {
    if (added.entry.detail != none) added.entry.detail = put_detail(std::move(new_details_[added.entry.detail]));
    place = std::lower_bound(place, keys_.end(), added.key);
    places_.push_back(static_cast<std::size_t>(place - keys_.begin()));
  }
  insert<std::uint64_t>(
      places_, [this](std::size_t k) { return new_pairs_[k].key; }, keys_);
  insert<Entry>(
      places_, [this](std::size_t k) { return new_pairs_[k].entry; }, entries_);
  insert<std::uint8_t>(
      places_, [](std::size_t) { return std::uint8_t{0}; }, listed_);
  insert<std::uint8_t>(
      places_, [](std::size_t) { return std::uint8_t{1}; }, marked_);
  insert<Largest>(
      places_, [this](std::size_t k) { return new_pairs_[k].largest; }, largest_);
  if (rows_.size() == anchor_places_.size() + 1) {
    add_to_rows(
        new_pairs_, [](const NewPair& added) { return added.key >> 32; }, rows_);
  } else {
    find_rows();
  }
  if (all_processed_)
    columns_.clear();  // not needed in such steps
  else if (!new_pairs_.empty() && !columns_.empty())
    add_columns();
  new_pairs_.clear();
  new_details_.clear();
}

std::uint32_t KeptContacts::put_detail(KeptPair&& detail) {
  if (free_details_.empty()) {
    details_.push_back(std::move(detail));
    return static_cast<std::uint32_t>(details_.size() - 1);
  }
  const std::uint32_t at = free_details_.back();
  free_details_.pop_back();
  details_[at] = std::move(detail);
  return at;
}

void KeptContacts::find_rows() {
  count_rows(
      anchor_places_.size(), [](std::uint64_t key) { return key >> 32; }, keys_, rows_);
}

/// For each body, its pairs with bodies of smaller index.
void KeptContacts::find_columns() {
  count_rows(
      anchor_places_.size(), [](std::uint64_t key) { return key & none; }, keys_, columns_);
  firsts_.resize(keys_.size());
  for (const std::uint64_t key : keys_) firsts_[columns_[key & none]++] = static_cast<std::uint32_t>(key >> 32);
  // Each begin has moved to the next body's, except the first body's: it is second in no pair.
  std::shift_right(columns_.begin(), columns_.end(), 1);
}

/// Adds the new pairs to the columns.
void KeptContacts::add_columns() {
  const auto by_second = [](const NewPair& x, const NewPair& y) { return std::rotl(x.key, 32) < std::rotl(y.key, 32); };
  std::sort(new_pairs_.begin(), new_pairs_.end(), by_second);
  places_.clear();
  for (const NewPair& added : new_pairs_) {
    const auto [a, b] = pair_of(added.key);
    const auto place = std::lower_bound(firsts_.begin() + columns_[b], firsts_.begin() + columns_[b + 1], a);
    places_.push_back(static_cast<std::size_t>(place - firsts_.begin()));
  }
  insert<std::uint32_t>(
      places_, [this](std::size_t k) { return pair_of(new_pairs_[k].key).a; }, firsts_);
  add_to_rows(
      new_pairs_, [](const NewPair& added) { return added.key & none; }, columns_);
}

/// The place of the pair in the table, or where it would be inserted.
std::size_t KeptContacts::place_of(Pair pair) const {
  const auto row = [&](std::size_t a) { return keys_.begin() + rows_[a]; };
  return static_cast<std::size_t>(std::lower_bound(row(pair.a), row(pair.a + std::size_t{1}), key_of(pair)) -
                                  keys_.begin());
}

}  // namespace tandem
