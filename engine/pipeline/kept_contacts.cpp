#include "pipeline/kept_contacts.h"

#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

#include "scene/tolerances.h"

namespace tandem {
namespace {

using tolerance::rest_share;

/// The sum of squares of what two matrices differ by.
double squared_distance(const Mat3& now, const Mat3& then) {
  using Eight = Eigen::Map<const Eigen::Array<double, 8, 1>>;  // two at a time
  const double last = now(2, 2) - then(2, 2);
  return (Eight(now.data()) - Eight(then.data())).square().sum() + last * last;
}

Vec3 into(const Pose& frame, const Vec3& world) { return frame.rotation.transpose() * (world - frame.translation); }

/// Whether a body that was at a place when its rest began has no point farther than `reach` from there.
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

/// Inserts from(k) before what is at places[k] (ascending), for all k. Nothing before the first place is touched.
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

/// Where the rows of values begin that lie in the order of their rows; and one past the last.
template <class T, class RowOf>
void count_rows(std::size_t rows, const RowOf& row_of, const std::vector<T>& values,
                std::vector<std::uint32_t>& begins) {
  begins.assign(rows + 1, 0);
  for (const T& value : values) ++begins[row_of(value) + 1];
  for (std::size_t row = 1; row < begins.size(); ++row) begins[row] += begins[row - 1];
}

/// The same once further ones, by rows, have come.
template <class T, class RowOf>
void add_to_rows(const std::vector<T>& values, const RowOf& row_of, std::vector<std::uint32_t>& begins) {
  std::uint32_t before = 0;
  for (std::size_t row = 0; row < begins.size() && !values.empty(); ++row) {
    while (before < values.size() && row_of(values[before]) < row) ++before;
    begins[row] += before;
  }
}

}  // namespace

void KeptContacts::Sums::leave(const Entry& entry, const Largest& its, const Sums& of_all) {
  colliding -= entry.collide ? 1 : 0;
  touching -= entry.touching;
  gaps -= entry.gaps;
  inexact -= entry.inexact ? 1 : 0;
  left_top_depth += its.depth == of_all.depth.value ? 1 : 0;
  left_top_bound += its.error_bound == of_all.error_bound.value ? 1 : 0;
}

void KeptContacts::Sums::enter(const Entry& entry, const Largest& its) {
  colliding += entry.collide ? 1 : 0;
  touching += entry.touching;
  gaps += entry.gaps;
  inexact += entry.inexact ? 1 : 0;
  depth.add(its.depth, 1);
  error_bound.add(its.error_bound, 1);
}

void KeptContacts::Sums::add(const Sums& other) {
  computed += other.computed;
  noted += other.noted;
  colliding += other.colliding;
  touching += other.touching;
  gaps += other.gaps;
  inexact += other.inexact;
  depth.add(other.depth.value, other.depth.pairs);
  error_bound.add(other.error_bound.value, other.error_bound.pairs);
  left_top_depth += other.left_top_depth;
  left_top_bound += other.left_top_bound;
}

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
  // Where most pairs change, what stands goes where they go.
  all_asked_ = !same_bodies_ || 2 * noted_ > candidates_;
  if (all_asked_)
    find_places();
  else if (!restless_known_)
    find_restless();

  resize(bodies);
  const auto shapes = scene.shapes();
  const auto same = [](const Shape& x, const Shape& y) { return x.identity() == y.identity(); };
  if (std::equal(shapes.begin(), shapes.end(), shapes_.begin(), shapes_.end(), same)) return !all_asked_;
  shapes_.clear();  // known again when all are
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
  if (!came_.empty()) came_.resize(bodies);
}

void KeptContacts::look_at(std::size_t first, std::span<std::uint8_t> changed) {
  // By pointers of its own: a byte that is written might else be part of any of them.
  const auto* const shape_of = scene_->shape_indices().data();
  const Pose* const poses = scene_->poses().data();
  const Ball* const balls = balls_.data();
  const Vec3* const places = anchor_places_.data();
  const Mat3* const rotations = anchor_rotations_.data();
  const double* const reaches = reach_.data();
  const std::uint8_t* const came = came_.empty() ? nullptr : came_.data();
  const bool same_bodies = same_bodies_;
  bool any_moved = false;
  for (std::size_t k = 0; k < changed.size(); ++k) {
    if (changed[k] == 0) continue;
    const std::size_t i = first + k;
    const Ball& ball = balls[shape_of[i]];
    if ((same_bodies || is_as_it_was(i, ball)) && rests(poses[i], places[i], rotations[i], ball, reaches[i])) {
      changed[k] = came == nullptr ? 0 : came[i];
    } else {
      end_rest(i, ball);
      any_moved = true;
    }
  }
  if (any_moved) any_moved_.store(true, std::memory_order_relaxed);
}

