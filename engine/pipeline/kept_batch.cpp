// The answers of one batch of pairs: validity test, extrapolation and recording.
#include "pipeline/kept_batch.h"

#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "scene/tolerances.h"

namespace tandem {
namespace {

Vec3 into(const Pose& frame, const Vec3& world) { return frame.rotation.transpose() * (world - frame.translation); }

}  // namespace

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
  std::uint32_t begin = 0, end = 0;  // range of the last step's list to append
  std::size_t count = 0;
  for (; count < pairs.size(); ++count) {
    const Pair pair = pairs[count];
    seek(pair);
    was_candidate_ = entry_ != nullptr && entry_->candidate;
    if (!was_candidate_ || !all_.stands(*entry_, pair)) break;
    Entry& entry = *entry_;
    entry.seen = all_.step_;
    if (!all_.all_asked_) continue;  // its answer keeps its place
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
  // The body that is smaller at its farthest point moves less.
  const bool a_is_reference = all_.balls_[shape[pair.a]].radius >= all_.balls_[shape[pair.b]].radius;
  const Pose& reference = poses[a_is_reference ? pair.a : pair.b];
  const Pose& mover = poses[a_is_reference ? pair.b : pair.a];
  return {reference.rotation.transpose() * mover.rotation, into(reference, mover.translation), a_is_reference};
}

// Prefetches the data that the following pairs will read.
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
  // An answer that was computed before they rested and moved along would not remain valid while they rest; a recomputed
  // one may.
  const double rest = all_.rest_bound(pair);
  const bool may_settle = bound > rest && all_.both_rest(pair);
  if (kept.contacts.empty() && !all_.distances_) {
    moved_ = !kept.collide && gap_ > all_.margin_ + (may_settle ? rest : 0);
    return moved_;
  }
  // The deepest contact of an overlap with a mesh is not continuous in the poses: no bound on its error exists.
  if (kept.collide && kept.status == Status::unproven) return false;
  // The shift along the normal is accounted for: the remaining change is of second order, but not known to be less than
  // both together. A part of the angle is reserved for the turn of bodies at rest.
  if (!(2 * bound <= ball.allowed && angle <= 0.99 * all_.tolerance_)) return false;
  if (may_settle && !(rest < gap_ && 2 * bound + rest <= ball.allowed)) return false;
  const bool in_doubt = !(bound < distance);
  // The answer of two resting bodies is recomputed, because the new one remains valid.
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
    // Otherwise the pair was of other kinds.
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

}  // namespace tandem
