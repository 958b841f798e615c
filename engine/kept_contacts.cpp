#include "kept_contacts.h"

#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace tandem {
namespace {

/// How far a body at rest may be from where its rest began, of what the tolerance allows. A body that hangs in a
/// contact held constant drifts so far and no farther before it is looked at again.
constexpr double rest_share = 1e-3;

Vec3 into(const Pose& frame, const Vec3& world) { return frame.rotation.transpose() * (world - frame.translation); }

template <class T>
void raise(std::atomic<T>& to, T value) {
  T known = to.load(std::memory_order_relaxed);
  while (known < value && !to.compare_exchange_weak(known, value, std::memory_order_relaxed)) {
  }
}

}  // namespace

void KeptContacts::clear() {
  entries_.clear();
  rows_.clear();
  details_.clear();
  free_details_.clear();
  fresh_.clear();
  fresh_details_.clear();
}

void KeptContacts::begin_step(const Scene& scene, ContactList& contacts) {
  if (!std::exchange(complete_, false)) clear();
  if (++step_ == none) {
    clear();
    bodies_.clear();
    step_ = 1;
  }
  scene_ = &scene;
  std::swap(last_, contacts);
  for (auto* count : {&kept_, &standing_, &computed_}) count->store(0, std::memory_order_relaxed);
  error_bound_.store(0, std::memory_order_relaxed);

  const std::size_t bodies = scene.indices();
  bodies_.resize(bodies);
  reach_.resize(bodies);
  since_.resize(bodies);
  changed_.resize(bodies);
  const auto shapes = scene.shapes();
  const auto same = [](const Shape& x, const Shape& y) { return &x.mass() == &y.mass(); };
  if (std::equal(shapes.begin(), shapes.end(), shapes_.begin(), shapes_.end(), same)) return;
  shapes_.assign(shapes.begin(), shapes.end());
  balls_.clear();
  for (const Shape& shape : shapes_) {
    if (!shape.is_bounded()) {
      constexpr double endless = std::numeric_limits<double>::infinity();
      balls_.push_back({&shape.mass(), Vec3::Zero(), endless, endless});
      continue;
    }
    const Bounds box = shape.bounds({});
    balls_.push_back({&shape.mass(), (box.lo + box.hi) / 2, (box.hi - box.lo).norm() / 2, tolerance_ * shape.size()});
  }
}

bool KeptContacts::rests(const Body& body, const Pose& pose, const Ball& ball, double reach) const {
  const Mat3 turned = pose.rotation - body.anchor.rotation;
  const Vec3 shift = pose.translation - body.anchor.translation;
  if (reach == 0) return turned.isZero(0) && shift.isZero(0);
  // The spectral norm of a difference of rotations is its Frobenius norm over the root of 2. (x + y)^2 <= 2 (x^2 +
  // y^2).
  const Vec3 moved = turned * ball.centre + shift;
  return 2 * moved.squaredNorm() + turned.squaredNorm() * (ball.radius * ball.radius) <= 0.99 * reach * reach;
}

bool KeptContacts::look_at(std::size_t first, std::size_t count) {
  const auto indices = scene_->shape_indices();
  const auto poses = scene_->poses();
  const auto is_static = scene_->is_static();
  bool all_rest = true;
  for (std::size_t i = first; i < first + count; ++i) {
    Body& body = bodies_[i];
    const Ball& ball = balls_[indices[i]];
    const MassProperties* shape = scene_->alive(static_cast<std::uint32_t>(i)) ? ball.shape : nullptr;
    const double reach =
        is_static[i] != 0 || !(ball.radius < std::numeric_limits<double>::infinity()) ? 0 : rest_share * ball.allowed;
    const bool same = shape == body.shape && reach == reach_[i];
    if (same && rests(body, poses[i], ball, reach)) continue;
    all_rest = false;
    since_[i] = step_;
    body.anchor = poses[i];
    if (same) continue;
    body.shape = shape;
    reach_[i] = reach;
    changed_[i] = step_;
  }
  return !all_rest;
}

void KeptContacts::end_step(const ContactList& contacts) {
  complete_ = true;
  const std::size_t candidates = kept_.load(std::memory_order_relaxed) + computed_.load(std::memory_order_relaxed);
  // All that was there stands: so do its places.
  if (fresh_.empty() && standing_.load(std::memory_order_relaxed) == candidates && candidates == entries_.size())
    return;
  // Pairs that are candidates no more: gone with the next that are new, or once they are as many as the others.
  if (!fresh_.empty() || entries_.size() > 2 * candidates + 64) merge();
  std::uint32_t place = 0;
  for (Entry& entry : entries_)
    if (entry.seen == step_) entry.result = std::exchange(place, place + (entry.reported ? 1 : 0));
  if (place != contacts.pairs.size()) clear();  // not the answer of these pairs
}