const void* KeptContacts::shape_now(std::size_t body, const Ball& ball) const {
  return scene_->alive(static_cast<std::uint32_t>(body)) ? ball.shape : nullptr;
}

double KeptContacts::reach_now(std::size_t body, const Ball& ball) const {
  const bool is_endless = !(ball.radius < std::numeric_limits<double>::infinity());
  return scene_->is_static()[body] != 0 || is_endless ? 0 : rest_share * ball.allowed;
}

/// But for its pose. A place without a body is not: whoever looks there for the first time must learn that it is empty.
bool KeptContacts::is_as_it_was(std::size_t body, const Ball& ball) const {
  const void* shape = shape_now(body, ball);
  return shape != nullptr && shape == body_shapes_[body] && reach_now(body, ball) == reach_[body];
}

void KeptContacts::end_rest(std::size_t body, const Ball& ball) {
  const Pose& pose = scene_->poses()[body];
  since_[body] = step_;
  anchor_places_[body] = pose.translation;
  anchor_rotations_[body] = pose.rotation;
  const void* shape = shape_now(body, ball);
  const double reach = reach_now(body, ball);
  if (shape == body_shapes_[body] && reach == reach_[body]) return;
  body_shapes_[body] = shape;
  reach_[body] = reach;
  changed_[body] = step_;
}

void KeptContacts::end_step(ContactList& contacts) {
  complete_ = true;
  came_.clear();
  computed_ = static_cast<std::uint64_t>(told_.computed);
  noted_ = static_cast<std::size_t>(told_.noted);
  if (all_asked_) {
    take_fresh();
    take_over();
    complete_ = listed_pairs_ == contacts.pairs.size();  // else it is not the answer of these pairs
    sums_ = told_;
    return;
  }
  const bool any_moved = any_moved_.load(std::memory_order_relaxed);
  if (any_moved || any_marked_) {
    take_fresh();
    if (any_moved) mark_pairs_of_moved();
    look_through(contacts.pairs.size());
    splicer_.apply(splices_, contacts, last_);
    add_told();
  }
  restless_known_ = true;
  std::swap(last_, contacts);
}

/// Of what stands, in the last step's list.
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

/// Notes which pairs were candidates where all were asked for.
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

/// That both rest, in the answer at `place` of the last step's list if there is one.
void KeptContacts::tell(std::size_t i, Pair pair, std::uint32_t place) {
  Entry& entry = entries_[i];
  entry.told = true;
  if (!entry.reported) return;
  const double rest = rest_bound(pair);
  last_.pairs[place].answer.error_bound += rest;
  largest_[i].error_bound = static_cast<double>(entry.bound) + rest;
}

/// Of a pair that is no candidate any more, all but where its detail lies.
void KeptContacts::forget(std::size_t i) {
  const std::uint32_t detail = entries_[i].detail;
  entries_[i] = {};
  entries_[i].detail = detail;
  largest_[i] = {};
  listed_[i] = 0;
}

/// Drops pairs that are no candidates, once they are many.
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

