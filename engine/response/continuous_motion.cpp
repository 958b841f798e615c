// Continuous bodies are stopped where they first touch something: all touches of a step in the order of time, as
// stopping one body changes what the others meet. After Mirtich, Impulse-based dynamic simulation of rigid body
// systems, 1996 (the heap of first touches), with motions that end in place of velocities that change.
#include "tandem/engine/continuous_motion.h"

#include <algorithm>
#include <queue>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "response/moving_bodies.h"
#include "response/parallel_blocks.h"
#include "scene/swept_boxes.h"
#include "tandem/broadphase/box_queries.h"

namespace tandem {
namespace {

constexpr std::size_t swept_bodies_a_block = 256;

/// A touch that is to come, unless one of the two is stopped before.
struct Meeting {
  double t = 0;
  std::uint32_t a = 0, b = 0;
  std::uint32_t changes_a = 0, changes_b = 0;
  Vec3 point, normal;
  bool operator>(const Meeting& other) const { return std::tie(t, a, b) > std::tie(other.t, other.a, other.b); }
};

void grow(Aabb& box, const Aabb& by) {
  for (std::size_t k = 0; k < 3; ++k) {
    box.lo[k] = std::min(box.lo[k], by.lo[k]);
    box.hi[k] = std::max(box.hi[k], by.hi[k]);
  }
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

void free_ends(const Scene& scene, std::vector<Pose>& ends) {
  ends.assign(scene.poses().begin(), scene.poses().end());
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!scene.alive(i)) continue;
    const Vec3 shift = scene.dt * scene.velocities()[i], turn = scene.dt * scene.angular_velocities()[i];
    const Vec3 centre = scene.is_static()[i] ? Vec3(Vec3::Zero()) : scene.shape_of(i).mass().centre;
    const Vec3 from = ends[i] * centre;
    if (!turn.isZero(0)) ends[i].rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * ends[i].rotation;
    ends[i].translation = from + shift - ends[i].rotation * centre;
  }
}

struct ContinuousMotion::Impl {
  explicit Impl(PairPredicate predicate) : bodies(std::move(predicate)) {}

  void require_valid_ends(const Scene& scene, std::span<const Pose> ends) const;
  void find_moving();
  template <class Visit>
  void each_near(const Aabb& box, bool anywhere, Visit&& visit);
  void find_meetings(std::uint32_t body, double t, std::vector<Meeting>& found);
  void apply(const Meeting& meeting);
  void stand(std::uint32_t body, double t);
  void go_with(std::uint32_t body, std::uint32_t other, double t);
  void change(std::uint32_t body, const Leg& leg);

