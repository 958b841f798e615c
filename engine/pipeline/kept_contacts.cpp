// Contact caching over steps: the list of kept answers, and its update.
#include "pipeline/kept_contacts.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <utility>

namespace tandem {

void KeptContacts::clear() {
  last_.pairs.clear();
  last_.contacts.clear();
  keys_.clear();
  entries_.clear();
  listed_.clear();
  largest_.clear();
  marked_.clear();
  rows_.clear();
  columns_.clear();
  details_.clear();
  free_details_.clear();
  restless_.clear();
  candidates_ = 0;
  recorded_ = 0;
  sums_ = {};
  any_marked_ = restless_known_ = false;
  new_pairs_.clear();
  new_details_.clear();
  adopted_.clear();
}

bool KeptContacts::begin_step(const Scene& scene, ContactList& contacts, bool same_bodies, const WorkLimit& limit) {
  std::swap(last_, contacts);
  const std::size_t bodies = scene.indices();
  const bool was_complete = std::exchange(complete_, false);
  const bool known = ++step_ != none && was_complete && bodies >= anchor_places_.size();
  if (!known) clear();
  if (step_ == none || bodies < anchor_places_.size()) {
    anchor_places_.clear();
    anchor_rotations_.clear();
    body_shapes_.clear();
  }
  if (step_ == none) step_ = 1;
  scene_ = &scene;
  batch_sums_ = {};
  any_moved_.store(false, std::memory_order_relaxed);
  same_bodies_ = known && same_bodies;
  // Where most pairs change, kept answers are copied with the others.
  all_processed_ = !same_bodies_ || 2 * recorded_ > candidates_;
  if (all_processed_)
    find_places();
  else if (!restless_known_)
    find_restless();

  resize(bodies);
  const auto shapes = scene.shapes();
  const auto same = [](const Shape& x, const Shape& y) { return x.identity() == y.identity(); };
  if (std::equal(shapes.begin(), shapes.end(), shapes_.begin(), shapes_.end(), same)) return !all_processed_;
  shapes_.clear();  // filled again when all bodies are known
  balls_.clear();
  for (const Shape& shape : shapes) {
    if (!shape.is_bounded()) {
      constexpr double endless = std::numeric_limits<double>::infinity();
      balls_.push_back({shape.identity(), Vec3::Zero(), true, false, endless, endless});
      continue;
    }
    const Bounds box = shape.bounds({}, &limit);
    const Vec3 centre = (box.lo + box.hi) / 2;
    const bool is_round = shape.kind() == ShapeKind::sphere;
    balls_.push_back({shape.identity(), centre, centre.isZero(0), is_round, (box.hi - box.lo).norm() / 2,
                      tolerance_ * shape.size()});
  }
  shapes_.assign(shapes.begin(), shapes.end());
  return !all_processed_;
}

void KeptContacts::resize(std::size_t bodies) {
  anchor_places_.resize(bodies, Vec3::Zero());
  anchor_rotations_.resize(bodies, Mat3::Identity());
  body_shapes_.resize(bodies);
  reach_.resize(bodies);
  since_.resize(bodies);
  changed_.resize(bodies);
  if (!arrived_.empty()) arrived_.resize(bodies);
}

void KeptContacts::end_step(ContactList& contacts) {
  complete_ = true;
  arrived_.clear();
  computed_ = static_cast<std::uint64_t>(batch_sums_.computed);
  recorded_ = static_cast<std::size_t>(batch_sums_.recorded);
  if (all_processed_) {
    insert_new_pairs();
    take_over();
    complete_ = listed_pairs_ == contacts.pairs.size();  // otherwise the list is not the answer for these pairs
    sums_ = batch_sums_;
    return;
  }
  const bool any_moved = any_moved_.load(std::memory_order_relaxed);
  if (any_moved || any_marked_) {
    insert_new_pairs();
    if (any_moved) mark_pairs_of_moved();
    update_list(contacts.pairs.size());
    splicer_.apply(splices_, contacts, last_);
    add_batch_sums();
  }
  restless_known_ = true;
  std::swap(last_, contacts);
}

/// The place in the last step's list of each answer that remains valid.
void KeptContacts::find_places() {
  results_.resize(listed_.size());
  std::uint32_t place = 0;
  for (std::size_t i = 0; i < listed_.size(); ++i) results_[i] = std::exchange(place, place + listed_[i]);
}

void KeptContacts::find_restless() {
  restless_.clear();
  for (std::size_t i = 0; i < keys_.size(); ++i)
    if (entries_[i].candidate && !entries_[i].steady) restless_.push_back(pair_of(keys_[i]));
}

/// Records which pairs were candidates, when all were processed.
void KeptContacts::take_over() {
  candidates_ = listed_pairs_ = 0;
  any_marked_ = restless_known_ = false;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    Entry& entry = entries_[i];
    const bool is_candidate = entry.seen == step_;
    listed_[i] = is_candidate && entry.reported ? 1 : 0;
    listed_pairs_ += listed_[i];
    candidates_ += is_candidate ? 1 : 0;
    if (!is_candidate && entry.candidate) forget(i);
    entry.candidate = is_candidate;
    marked_[i] = is_candidate && !entry.resting ? 1 : 0;
    any_marked_ = any_marked_ || marked_[i] != 0;
  }
}

/// Marks the answer at `place` of the last step's list, if any, as that of two resting bodies.
void KeptContacts::mark_resting(std::size_t i, Pair pair, std::uint32_t place) {
  Entry& entry = entries_[i];
  entry.resting = true;
  if (!entry.reported) return;
  const double rest = rest_bound(pair);
  last_.pairs[place].answer.error_bound += rest;
  largest_[i].error_bound = static_cast<double>(entry.bound) + rest;
}

