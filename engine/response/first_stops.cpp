// Finds the first contacts of continuous bodies in a step, in the order of time.
#include "response/first_stops.h"

#include <algorithm>
#include <array>
#include <functional>
#include <queue>
#include <utility>

#include "response/parallel_blocks.h"
#include "scene/swept_boxes.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {
namespace {

constexpr std::size_t swept_bodies_a_block = 256;
/// The features of contacts of inner balls, of the first body and of the second: no others have them.
constexpr std::array<std::uint32_t, 2> ball_features{0xfffffffdu, 0xfffffffeu};

void grow(Aabb& box, const Aabb& by) {
  for (std::size_t k = 0; k < 3; ++k) {
    box.lo[k] = std::min(box.lo[k], by.lo[k]);
    box.hi[k] = std::max(box.hi[k], by.hi[k]);
  }
}

bool holds(const Aabb& box, const Aabb& other) {
  for (std::size_t k = 0; k < 3; ++k)
    if (!(box.lo[k] <= other.lo[k] && other.hi[k] <= box.hi[k])) return false;
  return true;
}

Aabb joined(const SweptBoxes& swept) {
  Aabb box = swept.box(0);
  for (std::size_t i = 1; i < swept.size(); ++i) grow(box, swept.box(i));
  return box;
}

bool is_still(const Motion& motion) {
  return motion.from.translation == motion.to.translation && motion.from.rotation == motion.to.rotation;
}

}  // namespace

FastestTwo FirstStops::begin(const Scene& scene, std::span<const Pose> ends, std::span<const std::uint8_t> own) {
  stops_.clear();
  bodies_.begin(scene, ends, own);
  return bodies_.fastest();
}

void FirstStops::sweep() {
  const Scene& scene = bodies_.scene();
  around_.resize(scene.indices());
  ParallelTime unused;
  for_blocks(scene.indices(), swept_bodies_a_block, unused, [&](std::size_t first, std::size_t end) {
    for (auto i = static_cast<std::uint32_t>(first); i < end; ++i)
      if (bodies_.takes_part(i)) around_[i] = swept_box(scene.shape_of(i), bodies_.leg(i).motion);
  });
  for (const std::uint32_t body : bodies_.watched())
    around_[body] = joined(SweptBoxes(scene.shape_of(body), bodies_.leg(body).motion));
}

/// Builds a hierarchy of the bodies that come near a watched one.
void FirstStops::build_hierarchy_near_watched() {
  Aabb all = around_[bodies_.watched().front()];
  for (const std::uint32_t body : bodies_.watched()) grow(all, around_[body]);
  nearby_.clear();
  for (std::uint32_t i = 0; i < bodies_.scene().indices(); ++i)
    if (bodies_.takes_part(i) && overlap(around_[i], all)) nearby_.push_back(i);
  boxes_.resize(nearby_.size());
  for (std::size_t k = 0; k < nearby_.size(); ++k) boxes_.set(k, around_[nearby_[k]]);
  tree_.build(boxes_);
}

/// Calls visit(body) once for each body whose box overlaps this one, in the order of indices. A box beyond those of the
/// watched bodies' own motions may be anywhere.
template <class Visit>
void FirstStops::each_near(const Aabb& box, bool anywhere, Visit&& visit) {
  std::vector<std::uint32_t> met;
  if (anywhere) {
    for (std::uint32_t i = 0; i < around_.size(); ++i)
      if (bodies_.takes_part(i) && overlap(around_[i], box)) met.push_back(i);
  } else {
    tree_.overlapping(box, met);
    for (std::uint32_t& place : met) place = nearby_[place];
  }
  met.insert(met.end(), strayed_.begin(), strayed_.end());
  std::sort(met.begin(), met.end());
  met.erase(std::unique(met.begin(), met.end()), met.end());
  for (const std::uint32_t body : met) visit(body);
}