void KeptContacts::take_fresh() {
  for (const auto& [entry, place] : adopted_) entries_[entry].detail = put_detail(std::move(fresh_details_[place]));
  adopted_.clear();
  forget_gone();
  const auto by_key = [](const Fresh& x, const Fresh& y) { return x.key < y.key; };
  if (!std::is_sorted(fresh_.begin(), fresh_.end(), by_key)) std::sort(fresh_.begin(), fresh_.end(), by_key);
  places_.clear();
  auto place = keys_.begin();
  for (Fresh& fresh : fresh_) {
    if (fresh.entry.detail != none) fresh.entry.detail = put_detail(std::move(fresh_details_[fresh.entry.detail]));
    place = std::lower_bound(place, keys_.end(), fresh.key);
    places_.push_back(static_cast<std::size_t>(place - keys_.begin()));
  }
  insert<std::uint64_t>(
      places_, [this](std::size_t k) { return fresh_[k].key; }, keys_);
  insert<Entry>(
      places_, [this](std::size_t k) { return fresh_[k].entry; }, entries_);
  insert<std::uint8_t>(
      places_, [](std::size_t) { return std::uint8_t{0}; }, listed_);
  insert<std::uint8_t>(
      places_, [](std::size_t) { return std::uint8_t{1}; }, marked_);
  insert<Largest>(
      places_, [this](std::size_t k) { return fresh_[k].largest; }, largest_);
  if (rows_.size() == anchor_places_.size() + 1) {
    add_to_rows(
        fresh_, [](const Fresh& fresh) { return fresh.key >> 32; }, rows_);
  } else {
    find_rows();
  }
  if (all_asked_)
    columns_.clear();  // not needed in such steps
  else if (!fresh_.empty() && !columns_.empty())
    add_columns();
  fresh_.clear();
  fresh_details_.clear();
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

/// For each body those before it that it is a pair with.
void KeptContacts::find_columns() {
  count_rows(
      anchor_places_.size(), [](std::uint64_t key) { return key & none; }, keys_, columns_);
  firsts_.resize(keys_.size());
  for (const std::uint64_t key : keys_) firsts_[columns_[key & none]++] = static_cast<std::uint32_t>(key >> 32);
  // Each has gone to the next one's begin, but the first body's: it comes second in no pair.
  std::shift_right(columns_.begin(), columns_.end(), 1);
}

/// The fresh pairs' to these.
void KeptContacts::add_columns() {
  const auto by_second = [](const Fresh& x, const Fresh& y) { return std::rotl(x.key, 32) < std::rotl(y.key, 32); };
  std::sort(fresh_.begin(), fresh_.end(), by_second);
  places_.clear();
  for (const Fresh& fresh : fresh_) {
    const auto [a, b] = pair_of(fresh.key);
    const auto place = std::lower_bound(firsts_.begin() + columns_[b], firsts_.begin() + columns_[b + 1], a);
    places_.push_back(static_cast<std::size_t>(place - firsts_.begin()));
  }
  insert<std::uint32_t>(
      places_, [this](std::size_t k) { return pair_of(fresh_[k].key).a; }, firsts_);
  add_to_rows(
      fresh_, [](const Fresh& fresh) { return fresh.key & none; }, columns_);
}

/// Where the pair is among those known, or would be.
std::size_t KeptContacts::place_of(Pair pair) const {
  const auto row = [&](std::size_t a) { return keys_.begin() + rows_[a]; };
  return static_cast<std::size_t>(std::lower_bound(row(pair.a), row(pair.a + std::size_t{1}), key_of(pair)) -
                                  keys_.begin());
}

/// How many of the pairs are listed.
std::uint32_t KeptContacts::listed_between(std::size_t first, std::size_t last) const {
  const std::uint8_t* const listed = listed_.data();
  constexpr std::size_t row = 8;
  std::uint64_t count = 0;
  for (; first + row <= last; first += row) {
    std::uint64_t bytes = 0;  // of 0 or 1, summed up by the product's highest
    std::memcpy(&bytes, listed + first, row);
    count += bytes * 0x0101010101010101u >> 56;
  }
  for (; first < last; ++first) count += listed[first];
  return static_cast<std::uint32_t>(count);
}

/// All candidates of bodies that do not rest: those that were not asked for any more are none now.
void KeptContacts::mark_pairs_of_moved() {
  if (columns_.empty()) find_columns();
  for (std::size_t body = 0; body < since_.size(); ++body) {
    if (since_[body] != step_) continue;
    std::fill(marked_.begin() + rows_[body], marked_.begin() + rows_[body + 1], std::uint8_t{1});
    for (std::uint32_t k = columns_[body]; k < columns_[body + 1]; ++k) {
      const std::uint32_t first = firsts_[k];
      if (since_[first] != step_)
        marked_[place_of({first, static_cast<std::uint32_t>(body)})] = 1;  // else it is already
    }
  }
}

/// From `i` on; the end if there is none.
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

/// Goes through the pairs that may not be as they were, and finds where the list changes.
void KeptContacts::look_through([[maybe_unused]] std::size_t answers) {
  splices_.clear();
  restless_.clear();
  any_marked_ = false;
  std::uint32_t at = 0, from = 0;  // in last_, and among the fresh answers
  const auto change = [&](bool removed, bool added) {
    if (!removed && !added) return;
    if (splices_.empty() || splices_.back().at + splices_.back().removed != at) splices_.push_back({at, 0, from, 0});
    splices_.back().removed += removed ? 1 : 0;
    splices_.back().added += added ? 1 : 0;
    from += added ? 1 : 0;
  };
  const auto look = [&](std::size_t i) {
    const Pair pair = pair_of(keys_[i]);
    const bool was_listed = listed_[i] != 0;
    Entry& entry = entries_[i];
    marked_[i] = 0;
    if (entry.as_of == step_) {
      change(was_listed, entry.reported);
      listed_[i] = entry.reported ? 1 : 0;
      candidates_ += entry.candidate ? 0 : 1;
      entry.candidate = true;
      // To be told in the next step that they rest, if they do, or asked for again.
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
    look(i);
  }
  assert(from == answers);
}

/// To the sums over all pairs.
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

// ---- A batch

KeptContacts::Batch::~Batch() {
  const std::scoped_lock lock(all_.mutex_);
  all_.told_.add(sums_);
  if (fresh_details_.size() != 0) {
    const auto first = static_cast<std::uint32_t>(all_.fresh_details_.size());
    for (Fresh& fresh : fresh_)
      if (fresh.entry.detail != none) fresh.entry.detail += first;
    for (auto& [entry, place] : adopted_) all_.adopted_.push_back({entry, place + first});
    std::move(fresh_details_.begin(), fresh_details_.end(), std::back_inserter(all_.fresh_details_));
  }
  all_.fresh_.insert(all_.fresh_.end(), fresh_.begin(), fresh_.end());
}

void KeptContacts::Batch::seek(Pair pair) {
  const std::uint64_t key = key_of(pair);
  const std::vector<std::uint64_t>& keys = all_.keys_;
  entry_ = nullptr;
  if (next_ >= keys.size() || keys[next_] != key) {
    if (pair.a + std::size_t{1} >= all_.rows_.size()) return;
    next_ = all_.place_of(pair);
    if (next_ == keys.size() || keys[next_] != key) return;
  }
  entry_ = &all_.entries_[next_++];
}

std::size_t KeptContacts::Batch::stand(std::span<const Pair> pairs) {
  std::uint32_t begin = 0, end = 0;  // of the last step's list: what is to be appended
  std::size_t count = 0;
  for (; count < pairs.size(); ++count) {
    const Pair pair = pairs[count];
    seek(pair);
    was_candidate_ = entry_ != nullptr && entry_->candidate;
    if (!was_candidate_ || !all_.stands(*entry_, pair)) break;
    Entry& entry = *entry_;
    entry.seen = all_.step_;
    if (!all_.all_asked_) continue;  // it stays where it lies
    const auto index = static_cast<std::size_t>(entry_ - all_.entries_.data());
    const std::uint32_t place = all_.results_[index];
    if (place != end) {
      append(begin, end);
      begin = place;
    }
    end = place + (entry.reported ? 1 : 0);
    if (!entry.told) all_.tell(index, pair, place);
    sums_.enter(entry, all_.largest_[index]);
  }
  append(begin, end);
  moved_ = false;
  detail_ = none;
  return count;
}

void KeptContacts::Batch::append(std::uint32_t begin, std::uint32_t end) {
  if (begin == end) return;
  const auto pairs = std::span(all_.last_.pairs).subspan(begin, end - begin);
  const std::uint32_t from = pairs.front().first_contact, to = pairs.back().first_contact + pairs.back().contact_count;
  const auto moved = static_cast<std::uint32_t>(contacts_.size()) - from;
  const std::size_t first = results_.size();
  results_.insert(results_.end(), pairs.begin(), pairs.end());
  if (moved != 0)
    for (PairResult& result : std::span(results_).subspan(first)) result.first_contact += moved;
  const auto contacts = std::span(all_.last_.contacts).subspan(from, to - from);
  contacts_.insert(contacts_.end(), contacts.begin(), contacts.end());
}

KeptContacts::Batch::Relative KeptContacts::Batch::relative(Pair pair) const {
  const auto shape = all_.scene_->shape_indices();
  const auto poses = all_.scene_->poses();
  // The smaller body moves less at its rim.
  const bool a_is_reference = all_.balls_[shape[pair.a]].radius >= all_.balls_[shape[pair.b]].radius;
  const Pose& reference = poses[a_is_reference ? pair.a : pair.b];
  const Pose& mover = poses[a_is_reference ? pair.b : pair.a];
  return {reference.rotation.transpose() * mover.rotation, into(reference, mover.translation), a_is_reference};
}

// What a pair that follows soon will read.
void KeptContacts::Batch::fetch_ahead() const {
  const std::size_t ahead = next_ + 4;
  if (ahead >= all_.entries_.size() || all_.entries_[ahead].detail == none) return;
  const char* detail = reinterpret_cast<const char*>(&all_.details_[all_.entries_[ahead].detail]);
  for (std::size_t line = 0; line < sizeof(KeptPair); line += 64) __builtin_prefetch(detail + line, 1);
}

bool KeptContacts::Batch::move_along(Pair pair, PairResult& result, const std::function<bool()>& collide) {
  fetch_ahead();
  at_ = relative(pair);
  if (!was_candidate_ || entry_->detail == none || all_.changed_[pair.a] == all_.step_ ||
      all_.changed_[pair.b] == all_.step_)
    return false;
  const KeptPair& kept = all_.details_[entry_->detail];
  const Ball& ball = all_.balls_[all_.scene_->shape_indices()[at_.a_is_reference ? pair.b : pair.a]];
  const Mat3 turned = at_.rotation - kept.rotation;
  const Vec3 moved = turned * ball.centre + (at_.translation - kept.translation);
  // The spectral norm of the difference of two rotations, 2 sin(angle / 2).
  const double angle = turned.norm() / std::sqrt(2.0);
  const double bound = (moved.norm() + angle * ball.radius) * (1 + tolerance::motion_stretch) +
                       tolerance::motion_rounding * (at_.translation.lpNorm<1>() + ball.radius);
  const double distance = std::abs(kept.signed_distance) - kept.error_bound;
  gap_ = distance - bound;
  moved_by_ = 0;
  // An answer from before they rested, moved along, would not stand while they do; computed now it may.
  const double rest = all_.rest_bound(pair);
  const bool may_settle = bound > rest && all_.both_rest(pair);
  if (kept.contacts.empty() && !all_.distances_) {
    moved_ = !kept.collide && gap_ > all_.margin_ + (may_settle ? rest : 0);
    return moved_;
  }
  // The deepest contact of a mesh that overlaps is not continuous in the poses: there is no bound on how far it may be.
  if (kept.collide && kept.status == Status::unproven) return false;
  // The shift along the normal is taken into account: what is left is of second order, but not known to be less than
  // both together. Of the angle something is left for what bodies at rest may turn.
  if (!(2 * bound <= ball.allowed && angle <= 0.99 * all_.tolerance_)) return false;
  if (may_settle && !(rest < gap_ && 2 * bound + rest <= ball.allowed)) return false;
  const bool in_doubt = !(bound < distance);
  // Of two that rest what is computed now will stand.
  if (in_doubt && !(collide && !all_.both_rest(pair) && collide() == kept.collide)) return false;
  moved_ = true;
  moved_by_ = 2 * bound;
  const Pose& frame = all_.scene_->poses()[at_.a_is_reference ? pair.a : pair.b];
  // The mover's point that was at `point`, in the reference's frame, has moved by `turn * point + shift`.
  const Mat3 turn = turned * kept.rotation.transpose();
  const Vec3 shift = at_.translation - kept.translation - turn * kept.translation;
  const double sense = at_.a_is_reference ? 1 : -1;  // normals are from A to B
  const auto opened = [&](const Vec3& normal, const Vec3& point) { return sense * normal.dot(turn * point + shift); };
  PairAnswer& answer = result.answer;
  answer.collide = kept.collide;
  answer.signed_distance = kept.signed_distance + opened(kept.normal, at_.a_is_reference ? kept.point_b : kept.point_a);
  if (in_doubt)
    answer.signed_distance = kept.collide ? std::min(answer.signed_distance, 0.0)
                                          : std::max(answer.signed_distance, std::numeric_limits<double>::min());
  answer.status = kept.status;
  answer.error_bound = kept.error_bound + moved_by_;
  answer.point_a = frame * kept.point_a;
  answer.point_b = frame * kept.point_b;
  answer.normal = frame.rotation * kept.normal;
  kept.contacts.each([&](const Contact& contact) {
    const double depth = std::max(contact.depth - opened(contact.normal, contact.point), -all_.margin_);
    contacts_.push_back({frame * contact.point, frame.rotation * contact.normal, depth, contact.feature});
  });
  return true;
}

void KeptContacts::Batch::keep(const PairResult& result, std::span<const Contact> contacts) {
  const bool is_new = entry_ == nullptr || entry_->detail == none;
  if (is_new) {
    detail_ = static_cast<std::uint32_t>(fresh_details_.size());
    fresh_details_.emplace_back();
    // Else it was of other kinds.
    if (entry_ != nullptr) adopted_.push_back({static_cast<std::uint32_t>(entry_ - all_.entries_.data()), detail_});
  }
  KeptPair& kept = is_new ? fresh_details_.back() : all_.details_[entry_->detail];
  kept.rotation = at_.rotation;
  kept.translation = at_.translation;
  const PairAnswer& answer = result.answer;
  kept.signed_distance = answer.signed_distance;
  kept.error_bound = answer.error_bound;
  kept.collide = answer.collide;
  kept.status = answer.status;
  kept.contacts.clear();
  if (contacts.empty() && !all_.distances_) return;
  const Pose& frame = all_.scene_->poses()[at_.a_is_reference ? result.a : result.b];
  const auto turned = [&](const Vec3& world) -> Vec3 { return frame.rotation.transpose() * world; };
  kept.point_a = into(frame, answer.point_a);
  kept.point_b = into(frame, answer.point_b);
  kept.normal = turned(answer.normal);
  for (const Contact& contact : contacts)
    kept.contacts.add({into(frame, contact.point), turned(contact.normal), contact.depth, contact.feature});
}

void KeptContacts::Batch::note(const PairResult& result, std::span<const Contact> contacts, bool reported) {
  const PairAnswer& answer = result.answer;
  if (!moved_) {
    ++sums_.computed;
    gap_ = std::abs(answer.signed_distance) - answer.error_bound;
    moved_by_ = 0;
  }
  const Pair pair{result.a, result.b};
  const auto shape = all_.scene_->shape_indices();
  Entry* entry = entry_;
  Largest* largest = nullptr;
  if (entry != nullptr) {
    largest = &all_.largest_[static_cast<std::size_t>(entry - all_.entries_.data())];
    all_.marked_[static_cast<std::size_t>(entry - all_.entries_.data())] = 1;
    if (!all_.all_asked_) sums_.leave(*entry, *largest, all_.sums_);
  } else {
    Fresh& fresh = fresh_.emplace_back();
    fresh.key = key_of(pair);
    entry = &fresh.entry;
    entry->detail = detail_;
    largest = &fresh.largest;
  }
  entry->seen = entry->as_of = all_.step_;
  entry->bound = static_cast<float>(moved_by_ * (1 + tolerance::bound_of_floats));
  entry->reported = reported;
  entry->told = false;
  entry->collide = answer.collide;
  entry->inexact = answer.status == Status::inexact;
  entry->touching = entry->gaps = 0;
  *largest = {0, reported ? moved_by_ : 0};
  for (const Contact& contact : contacts) {
    ++(contact.depth < 0 ? entry->gaps : entry->touching);
    largest->depth = std::max(largest->depth, contact.depth);
  }
  const double rest = all_.rest_bound(pair);
  const double allowed = std::min(all_.balls_[shape[pair.a]].allowed, all_.balls_[shape[pair.b]].allowed);
  entry->steady = reported ? moved_by_ + rest <= allowed && rest < gap_ : !answer.collide && gap_ - rest > all_.margin_;
  ++sums_.noted;
  sums_.enter(*entry, *largest);
}

std::size_t KeptContacts::memory() const {
  const auto bytes = [](const auto&... list) { return (std::size_t{0} + ... + (list.capacity() * sizeof(list[0]))); };
  return bytes(shapes_, balls_, anchor_places_, anchor_rotations_, body_shapes_, reach_, since_, changed_, came_) +
         bytes(last_.pairs, last_.contacts, keys_, entries_, listed_, largest_, marked_, rows_, firsts_, columns_) +
         bytes(details_, free_details_, restless_, results_, places_, splices_, fresh_, fresh_details_, adopted_);
}

}  // namespace tandem