  MovingBodies bodies;
  std::vector<Aabb> around;            // one a body: holds what it goes through in the step
  std::vector<std::uint32_t> nearby;   // bodies near a watched one
  std::vector<std::uint32_t> changes;  // one a body: how often its leg changed
  std::vector<std::uint32_t> changed;  // bodies whose leg did in the meeting at hand
  std::vector<std::uint32_t> strayed;  // those that were taken along: they may be anywhere
  BoxArray boxes;                      // of `nearby`
  BoxQueries tree;
  std::vector<MotionStop> stops;
  std::vector<std::vector<Meeting>> found;  // one a watched body
};

void ContinuousMotion::Impl::require_valid_ends(const Scene& scene, std::span<const Pose> ends) const {
  if (ends.size() != scene.indices())
    throw std::invalid_argument("ends: " + std::to_string(ends.size()) +
                                ", allowed: " + std::to_string(scene.indices()) + ", one an index");
  for (std::uint32_t i = 0; i < ends.size(); ++i)
    if (scene.alive(i) && !is_valid(ends[i])) require_valid(ends[i], "ends: body " + std::to_string(i));
}

/// Boxes of all bodies, and a hierarchy of those that come near a watched one.
void ContinuousMotion::Impl::find_moving() {
  const Scene& scene = bodies.scene();
  around.resize(scene.indices());
  ParallelTime unused;
  for_blocks(scene.indices(), swept_bodies_a_block, unused, [&](std::size_t first, std::size_t end) {
    for (auto i = static_cast<std::uint32_t>(first); i < end; ++i)
      if (bodies.takes_part(i)) around[i] = swept_box(scene.shape_of(i), bodies.leg(i).motion);
  });
  for (const std::uint32_t body : bodies.watched())
    around[body] = joined(SweptBoxes(scene.shape_of(body), bodies.leg(body).motion));
  Aabb all = around[bodies.watched().front()];
  for (const std::uint32_t body : bodies.watched()) grow(all, around[body]);
  nearby.clear();
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (bodies.takes_part(i) && overlap(around[i], all)) nearby.push_back(i);
  boxes.resize(nearby.size());
  for (std::size_t k = 0; k < nearby.size(); ++k) boxes.set(k, around[nearby[k]]);
  tree.build(boxes);
}

/// visit(body) once for each whose box meets this one, in the order of indices. A box that is not within those of the
/// watched bodies' own motions may be anywhere.
template <class Visit>
void ContinuousMotion::Impl::each_near(const Aabb& box, bool anywhere, Visit&& visit) {
  std::vector<std::uint32_t> met;
  if (anywhere) {
    for (std::uint32_t i = 0; i < around.size(); ++i)
      if (bodies.takes_part(i) && overlap(around[i], box)) met.push_back(i);
  } else {
    tree.overlapping(box, met);
    for (std::uint32_t& place : met) place = nearby[place];
  }
  met.insert(met.end(), strayed.begin(), strayed.end());
  std::sort(met.begin(), met.end());
  met.erase(std::unique(met.begin(), met.end()), met.end());
  for (const std::uint32_t body : met) visit(body);
}

/// Appends what `body` meets from t on. At the start of a step a watched body of a larger index finds the pair itself.
void ContinuousMotion::Impl::find_meetings(std::uint32_t body, double t, std::vector<Meeting>& out) {
  const bool at_start = bodies.leg(body).free;
  const Scene& scene = bodies.scene();
  const SweptBoxes swept(scene.shape_of(body), bodies.leg(body).motion);
  each_near(joined(swept), !at_start && !is_still(bodies.leg(body).motion), [&](std::uint32_t other) {
    if (other == body || (at_start && other > body && bodies.is_watched(other))) return;
    if (!bodies.may_meet(body, other, t)) return;
    const Aabb box =
        bodies.is_watched(other) ? swept_box(scene.shape_of(other), bodies.leg(other).motion) : around[other];
    bool near = false;
    for (std::size_t i = 0; i < swept.size() && !near; ++i) near = overlap(swept.box(i), box);
    if (!near) return;
    const std::uint32_t a = std::min(body, other), b = std::max(body, other);
    if (const auto touch = bodies.meet(a, b, t))
      out.push_back({touch->t, a, b, changes[a], changes[b], touch->point, touch->normal});
  });
}

void ContinuousMotion::Impl::change(std::uint32_t body, const Leg& leg) {
  bodies.leg_of(body) = leg;
  ++changes[body];
  changed.push_back(body);
}

void ContinuousMotion::Impl::stand(std::uint32_t body, double t) {
  const Leg leg = bodies.leg(body);
  const Pose here = leg.at(t);
  change(body, {t, {here, here, leg.motion.straight_of}, false, 0});
}

void ContinuousMotion::Impl::go_with(std::uint32_t body, std::uint32_t other, double t) {
  const Leg leg = bodies.leg(body), taken = bodies.leg(other);
  if (is_still(taken.motion)) return stand(body, t);
  const Pose here = leg.at(t), there = taken.at(t);
  // Where the body is as the other one sees it stays as it is.
  const Mat3 turn = taken.motion.to.rotation * there.rotation.transpose();
  Pose end{turn * here.rotation, taken.motion.to.translation + turn * (here.translation - there.translation)};
  const Vec3 straight = here.rotation.transpose() * (there * *taken.motion.straight_of - here.translation);
  change(body, {t, {here, orthonormalized(end), straight}, false, taken.speed});
  strayed.push_back(body);
}

void ContinuousMotion::Impl::apply(const Meeting& meeting) {
  const auto [a, b, t] = std::tie(meeting.a, meeting.b, meeting.t);
  const Leg leg_a = bodies.leg(a), leg_b = bodies.leg(b);
  if (leg_a.free && leg_b.free) {
    stand(a, t);
    stand(b, t);
  } else if (leg_a.free || (!leg_b.free && leg_a.speed < leg_b.speed && bodies.is_watched(a))) {
    go_with(a, b, t);
  } else {
    go_with(b, a, t);
  }
  const Scene& scene = bodies.scene();
  stops.push_back({t, scene.id(a), scene.id(b), meeting.point, meeting.normal});
}

ContinuousMotion::ContinuousMotion(PairPredicate predicate) : impl_(std::make_unique<Impl>(std::move(predicate))) {}
ContinuousMotion::~ContinuousMotion() = default;
ContinuousMotion::ContinuousMotion(ContinuousMotion&&) noexcept = default;
ContinuousMotion& ContinuousMotion::operator=(ContinuousMotion&&) noexcept = default;

std::span<const MotionStop> ContinuousMotion::limit(const Scene& scene, std::span<Pose> ends) {
  Impl& own = *impl_;
  own.stops.clear();
  own.require_valid_ends(scene, ends);
  if (!scene.has_continuous() || !own.bodies.begin(scene, ends)) return {};
  own.find_moving();
  own.changes.assign(scene.indices(), 0);
  own.strayed.clear();
  const auto watched = own.bodies.watched();
  own.found.resize(std::max(own.found.size(), watched.size()));
  ParallelTime unused;
  for_blocks(watched.size(), 1, unused, [&](std::size_t i, std::size_t) {
    own.found[i].clear();
    own.find_meetings(watched[i], 0, own.found[i]);
  });
  std::priority_queue<Meeting, std::vector<Meeting>, std::greater<>> queue;
  for (std::size_t i = 0; i < watched.size(); ++i)
    for (const Meeting& meeting : own.found[i]) queue.push(meeting);
  std::vector<Meeting> fresh;
  while (!queue.empty()) {
    const Meeting next = queue.top();
    queue.pop();
    if (next.changes_a != own.changes[next.a] || next.changes_b != own.changes[next.b]) continue;
    if (next.t >= 1) break;
    own.changed.clear();
    own.apply(next);
    fresh.clear();
    for (const std::uint32_t body : own.changed) own.find_meetings(body, next.t, fresh);
    for (const Meeting& meeting : fresh) queue.push(meeting);
  }
  for (const std::uint32_t body : watched)
    if (const Leg leg = own.bodies.leg(body); !leg.free) ends[body] = leg.motion.to;
  return own.stops;
}

void ContinuousMotion::add_contacts(const Scene& scene, ContactList& contacts) const {
  const auto lives = [&](BodyId id) {
    return id.index() < scene.indices() && scene.alive(id.index()) && scene.id(id.index()) == id;
  };
  const auto before = [](const PairResult& pair, const PairResult& other) {
    return std::tie(pair.a, pair.b) < std::tie(other.a, other.b);
  };
  const NarrowPhase narrow;
  for (const MotionStop& stop : impl_->stops) {
    if (!lives(stop.a) || !lives(stop.b)) continue;
    PairResult pair;
    pair.a = stop.a.index();
    pair.b = stop.b.index();
    const PairFilter filter{scene.groups(), scene.masks(), scene.is_static()};
    if (!filter.allows(pair.a, pair.b)) continue;
    const auto place = std::lower_bound(contacts.pairs.begin(), contacts.pairs.end(), pair, before);
    const bool known = place != contacts.pairs.end() && !before(pair, *place);
    if (known && place->contact_count != 0) continue;
    pair.answer = narrow.solve(scene.shape_of(pair.a), scene.poses()[pair.a], scene.shape_of(pair.b),
                               scene.poses()[pair.b], Request::distance);
    pair.first_contact = static_cast<std::uint32_t>(contacts.contacts.size());
    pair.contact_count = 1;
    const PairAnswer& answer = pair.answer;
    contacts.contacts.push_back({0.5 * (answer.point_a + answer.point_b), answer.normal, -answer.signed_distance, 0});
    if (known)
      *place = pair;
    else
      contacts.pairs.insert(place, pair);
  }
}

}  // namespace tandem
