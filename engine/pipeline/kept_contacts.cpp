// Contact caching over steps: rests of bodies, the list of kept answers, and its update.
#include "pipeline/kept_contacts.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>
#include <utility>

#include "scene/tolerances.h"

namespace tandem {
namespace {

using tolerance::rest_share;

/// The sum of squares of the difference of two matrices.
double squared_distance(const Mat3& now, const Mat3& then) {
  using Eight = Eigen::Map<const Eigen::Array<double, 8, 1>>;  // two at a time
  const double last = now(2, 2) - then(2, 2);
  return (Eight(now.data()) - Eight(then.data())).square().sum() + last * last;
}

/// Whether all points of a body are within `reach` of where they were when its rest began.
bool rests(const Pose& pose, const Vec3& place, const Mat3& rotation, const KeptContacts::Ball& ball, double reach) {
  const Vec3 moved = pose.translation - place;
  if (reach == 0) return moved.isZero(0) && pose.rotation == rotation;
  const double far = 0.99 * reach * reach;
  if (ball.is_round) return 2 * moved.squaredNorm() <= far;
  const Vec3 centre_moved = ball.is_centred ? moved : moved + (pose.rotation - rotation) * ball.centre;
  // The spectral norm of a difference of rotations is its Frobenius norm over the root of 2. (x + y)^2 <= 2 (x^2 +
  // y^2).
  const double turned = squared_distance(pose.rotation, rotation) * (ball.radius * ball.radius);
  return 2 * centre_moved.squaredNorm() + turned <= far;
}

}  // namespace

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
  noted_ = 0;
  sums_ = {};
  any_marked_ = restless_known_ = false;
  fresh_.clear();
  fresh_details_.clear();
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
  told_ = {};
  any_moved_.store(false, std::memory_order_relaxed);
  same_bodies_ = known && same_bodies;
  // Where most pairs change, kept answers are copied with the others.
  all_asked_ = !same_bodies_ || 2 * noted_ > candidates_;
  if (all_asked_)
    find_places();
  else if (!restless_known_)
    find_restless();

  resize(bodies);
  const auto shapes = scene.shapes();
  const auto same = [](const Shape& x, const Shape& y) { return x.identity() == y.identity(); };
  if (std::equal(shapes.begin(), shapes.end(), shapes_.begin(), shapes_.end(), same)) return !all_asked_;
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
  return !all_asked_;
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

void KeptContacts::update_rests(std::size_t first, std::span<std::uint8_t> changed) {
  // Local pointers: to the compiler, a written byte might alias any member.
  const auto* const shape_of = scene_->shape_indices().data();
  const Pose* const poses = scene_->poses().data();
  const Ball* const balls = balls_.data();
  const Vec3* const places = anchor_places_.data();
  const Mat3* const rotations = anchor_rotations_.data();
  const double* const reaches = reach_.data();
  const std::uint8_t* const arrived = arrived_.empty() ? nullptr : arrived_.data();
  const bool same_bodies = same_bodies_;
  bool any_moved = false;
  for (std::size_t k = 0; k < changed.size(); ++k) {
    if (changed[k] == 0) continue;
    const std::size_t i = first + k;
    const Ball& ball = balls[shape_of[i]];
    if ((same_bodies || is_as_it_was(i, ball)) && rests(poses[i], places[i], rotations[i], ball, reaches[i])) {
      changed[k] = arrived == nullptr ? 0 : arrived[i];
    } else {
      end_rest(i, ball);
      any_moved = true;
    }
  }
  if (any_moved) any_moved_.store(true, std::memory_order_relaxed);
}

std::uint64_t KeptContacts::shape_now(std::size_t body, const Ball& ball) const {
  return scene_->alive(static_cast<std::uint32_t>(body)) ? ball.shape : 0;
}

double KeptContacts::reach_now(std::size_t body, const Ball& ball) const {
  const bool is_endless = !(ball.radius < std::numeric_limits<double>::infinity());
  return scene_->is_static()[body] != 0 || is_endless ? 0 : rest_share * ball.allowed;
}

/// But for its pose. A place without a body is not: whoever reads it for the first time must learn that it is empty.
bool KeptContacts::is_as_it_was(std::size_t body, const Ball& ball) const {
  const std::uint64_t shape = shape_now(body, ball);
  return shape != 0 && shape == body_shapes_[body] && reach_now(body, ball) == reach_[body];
}

void KeptContacts::end_rest(std::size_t body, const Ball& ball) {
  const Pose& pose = scene_->poses()[body];
  since_[body] = step_;
  anchor_places_[body] = pose.translation;
  anchor_rotations_[body] = pose.rotation;
  const std::uint64_t shape = shape_now(body, ball);
  const double reach = reach_now(body, ball);
  if (shape == body_shapes_[body] && reach == reach_[body]) return;
  body_shapes_[body] = shape;
  reach_[body] = reach;
  changed_[body] = step_;
}

void KeptContacts::end_step(ContactList& contacts) {
  complete_ = true;
  arrived_.clear();
  computed_ = static_cast<std::uint64_t>(told_.computed);
  noted_ = static_cast<std::size_t>(told_.noted);
  if (all_asked_) {
    take_fresh();
    take_over();
    complete_ = listed_pairs_ == contacts.pairs.size();  // otherwise the list is not the answer for these pairs
    sums_ = told_;
    return;
  }
  const bool any_moved = any_moved_.load(std::memory_order_relaxed);
  if (any_moved || any_marked_) {
    take_fresh();
    if (any_moved) mark_pairs_of_moved();
    update_list(contacts.pairs.size());
    splicer_.apply(splices_, contacts, last_);
    add_told();
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
    marked_[i] = is_candidate && !entry.told ? 1 : 0;
    any_marked_ = any_marked_ || marked_[i] != 0;
  }
}

/// Marks the answer at `place` of the last step's list, if any, as that of two resting bodies.
void KeptContacts::tell(std::size_t i, Pair pair, std::uint32_t place) {
  Entry& entry = entries_[i];
  entry.told = true;
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
      if (!entry.told) {
        told_.leave(entry, largest_[i], sums_);
        tell(i, pair, at);
        told_.enter(entry, largest_[i]);
      }
    } else if (entry.candidate) {
      change(was_listed, false);
      --candidates_;
      told_.leave(entry, largest_[i], sums_);
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
void KeptContacts::add_told() {
  sums_.depth.pairs -= told_.left_top_depth;
  sums_.error_bound.pairs -= told_.left_top_bound;
  sums_.add(told_);
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
         bytes(details_, free_details_, restless_, results_, places_, splices_, fresh_, fresh_details_, adopted_);
}

}  // namespace tandem