void KeptContacts::merge() {
  std::sort(fresh_.begin(), fresh_.end(), [](const Entry& x, const Entry& y) { return x.key < y.key; });
  merged_.clear();
  merged_.reserve(entries_.size() + fresh_.size());
  auto fresh = fresh_.begin();
  const auto take_fresh = [&] {
    Entry& entry = merged_.emplace_back(*fresh++);
    if (entry.detail == none) return;
    KeptPair& detail = fresh_details_[entry.detail];
    if (free_details_.empty()) {
      entry.detail = static_cast<std::uint32_t>(details_.size());
      details_.push_back(std::move(detail));
    } else {
      entry.detail = free_details_.back();
      free_details_.pop_back();
      details_[entry.detail] = std::move(detail);
    }
  };
  for (const Entry& entry : entries_) {
    if (entry.seen != step_) {
      if (entry.detail != none) free_details_.push_back(entry.detail);
      continue;
    }
    while (fresh != fresh_.end() && fresh->key < entry.key) take_fresh();
    merged_.push_back(entry);
  }
  while (fresh != fresh_.end()) take_fresh();
  fresh_.clear();
  fresh_details_.clear();
  entries_.swap(merged_);

  rows_.assign(bodies_.size() + 1, 0);
  for (const Entry& entry : entries_) ++rows_[(entry.key >> 32) + 1];
  for (std::size_t i = 1; i < rows_.size(); ++i) rows_[i] += rows_[i - 1];
}

KeptContacts::Counts KeptContacts::counts() const {
  return {kept_.load(std::memory_order_relaxed), computed_.load(std::memory_order_relaxed),
          error_bound_.load(std::memory_order_relaxed)};
}

// ---- A batch

KeptContacts::Batch::~Batch() {
  all_.kept_.fetch_add(kept_, std::memory_order_relaxed);
  all_.standing_.fetch_add(standing_, std::memory_order_relaxed);
  all_.computed_.fetch_add(computed_, std::memory_order_relaxed);
  raise(all_.error_bound_, error_bound_);
  if (fresh_.empty()) return;
  const std::scoped_lock lock(all_.mutex_);
  for (Entry& entry : fresh_)
    if (entry.detail != none) entry.detail += static_cast<std::uint32_t>(all_.fresh_details_.size());
  all_.fresh_.insert(all_.fresh_.end(), fresh_.begin(), fresh_.end());
  std::move(fresh_details_.begin(), fresh_details_.end(), std::back_inserter(all_.fresh_details_));
}

void KeptContacts::Batch::seek(Pair pair) {
  const std::uint64_t key = key_of(pair);
  entry_ = nullptr;
  if (next_ >= all_.entries_.size() || all_.entries_[next_].key != key) {
    if (pair.a + std::size_t{1} >= all_.rows_.size()) return;
    const auto first = all_.entries_.begin();
    const auto found = std::lower_bound(first + all_.rows_[pair.a], first + all_.rows_[pair.a + 1], key,
                                        [](const Entry& entry, std::uint64_t k) { return entry.key < k; });
    next_ = static_cast<std::size_t>(found - first);
    if (found == all_.entries_.end() || found->key != key) return;
  }
  entry_ = &all_.entries_[next_++];
}

