// Stops fast bodies before they pass through others, across ranks.
#include "motion_stops.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>

#include "records.h"
#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"

namespace tandem::mpi {
namespace {

bool holds(const Aabb& box, const Aabb& other) {
  for (std::size_t k = 0; k < 3; ++k)
    if (!(box.lo[k] <= other.lo[k] && other.hi[k] <= box.hi[k])) return false;
  return true;
}

IdPair in_order(GlobalId a, GlobalId b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

MotionStops::MotionStops(Communicator& communicator, Bodies& bodies, PairOfIds allows)
    : communicator_(communicator),
      bodies_(bodies),
      allows_(std::move(allows)),
      own_(PairPredicate{}),
      shared_(predicate()) {}

/// The predicate for pairs in scene_.
PairPredicate MotionStops::predicate() const {
  if (!allows_) return {};
  return [this](std::span<Pair> pairs) {
    const auto passes = [this](const Pair& pair) { return !allows_(ids_[pair.a], ids_[pair.b]); };
    return static_cast<std::size_t>(std::remove_if(pairs.begin(), pairs.end(), passes) - pairs.begin());
  };
}

FastestTwo MotionStops::fastest_of_all(FastestTwo own) const {
  std::array<double, 1> first{own.first};
  communicator_.largest(std::span<double>(first));
  std::array<std::uint64_t, 1> as_fast{own.first != first[0] ? 0u : own.second == first[0] ? 2u : 1u};
  std::array<double, 1> second{own.first == first[0] ? own.second : own.first};
  communicator_.sum(std::span<std::uint64_t>(as_fast));
  communicator_.largest(std::span<double>(second));
  return {first[0], as_fast[0] > 1 ? first[0] : second[0]};
}

/// Appends the zones of all ranks.
void MotionStops::send_zones(std::span<const Zone> own) {
  Message message;
  for (const Zone& zone : own) message.put(zone);
  bytes_ += message.size();
  for (Message& one : communicator_.to_all(message))
    while (!one.done()) zones_.push_back(one.take<Zone>());
}

/// Groups zones that overlap.
void MotionStops::group() {
  BoxArray boxes;
  boxes.resize(zones_.size());
  for (std::size_t k = 0; k < zones_.size(); ++k) boxes.set(k, zones_[k].box);
  tree_.build(boxes);
  std::vector<std::uint32_t> first(zones_.size());
  std::iota(first.begin(), first.end(), 0);
  const auto root = [&](std::uint32_t k) {
    while (first[k] != k) k = first[k] = first[first[k]];
    return k;
  };
  const auto join = [&](std::uint32_t j, std::uint32_t k) {
    j = root(j);
    k = root(k);
    const bool smaller = std::pair(zones_[j].id, j) < std::pair(zones_[k].id, k);
    first[smaller ? k : j] = smaller ? j : k;
  };
  std::vector<std::uint32_t> met;
  std::unordered_map<GlobalId, std::uint32_t> of_body;
  for (std::uint32_t k = 0; k < zones_.size(); ++k) {
    join(of_body.try_emplace(zones_[k].id, k).first->second, k);
    met.clear();
    tree_.overlapping(zones_[k].box, met);
    for (const std::uint32_t j : met) join(j, k);
  }
  homes_.resize(zones_.size());
  for (std::uint32_t k = 0; k < zones_.size(); ++k) homes_[k] = zones_[root(k)].rank;
}

/// Sends bodies near a zone to the rank that solves its group.
void MotionStops::send_near(std::span<const Pose> ends) {
  Outbox outbox(communicator_.ranks());
  const Scene& scene = bodies_.scene();
  Aabb all = zones_.front().box;
  for (const Zone& zone : zones_)
    for (std::size_t k = 0; k < 3; ++k) {
      all.lo[k] = std::min(all.lo[k], zone.box.lo[k]);
      all.hi[k] = std::max(all.hi[k], zone.box.hi[k]);
    }
  std::vector<std::uint32_t> met;
  std::vector<int> to;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!own_.takes_part(i) || !overlap(own_.around(i), all)) continue;
    met.clear();
    to.clear();
    tree_.overlapping(own_.around(i), met);
    for (const std::uint32_t k : met) to.push_back(homes_[k]);
    std::sort(to.begin(), to.end());
    to.erase(std::unique(to.begin(), to.end()), to.end());
    const GlobalId id = bodies_.id(i);
    for (const int rank : to)
      outbox.to(rank).put(
          Near{BodyRecord::of(id, scene, i), MotionRecord::of(id, ends[i], Vec3::Zero(), Vec3::Zero())});
  }
  std::vector<std::pair<int, Near>> came;
  for (RankMessage& message : communicator_.exchange(outbox, bytes_, messages_))
    while (!message.content.done()) came.emplace_back(message.rank, message.content.take<Near>());
  std::sort(came.begin(), came.end(),
            [](const auto& x, const auto& y) { return x.second.body.motion.id < y.second.body.motion.id; });
  owners_.clear();
  std::vector<Near> near;
  for (const auto& [rank, body] : came) {
    owners_.push_back(rank);
    near.push_back(body);
  }
  share_scene(near);
}

/// Makes scene_ of these bodies in the order of their ids, so that indices have that order, too.
void MotionStops::share_scene(std::vector<Near>& near) {
  for (auto i = static_cast<std::uint32_t>(ids_.size()); i-- > 0;) scene_.remove_body(scene_.id(i));
  ids_.clear();
  ends_.clear();
  for (const Near& one : near) {
    const BodyRecord& record = one.body;
    auto [shape, is_new] = shapes_.try_emplace(record.shape);
    if (is_new) shape->second = scene_.add_shape(bodies_.scene().shapes()[record.shape]);
    record.add_to(scene_, shape->second);
    ids_.push_back(record.motion.id);
    ends_.push_back(one.end.pose());
  }
  // Places used in an earlier step but not in this one have no body.
  ends_.resize(scene_.indices());
}

/// Boxes that bodies searched outside of their zones.
std::vector<MotionStops::Zone> MotionStops::new_zones() const {
  std::vector<Zone> out;
  for (const FirstStops::Stray& stray : shared_.strays()) {
    const Zone zone{ids_[stray.body], owners_[stray.body], stray.box};
    const auto is_known = [&](const Zone& other) { return other.id == zone.id && holds(other.box, zone.box); };
    if (std::none_of(zones_.begin(), zones_.end(), is_known) && std::none_of(out.begin(), out.end(), is_known))
      out.push_back(zone);
  }
  return out;
}

/// Sends the end poses of stopped bodies to their owners.
void MotionStops::answer(std::span<Pose> ends) {
  Outbox outbox(communicator_.ranks());
  for (const std::uint32_t i : shared_.watched())
    if (shared_.is_stopped(i))
      outbox.to(owners_[i]).put(MotionRecord::of(ids_[i], shared_.end(i), Vec3::Zero(), Vec3::Zero()));
  for (RankMessage& message : communicator_.exchange(outbox, bytes_, messages_))
    while (!message.content.done()) {
      const auto end = message.content.take<MotionRecord>();
      ends[bodies_.place(end.id).value()] = end.pose();
    }
}

void MotionStops::send_stops() {
  Message message;
  for (const MotionStop& stop : shared_.stops()) message.put(in_order(ids_[stop.a.index()], ids_[stop.b.index()]));
  bytes_ += message.size();
  stops_.clear();
  for (Message& one : communicator_.to_all(message))
    while (!one.done()) stops_.push_back(one.take<IdPair>());
}

std::size_t MotionStops::limit(std::span<Pose> ends) {
  stops_.clear();
  const Scene& scene = bodies_.scene();
  std::vector<std::uint8_t> owned(scene.indices());
  for (std::uint32_t i = 0; i < scene.indices(); ++i) owned[i] = scene.alive(i) && bodies_.owns(i) ? 1 : 0;
  const FastestTwo of_all = fastest_of_all(own_.begin(scene, ends, owned));
  std::array<std::uint64_t, 1> any{own_.watch(of_all) ? 1u : 0u};
  communicator_.largest(std::span<std::uint64_t>(any));
  if (any[0] == 0) return 0;
  own_.sweep();
  zones_.clear();
  std::vector<Zone> fresh;
  for (const std::uint32_t i : own_.watched()) fresh.push_back({bodies_.id(i), communicator_.rank(), own_.around(i)});
  for (std::size_t known = 0;; known = zones_.size()) {
    send_zones(fresh);
    if (zones_.size() == known) break;
    group();
    send_near(ends);
    shared_.begin(scene_, ends_);
    shared_.watch(of_all);
    shared_.sweep();
    shared_.find();
    fresh = new_zones();
  }
  answer(ends);
  send_stops();
  const std::size_t stops = stops_.size();
  std::sort(stops_.begin(), stops_.end());
  stops_.erase(std::unique(stops_.begin(), stops_.end()), stops_.end());
  return stops;
}

/// Three numbers for each stop: the owners of its bodies and the rank that reports it, each counted from 1.
std::vector<std::uint64_t> MotionStops::owners_and_reporters(const ContactList& found) const {
  std::vector<std::uint64_t> who(3 * stops_.size());
  const auto own = static_cast<std::uint64_t>(communicator_.rank()) + 1;
  std::map<IdPair, std::size_t> places;
  for (std::size_t s = 0; s < stops_.size(); ++s) {
    if (bodies_.owns_id(stops_[s].a)) who[3 * s] = own;
    if (bodies_.owns_id(stops_[s].b)) who[3 * s + 1] = own;
    if (bodies_.has(stops_[s].a) && bodies_.has(stops_[s].b)) places.emplace(stops_[s], s);
  }
  if (!places.empty())
    for (const PairResult& pair : found.pairs) {
      const auto place = places.find(in_order(bodies_.id(pair.a), bodies_.id(pair.b)));
      if (place != places.end()) who[3 * place->second + 2] = own;
    }
  communicator_.sum(std::span<std::uint64_t>(who));
  return who;
}

/// Sends a copy of the second body of a pair that no rank reports to the owner of the first.
void MotionStops::send_missing_copies(std::span<const std::uint64_t> who) {
  Outbox outbox(communicator_.ranks());
  bool any = false;
  for (std::size_t s = 0; s < stops_.size(); ++s) {
    const std::uint64_t owner_a = who[3 * s], owner_b = who[3 * s + 1], reporter = who[3 * s + 2];
    if (owner_a == 0 || owner_b == 0 || owner_a == owner_b || reporter != 0) continue;
    any = true;
    const int to = static_cast<int>(owner_a) - 1;
    if (static_cast<int>(owner_b) - 1 != communicator_.rank()) continue;
    const std::uint32_t index = bodies_.place(stops_[s].b).value();
    if (!bodies_.has_copy(index, to)) bodies_.write_missing_copy(index, to, outbox.to(to));
  }
  if (!any) return;
  for (RankMessage& message : communicator_.exchange(outbox, bytes_, messages_)) bodies_.take_missing_copies(message);
}

const ContactList& MotionStops::with_contacts(const ContactList& found) {
  const std::vector<std::uint64_t> who = owners_and_reporters(found);
  send_missing_copies(who);
  elsewhere_.clear();
  with_stopped_ = found;
  const Scene& scene = bodies_.scene();
  const PairFilter filter{scene.groups(), scene.masks(), scene.is_static()};
  for (std::size_t s = 0; s < stops_.size(); ++s) {
    const std::uint64_t owner_a = who[3 * s], owner_b = who[3 * s + 1], reporter = who[3 * s + 2];
    if (owner_a == 0 || owner_b == 0) continue;
    const std::uint64_t solver = reporter != 0 ? reporter : owner_a;
    if (static_cast<int>(solver) - 1 != communicator_.rank()) {
      if (reporter == 0) elsewhere_.push_back(stops_[s]);
      continue;
    }
    const std::uint32_t a = bodies_.place(stops_[s].a).value(), b = bodies_.place(stops_[s].b).value();
    if (!filter.allows(a, b)) continue;
    const auto place = std::find_if(with_stopped_.pairs.begin(), with_stopped_.pairs.end(),
                                    [&](const PairResult& known) { return known.a == a && known.b == b; });
    const bool known = place != with_stopped_.pairs.end();
    const PairResult pair = own_.contacts_of_stop(scene, a, b, known ? &*place : nullptr, with_stopped_);
    if (known)
      *place = pair;
    else
      with_stopped_.pairs.push_back(pair);
  }
  return with_stopped_;
}

bool MotionStops::is_elsewhere(const IdPair& ids) const {
  return std::binary_search(elsewhere_.begin(), elsewhere_.end(), ids);
}

}  // namespace tandem::mpi