/// Appends the contacts of `body` from t on. At the start of a step the watched body of the larger index finds a pair
/// itself.
void FirstStops::find_impacts(std::uint32_t body, double t, std::vector<Meeting>& out) {
  const bool at_start = changes_[body] == 0;
  const Scene& scene = bodies_.scene();
  const SweptBoxes swept(scene.shape_of(body), bodies_.leg(body).motion);
  const Aabb whole = joined(swept);
  if (!at_start && !holds(around_[body], whole)) strays_.push_back({body, whole});
  each_near(whole, !at_start && !is_still(bodies_.leg(body).motion), [&](std::uint32_t other) {
    if (other == body || (at_start && other > body && bodies_.is_watched(other))) return;
    if (!bodies_.may_meet(body, other, t)) return;
    const Aabb box =
        bodies_.is_watched(other) ? swept_box(scene.shape_of(other), bodies_.leg(other).motion) : around_[other];
    bool near = false;
    for (std::size_t i = 0; i < swept.size() && !near; ++i) near = overlap(swept.box(i), box);
    if (!near) return;
    const std::uint32_t a = std::min(body, other), b = std::max(body, other);
    if (const auto touch = bodies_.meet(a, b, t))
      out.push_back({touch->t, a, b, changes_[a], changes_[b], touch->point, touch->normal, touch->core});
  });
}

void FirstStops::change(std::uint32_t body, const Leg& leg) {
  bodies_.leg_of(body) = leg;
  ++changes_[body];
  changed_.push_back(body);
}

void FirstStops::rest_at(std::uint32_t body, double t) {
  const Leg leg = bodies_.leg(body);
  const Pose here = leg.at(t);
  change(body, {t, {here, here, leg.motion.straight_of}, false, 0});
}

/// The motion of a body that from t on keeps its pose relative to another one.
Motion FirstStops::carried_by(std::uint32_t other, const Leg& leg, double t) const {
  const Leg taken = bodies_.leg(other);
  const Pose here = leg.at(t), there = taken.at(t);
  const Mat3 turn = taken.motion.to.rotation * there.rotation.transpose();
  const Pose end{turn * here.rotation, taken.motion.to.translation + turn * (here.translation - there.translation)};
  const Vec3 straight = here.rotation.transpose() * (there * *taken.motion.straight_of - here.translation);
  return {here, orthonormalized(end), straight};
}

void FirstStops::follow(std::uint32_t body, std::uint32_t other, double t) {
  const Leg leg = bodies_.leg(body), taken = bodies_.leg(other);
  if (is_still(taken.motion)) return rest_at(body, t);
  change(body, {t, carried_by(other, leg, t), false, taken.speed});
  strayed_.push_back(body);
}

/// Takes from a body's motion, as seen from the other one, the approach of its core; the body slides and turns on.
/// Where that does not suffice, as a surface rises before the core or two form a corner, its centre moves with the
/// other body, at last all of it: their common motion is not lost. False if even that was tried.
bool FirstStops::hold_off(const Meeting& meeting) {
  constexpr std::uint8_t slides = 3;
  const std::uint32_t body = meeting.core, other = meeting.a == body ? meeting.b : meeting.a;
  if (body == BodiesTouch::none || !bodies_.leg(body).free || held_off_[body] > slides + 1) return false;
  const std::uint8_t before = held_off_[body]++;
  const Leg leg = bodies_.leg(body), taken = bodies_.leg(other);
  if (before > slides) {
    change(body, {meeting.t, carried_by(other, leg, meeting.t), true, leg.speed});
  } else {
    const Pose here = leg.at(meeting.t), there = taken.at(meeting.t);
    const Vec3 centre = bodies_.ball_of(bodies_.scene(), body).centre, at = here * centre;
    const Vec3 carried = taken.motion.to * (there.rotation.transpose() * (at - there.translation));
    Vec3 shift = leg.motion.to * centre - carried;
    shift -= meeting.normal.dot(shift) * meeting.normal;
    if (before == slides) shift.setZero();
    const Mat3& turned = leg.motion.to.rotation;
    change(body, {meeting.t, {here, {turned, carried + shift - turned * centre}, centre}, true, leg.speed});
  }
  strayed_.push_back(body);
  return true;
}

