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
  all_.batch_sums_.add(sums_);
  if (new_details_.size() != 0) {
    const auto first = static_cast<std::uint32_t>(all_.new_details_.size());
    for (NewPair& added : new_pairs_)
      if (added.entry.detail != none) added.entry.detail += first;
    for (auto& [entry, place] : adopted_) all_.adopted_.push_back({entry, place + first});
    std::move(new_details_.begin(), new_details_.end(), std::back_inserter(all_.new_details_));
  }
  all_.new_pairs_.insert(all_.new_pairs_.end(), new_pairs_.begin(), new_pairs_.end());
}

void KeptContacts::Batch::find_entry(Pair pair) {
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

std::size_t KeptContacts::Batch::append_valid(std::span<const Pair> pairs) {
  std::uint32_t begin = 0, end = 0;  // range of the last step's list to append
  std::size_t count = 0;
  for (; count < pairs.size(); ++count) {
    const Pair pair = pairs[count];
    find_entry(pair);
    was_candidate_ = entry_ != nullptr && entry_->candidate;
    if (!was_candidate_ || !all_.remains_valid(*entry_, pair)) break;
    Entry& entry = *entry_;
    entry.seen = all_.step_;
    if (!all_.all_processed_) continue;  // its answer keeps its place
    const auto index = static_cast<std::size_t>(entry_ - all_.entries_.data());
    const std::uint32_t place = all_.results_[index];
    if (place != end) {
      append(begin, end);
      begin = place;
    }
    end = place + (entry.reported ? 1 : 0);
    if (!entry.resting) all_.mark_resting(index, pair, place);
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

bool KeptContacts::Batch::extrapolate(Pair pair, PairResult& result, const std::function<bool()>& collide) {
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
  const PairAnswer& known = kept.answer;
  const double distance = std::abs(known.signed_distance) - known.error_bound;
  gap_ = distance - bound;
  moved_by_ = 0;
  // An answer that was computed before they rested and moved along would not remain valid while they rest; a recomputed
  // one may.
  const double rest = all_.rest_bound(pair);
  const bool may_settle = bound > rest && all_.both_rest(pair);
  if (kept.contacts.empty() && !all_.distances_) {
    moved_ = !known.collide && gap_ > all_.margin_ + (may_settle ? rest : 0);
    return moved_;
  }
  // The deepest contact of an overlap with a mesh is not continuous in the poses: no bound on its error exists.
  if (known.collide && known.status == Status::unproven) return false;
  // The shift along the normal is accounted for: the remaining change is of second order, but not known to be less than
  // both together.
  if (!(2 * bound <= ball.allowed && angle <= tolerance::moved_turn * all_.tolerance_)) return false;
  if (may_settle && !(rest < gap_ && 2 * bound + rest <= ball.allowed)) return false;
  const bool in_doubt = !(bound < distance);
  // The answer of two resting bodies is recomputed, because the new one remains valid.
  if (in_doubt && !(collide && !all_.both_rest(pair) && collide() == known.collide)) return false;
  moved_ = true;
  moved_by_ = 2 * bound;
  const Pose& frame = all_.scene_->poses()[at_.a_is_reference ? pair.a : pair.b];
  // The mover's point that was at `point`, in the reference's frame, has moved by `turn * point + shift`.
  const Mat3 turn = turned * kept.rotation.transpose();
  const Vec3 shift = at_.translation - kept.translation - turn * kept.translation;
  const double sense = at_.a_is_reference ? 1 : -1;  // normals are from A to B
  const auto opened = [&](const Vec3& normal, const Vec3& point) { return sense * normal.dot(turn * point + shift); };
  PairAnswer& answer = result.answer;
  answer = known;
  answer.signed_distance += opened(known.normal, at_.a_is_reference ? known.point_b : known.point_a);
  if (in_doubt)
    answer.signed_distance = known.collide ? std::min(answer.signed_distance, 0.0)
                                           : std::max(answer.signed_distance, std::numeric_limits<double>::min());
  answer.error_bound += moved_by_;
  answer.point_a = frame * known.point_a;
  answer.point_b = frame * known.point_b;
  answer.normal = frame.rotation * known.normal;
  kept.contacts.each([&](const Contact& contact) {
    const double depth = std::max(contact.depth - opened(contact.normal, contact.point), -all_.margin_);
    contacts_.push_back({frame * contact.point, frame.rotation * contact.normal, depth, contact.feature});
  });
  return true;
}

void KeptContacts::Batch::store(const PairResult& result, std::span<const Contact> contacts) {
  const bool is_new = entry_ == nullptr || entry_->detail == none;
  if (is_new) {
    detail_ = static_cast<std::uint32_t>(new_details_.size());
    new_details_.emplace_back();
    // Otherwise the pair was of other kinds.
    if (entry_ != nullptr) adopted_.push_back({static_cast<std::uint32_t>(entry_ - all_.entries_.data()), detail_});
  }
  KeptPair& kept = is_new ? new_details_.back() : all_.details_[entry_->detail];
  kept.rotation = at_.rotation;
  kept.translation = at_.translation;
  kept.answer = result.answer;
  kept.contacts.clear();
  if (contacts.empty() && !all_.distances_) return;
  const Pose& frame = all_.scene_->poses()[at_.a_is_reference ? result.a : result.b];
  const auto turned = [&](const Vec3& world) -> Vec3 { return frame.rotation.transpose() * world; };
  kept.answer.point_a = into(frame, result.answer.point_a);
  kept.answer.point_b = into(frame, result.answer.point_b);
  kept.answer.normal = turned(result.answer.normal);
  for (const Contact& contact : contacts)
    kept.contacts.add({into(frame, contact.point), turned(contact.normal), contact.depth, contact.feature});
}

void KeptContacts::Batch::record(const PairResult& result, std::span<const Contact> contacts, bool reported) {
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
    if (!all_.all_processed_) sums_.leave(*entry, *largest, all_.sums_);
  } else {
    NewPair& added = new_pairs_.emplace_back();
    added.key = key_of(pair);
    entry = &added.entry;
    entry->detail = detail_;
    largest = &added.largest;
  }
  entry->seen = entry->as_of = all_.step_;
  entry->bound = static_cast<float>(moved_by_ * (1 + tolerance::bound_of_floats));
  entry->reported = reported;
  entry->resting = false;
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
  ++sums_.recorded;
  sums_.enter(*entry, *largest);
}

}  // namespace tandem
