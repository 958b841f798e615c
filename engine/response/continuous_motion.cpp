// The motion of continuous bodies, limited so that they do not pass through others.
#include "tandem/engine/continuous_motion.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "response/first_stops.h"
#include "response/free_end.h"

namespace tandem {

Pose free_end(const Scene& scene, std::uint32_t body) {
  Pose end = scene.poses()[body];
  const Vec3 shift = scene.dt * scene.velocities()[body], turn = scene.dt * scene.angular_velocities()[body];
  const Vec3 centre = scene.is_static()[body] ? Vec3(Vec3::Zero()) : scene.shape_of(body).mass().centre;
  const Vec3 from = end * centre;
  if (!turn.isZero(0)) end.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * end.rotation;
  end.translation = from + shift - end.rotation * centre;
  return end;
}

void free_ends(const Scene& scene, std::vector<Pose>& ends) {
  ends.assign(scene.poses().begin(), scene.poses().end());
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!scene.alive(i)) continue;
    ends[i] = free_end(scene, i);
    if (!is_valid(ends[i]))
      require_valid(ends[i], "free_ends: body " + std::to_string(i) + " after dt by its velocities");
  }
}

struct ContinuousMotion::Impl {
  explicit Impl(PairPredicate predicate) : first(std::move(predicate)) {}
  FirstStops first;
};

ContinuousMotion::ContinuousMotion(PairPredicate predicate) : impl_(std::make_unique<Impl>(std::move(predicate))) {}
ContinuousMotion::~ContinuousMotion() = default;
ContinuousMotion::ContinuousMotion(ContinuousMotion&&) noexcept = default;
ContinuousMotion& ContinuousMotion::operator=(ContinuousMotion&&) noexcept = default;

std::span<const MotionStop> ContinuousMotion::limit(const Scene& scene, std::span<Pose> ends) {
  FirstStops& first = impl_->first;
  first.clear();
  if (ends.size() != scene.indices())
    throw std::invalid_argument("ends: " + std::to_string(ends.size()) +
                                ", allowed: " + std::to_string(scene.indices()) + ", one an index");
  for (std::uint32_t i = 0; i < ends.size(); ++i)
    if (scene.alive(i) && !is_valid(ends[i])) require_valid(ends[i], "ends: body " + std::to_string(i));
  if (!scene.has_continuous() || !first.watch(first.begin(scene, ends))) return {};
  first.sweep();
  first.find();
  for (const std::uint32_t body : first.watched())
    if (first.is_stopped(body)) ends[body] = first.end(body);
  return first.stops();
}

void ContinuousMotion::add_contacts(const Scene& scene, ContactList& contacts) const {
  const auto lives = [&](BodyId id) {
    return id.index() < scene.indices() && scene.alive(id.index()) && scene.id(id.index()) == id;
  };
  const auto before = [](const PairResult& pair, const PairResult& other) {
    return std::tie(pair.a, pair.b) < std::tie(other.a, other.b);
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stopped;  // a pair may have been stopped more than once
  for (const MotionStop& stop : impl_->first.stops())
    if (lives(stop.a) && lives(stop.b)) stopped.push_back({stop.a.index(), stop.b.index()});
  std::sort(stopped.begin(), stopped.end());
  stopped.erase(std::unique(stopped.begin(), stopped.end()), stopped.end());
  const PairFilter filter{scene.groups(), scene.masks(), scene.is_static()};
  for (const auto& [a, b] : stopped) {
    if (!filter.allows(a, b)) continue;
    PairResult pair;
    pair.a = a;
    pair.b = b;
    const auto place = std::lower_bound(contacts.pairs.begin(), contacts.pairs.end(), pair, before);
    const bool known = place != contacts.pairs.end() && !before(pair, *place);
    pair = impl_->first.contacts_of_stop(scene, a, b, known ? &*place : nullptr, contacts);
    if (known)
      *place = pair;
    else
      contacts.pairs.insert(place, pair);
  }
  if (stopped.empty()) return;
  // Those of a pair were appended: all in the order of the pairs again.
  std::vector<Contact> in_order;
  in_order.reserve(contacts.contacts.size());
  for (PairResult& pair : contacts.pairs) {
    const auto its = contacts.of(pair);
    pair.first_contact = static_cast<std::uint32_t>(in_order.size());
    in_order.insert(in_order.end(), its.begin(), its.end());
  }
  contacts.contacts = std::move(in_order);
}

}  // namespace tandem