void FirstStops::apply(const Meeting& meeting) {
  const auto [a, b, t] = std::tie(meeting.a, meeting.b, meeting.t);
  const Scene& scene = bodies_.scene();
  stops_.push_back({t, scene.id(a), scene.id(b), meeting.point, meeting.normal});
  if (hold_off(meeting)) return;
  const Leg leg_a = bodies_.leg(a), leg_b = bodies_.leg(b);
  if (leg_a.free && leg_b.free) {
    rest_at(a, t);
    rest_at(b, t);
  } else if (leg_a.free || (!leg_b.free && leg_a.speed < leg_b.speed && bodies_.is_watched(a))) {
    follow(a, b, t);
  } else {
    follow(b, a, t);
  }
}

void FirstStops::find() {
  stops_.clear();
  strays_.clear();
  strayed_.clear();
  const auto watched = bodies_.watched();
  if (watched.empty()) return;
  build_hierarchy_near_watched();
  changes_.assign(bodies_.scene().indices(), 0);
  held_off_.assign(bodies_.scene().indices(), 0);
  found_.resize(std::max(found_.size(), watched.size()));
  ParallelTime unused;
  for_blocks(watched.size(), 1, unused, [&](std::size_t i, std::size_t) {
    found_[i].clear();
    find_impacts(watched[i], 0, found_[i]);
  });
  std::priority_queue<Meeting, std::vector<Meeting>, std::greater<>> queue;
  for (std::size_t i = 0; i < watched.size(); ++i)
    for (const Meeting& meeting : found_[i]) queue.push(meeting);
  std::vector<Meeting> fresh;
  while (!queue.empty()) {
    const Meeting next = queue.top();
    queue.pop();
    if (next.changes_a != changes_[next.a] || next.changes_b != changes_[next.b]) continue;
    if (next.t >= 1) break;
    changed_.clear();
    apply(next);
    fresh.clear();
    for (const std::uint32_t body : changed_) find_impacts(body, next.t, fresh);
    for (const Meeting& meeting : fresh) queue.push(meeting);
  }
}

PairResult FirstStops::contacts_of_stop(const Scene& scene, std::uint32_t a, std::uint32_t b, const PairResult* known,
                                        ContactList& contacts) const {
  const NarrowPhase narrow;
  const Shape &shape_a = scene.shape_of(a), &shape_b = scene.shape_of(b);
  const Pose &pose_a = scene.poses()[a], &pose_b = scene.poses()[b];
  const auto add = [&](const PairAnswer& answer, std::uint32_t feature) {
    contacts.contacts.push_back(
        {0.5 * (answer.point_a + answer.point_b), answer.normal, -answer.signed_distance, feature});
  };
  PairResult pair;
  const auto first = static_cast<std::uint32_t>(contacts.contacts.size());
  if (known != nullptr && known->contact_count != 0) {
    pair = *known;
    for (std::uint32_t i = 0; i < known->contact_count; ++i)
      contacts.contacts.push_back(Contact(contacts.contacts[known->first_contact + i]));
  } else {
    pair.a = a;
    pair.b = b;
    pair.answer = narrow.solve(shape_a, pose_a, shape_b, pose_b, Request::distance);
    add(pair.answer, 0);
  }
  const auto at_centre = [](const Pose& pose, const InnerBall& ball) {
    return Pose{Mat3::Identity(), pose * ball.centre};
  };
  const InnerBall ball_a = bodies_.ball_of(scene, a), ball_b = bodies_.ball_of(scene, b);
  if (ball_a.radius > 0) {
    const Pose at = at_centre(pose_a, ball_a);
    const PairAnswer its = narrow.solve(Sphere{ball_a.radius}, at, shape_b, pose_b, Request::distance);
    if (its.signed_distance < 0) add(its, ball_features[0]);
  }
  if (ball_b.radius > 0) {
    const Pose at = at_centre(pose_b, ball_b);
    const PairAnswer its = narrow.solve(shape_a, pose_a, Sphere{ball_b.radius}, at, Request::distance);
    if (its.signed_distance < 0) add(its, ball_features[1]);
  }
  pair.first_contact = first;
  pair.contact_count = static_cast<std::uint32_t>(contacts.contacts.size()) - first;
  std::stable_sort(contacts.contacts.begin() + first, contacts.contacts.end(),
                   [](const Contact& x, const Contact& y) { return x.feature < y.feature; });
  return pair;
}

}  // namespace tandem