/// Clears the entry of a pair that is no longer a candidate, except the index of its detail.
void KeptContacts::forget(std::size_t i) {
  const std::uint32_t detail = entries_[i].detail;
  entries_[i] = {};
  entries_[i].detail = detail;
  largest_[i] = {};
  listed_[i] = 0;
}

/// The number of listed pairs in the range.
std::uint32_t KeptContacts::listed_between(std::size_t first, std::size_t last) const {
  const std::uint8_t* const listed = listed_.data();
  constexpr std::size_t row = 8;
  std::uint64_t count = 0;
  for (; first + row <= last; first += row) {
    std::uint64_t bytes = 0;  // of 0 or 1; the product's highest byte is their sum
    std::memcpy(&bytes, listed + first, row);
    count += bytes * 0x0101010101010101u >> 56;
  }
  for (; first < last; ++first) count += listed[first];
  return static_cast<std::uint32_t>(count);
}

/// Marks all candidates of bodies that do not rest: those not reported in this step are no longer candidates.
void KeptContacts::mark_pairs_of_moved() {
  if (columns_.empty()) find_columns();
  for (std::size_t body = 0; body < since_.size(); ++body) {
    if (since_[body] != step_) continue;
    std::fill(marked_.begin() + rows_[body], marked_.begin() + rows_[body + 1], std::uint8_t{1});
    for (std::uint32_t k = columns_[body]; k < columns_[body + 1]; ++k) {
      const std::uint32_t first = firsts_[k];
      if (since_[first] != step_)
        marked_[place_of({first, static_cast<std::uint32_t>(body)})] = 1;  // otherwise it is already marked
    }
  }
}

/// The next marked pair from `i` on; the end if there is none.
std::size_t KeptContacts::next_marked(std::size_t i) const {
  const std::uint8_t* const marked = marked_.data();
  const std::size_t end = marked_.size();
  constexpr std::size_t row = 8;
  for (; i + row <= end; i += row) {
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, marked + i, row);
    if (bytes != 0) break;
  }
  while (i < end && marked[i] == 0) ++i;
  return i;
}

/// Processes the marked pairs, and determines the changes of the list.
void KeptContacts::update_list([[maybe_unused]] std::size_t answers) {
  splices_.clear();
  restless_.clear();
  any_marked_ = false;
  std::uint32_t at = 0, from = 0;  // positions in last_ and among the fresh answers
  const auto change = [&](bool removed, bool added) {
    if (!removed && !added) return;
    if (splices_.empty() || splices_.back().at + splices_.back().removed != at) splices_.push_back({at, 0, from, 0});
    splices_.back().removed += removed ? 1 : 0;
    splices_.back().added += added ? 1 : 0;
    from += added ? 1 : 0;
  };
  const auto update = [&](std::size_t i) {
    const Pair pair = pair_of(keys_[i]);
    const bool was_listed = listed_[i] != 0;
    Entry& entry = entries_[i];
    marked_[i] = 0;
    if (entry.as_of == step_) {
      change(was_listed, entry.reported);
      listed_[i] = entry.reported ? 1 : 0;
      candidates_ += entry.candidate ? 0 : 1;
      entry.candidate = true;
      // The next step marks the answer as resting, if both rest, or processes the pair again.
      marked_[i] = 1;
      any_marked_ = true;
      if (!entry.steady) restless_.push_back(pair);
    } else if (entry.candidate && (entry.seen == step_ || both_rest(pair))) {
      if (!entry.resting) {
        batch_sums_.leave(entry, largest_[i], sums_);
        mark_resting(i, pair, at);
        batch_sums_.enter(entry, largest_[i]);
      }
    } else if (entry.candidate) {
      change(was_listed, false);
      --candidates_;
      batch_sums_.leave(entry, largest_[i], sums_);
      forget(i);
    }
    at += was_listed ? 1 : 0;
  };
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (marked_[i] == 0) {
      const std::size_t next = next_marked(i);
      at += listed_between(i, next);
      i = next;
      if (i == keys_.size()) break;
    }
    update(i);
  }
  assert(from == answers);
}

/// Adds the batches' reports to the sums over all pairs.
void KeptContacts::add_batch_sums() {
  sums_.depth.pairs -= batch_sums_.left_top_depth;
  sums_.error_bound.pairs -= batch_sums_.left_top_bound;
  sums_.add(batch_sums_);
  if (sums_.depth.pairs > 0 && sums_.error_bound.pairs > 0) return;
  sums_.depth = sums_.error_bound = {};
  for (const Largest& its : largest_) {
    sums_.depth.add(its.depth, 1);
    sums_.error_bound.add(its.error_bound, 1);
  }
}

KeptContacts::Counts KeptContacts::counts() const {
  const auto count = [](std::int64_t sum) { return static_cast<std::uint64_t>(sum); };
  return {candidates_,          computed_,         count(sums_.colliding), count(sums_.touching), count(sums_.gaps),
          count(sums_.inexact), sums_.depth.value, sums_.error_bound.value};
}

std::size_t KeptContacts::memory() const {
  const auto bytes = [](const auto&... list) { return (std::size_t{0} + ... + (list.capacity() * sizeof(list[0]))); };
  return bytes(shapes_, balls_, anchor_places_, anchor_rotations_, body_shapes_, reach_, since_, changed_, arrived_) +
         bytes(last_.pairs, last_.contacts, keys_, entries_, listed_, largest_, marked_, rows_, firsts_, columns_) +
         bytes(details_, free_details_, restless_, results_, places_, splices_, new_pairs_, new_details_, adopted_);
}

}  // namespace tandem