std::size_t KeptContacts::Batch::stand(std::span<const Pair> pairs) {
  const std::uint32_t step = all_.step_;
  std::uint32_t begin = 0, end = 0;  // of the last step's list: what is to be appended
  std::uint64_t colliding = 0, inexact = 0;
  double error_bound = error_bound_;
  std::size_t count = 0;
  for (; count < pairs.size(); ++count) {
    const Pair pair = pairs[count];
    seek(pair);
    was_candidate_ = false;
    if (entry_ == nullptr) break;
    Entry& entry = *entry_;
    was_candidate_ = std::exchange(entry.seen, step) + 1 == step;
    if (!was_candidate_ || !all_.stands(entry, pair)) break;
    if (entry.result != end) {
      append(begin, end);
      begin = entry.result;
    }
    end = entry.result + (entry.reported ? 1 : 0);
    const double rest = all_.rest_bound(pair);
    error_bound = std::max(error_bound, entry.reported ? static_cast<double>(entry.bound) + rest : 0);
    colliding += entry.collide ? 1 : 0;
    inexact += entry.inexact ? 1 : 0;
    if (entry.told) continue;
    entry.told = true;
    if (entry.reported) all_.last_.pairs[entry.result].answer.error_bound += rest;
  }
  append(begin, end);
  kept_ += count;
  standing_ += count;
  colliding_ += colliding;
  inexact_ |= inexact != 0;
  error_bound_ = error_bound;
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

bool KeptContacts::Batch::move_along(Pair pair, PairResult& result) {
  // What a pair that follows soon will read.
  if (const std::size_t ahead = next_ + 4; ahead < all_.entries_.size() && all_.entries_[ahead].detail != none) {
    const char* detail = reinterpret_cast<const char*>(&all_.details_[all_.entries_[ahead].detail]);
    for (std::size_t line = 0; line < sizeof(KeptPair); line += 64) __builtin_prefetch(detail + line, 1);
  }
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
  // Rounding, and rotations that are orthonormal to 1e-6 only.
  const double bound =
      (moved.norm() + angle * ball.radius) * (1 + 4e-6) + 4e-15 * (at_.translation.lpNorm<1>() + ball.radius);
  const double distance = std::abs(kept.signed_distance) - kept.error_bound;
  gap_ = distance - bound;
  moved_by_ = 0;
  if (kept.contacts.empty() && !all_.distances_) {
    moved_ = !kept.collide && gap_ > all_.margin_;
    kept_ += moved_ ? 1 : 0;
    return moved_;
  }
  // The shift along the normal is taken into account: what is left is of second order, but not known to be less than
  // both together. Of the angle something is left for what bodies at rest may turn.
  if (!(2 * bound <= ball.allowed && angle <= 0.99 * all_.tolerance_ && bound < distance)) return false;
  moved_ = true;
  ++kept_;
  moved_by_ = 2 * bound;
  error_bound_ = std::max(error_bound_, moved_by_);
  const Pose& frame = all_.scene_->poses()[at_.a_is_reference ? pair.a : pair.b];
  // The mover's point that was at `point`, in the reference's frame, has moved by `turn * point + shift`.
  const Mat3 turn = turned * kept.rotation.transpose();
  const Vec3 shift = at_.translation - kept.translation - turn * kept.translation;
  const double sense = at_.a_is_reference ? 1 : -1;  // normals are from A to B
  const auto opened = [&](const Vec3& normal, const Vec3& point) { return sense * normal.dot(turn * point + shift); };
  PairAnswer& answer = result.answer;
  answer.collide = kept.collide;
  answer.signed_distance = kept.signed_distance + opened(kept.normal, at_.a_is_reference ? kept.point_b : kept.point_a);
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
  if (entry_ != nullptr && entry_->detail == none) {
    // It was of other kinds: as if it had not been there.
    entry_->seen = 0;
    entry_ = nullptr;
  }
  if (entry_ == nullptr) {
    detail_ = static_cast<std::uint32_t>(fresh_details_.size());
    fresh_details_.emplace_back();
  }
  KeptPair& kept = entry_ != nullptr ? all_.details_[entry_->detail] : fresh_details_.back();
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

void KeptContacts::Batch::note(const PairResult& result, bool reported) {
  const PairAnswer& answer = result.answer;
  if (!moved_) {
    ++computed_;
    gap_ = std::abs(answer.signed_distance) - answer.error_bound;
    moved_by_ = 0;
  }
  const Pair pair{result.a, result.b};
  const auto shape = all_.scene_->shape_indices();
  Entry& entry = entry_ != nullptr ? *entry_ : fresh_.emplace_back();
  entry.key = key_of(pair);
  entry.seen = entry.as_of = all_.step_;
  if (entry_ == nullptr) entry.detail = detail_;
  entry.bound = static_cast<float>(moved_by_ * (1 + 1e-6));
  entry.reported = reported;
  entry.told = false;
  entry.collide = answer.collide;
  entry.inexact = answer.status == Status::inexact;
  const double rest = all_.rest_bound(pair);
  const double allowed = std::min(all_.balls_[shape[pair.a]].allowed, all_.balls_[shape[pair.b]].allowed);
  entry.steady = reported ? moved_by_ + rest <= allowed && rest < gap_ : !answer.collide && gap_ - rest > all_.margin_;
}

}  // namespace tandem
