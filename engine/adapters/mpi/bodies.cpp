// The bodies of one rank: owned ones and copies, and the messages that keep copies up to date.
#include "bodies.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "cpu_time.h"
#include "scene/tolerances.h"

namespace tandem::mpi {
namespace {

constexpr std::size_t bodies_a_block = 512;
/// Fraction of a body's radius by which its box may grow before its copies are chosen anew. A larger skin means more
/// copies, a smaller one more frequent choices.
constexpr double skin_share = 0.1;
/// Seconds: along each axis a skin reaches as far as the body moves in this time, at most its radius. A body that falls
/// past vertical cuts therefore does not leave its skin early.
constexpr double skin_time = 0.06;
/// Factor on the radius of a ball about a shape's box: covers the rounding of rotations and bounds.
constexpr double ball_share = 1.01;
/// Factor on how far a body at rest may be from the pose at which its rest began: the pipeline's box is that of the
/// rest pose, grown by this distance, while this box is about the present pose. Twice the distance, and what rounding
/// may add.
constexpr double rest_twice = 2.1;

using Clock = std::chrono::steady_clock;

FloatBox outward(const Bounds& bounds, double grow) {
  FloatBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    box.lo[i] = round_down(bounds.lo[axis] - grow);
    box.hi[i] = round_up(bounds.hi[axis] + grow);
  }
  return box;
}

/// The region such that doubles in it, rounded outward to floats, stay in the given one.
Region calm_within(Region region) {
  const auto inward = [](double x) {
    constexpr double two_floats = 2 * std::numeric_limits<float>::epsilon();
    return std::isfinite(x) ? two_floats * std::abs(x) + std::numeric_limits<float>::min() : 0;
  };
  for (double& x : region.lo) x += inward(x);
  for (double& x : region.hi) x -= inward(x);
  return region;
}

/// Rethrows an error of the scene with the body's id: the scene names a body by its index, which the caller does not
/// know.
[[noreturn]] void rethrow_for(GlobalId id, const std::invalid_argument& error) {
  const std::string text = error.what();
  const std::size_t colon = text.find(':');
  const bool named = text.starts_with("body ") && colon != std::string::npos;
  throw std::invalid_argument("body " + std::to_string(id) + ": " + (named ? text.substr(colon + 2) : text));
}

}  // namespace

Bodies::Bodies(Communicator& communicator, const Regions& regions, double margin, int threads, double rest)
    : communicator_(communicator),
      regions_(regions),
      margin_(margin),
      rest_(rest),
      alone_(threads == 1),
      directory_(communicator) {
  if (threads > 1) arena_ = std::make_unique<tbb::task_arena>(threads);
  message_of_.assign(static_cast<std::size_t>(communicator.ranks()), -1);
  is_neighbour_.assign(static_cast<std::size_t>(communicator.ranks()), 0);
  calm_ = calm_within(regions_.own());
}

ShapeId Bodies::add_shape(Shape shape, std::string name) {
  Ball& ball = balls_.emplace_back();
  ball.grow = 0.5 * margin_;
  if (shape.is_bounded()) {
    ball.grow += rest_twice * rest_ * shape.size();
    const Bounds box = shape.bounds({});
    ball.centre = (box.lo + box.hi) / 2;
    const double radius = shape.kind() == ShapeKind::sphere ? shape.radius() : (box.hi - box.lo).norm() / 2;
    ball.radius = ball_share * radius;
    ball.reach = ball_share * (ball.centre.norm() + radius);
  } else {
    ball.radius = ball.reach = std::numeric_limits<double>::infinity();
  }
  // These numbers distinguish shapes in all but contrived cases.
  const MassProperties mass = shape.mass();
  shapes_hash_.add(static_cast<double>(shape.kind()));
  for (const double parameter : shape.parameters()) shapes_hash_.add(parameter);
  for (const double x : {shape.size(), mass.volume, mass.centre.x(), mass.centre.y(), mass.centre.z(),
                         mass.inertia(0, 0), mass.inertia(1, 1), mass.inertia(2, 2), mass.inertia(0, 1)})
    shapes_hash_.add(x);
  return scene_.add_shape(std::move(shape), std::move(name));
}

BodyRecord Bodies::checked(GlobalId id, const BodyOptions& body) {
  const std::uint32_t shape = body.shape.index_plus_one;
  const bool known = shape != 0 && shape <= scene_.shapes().size() && body.shape.generation == 1;
  if (known && door_shape_ != shape) {
    door_ = Scene();
    door_.add_shape(scene_.shapes()[shape - 1]);
    door_shape_ = shape;
  }
  try {
    BodyOptions visitor = body;
    if (known) visitor.shape = {1, 1};
    const BodyId at = door_.add_body(visitor);
    BodyRecord record = BodyRecord::of(id, door_, at.index());
    record.shape = shape - 1;
    door_.remove_body(at);
    return record;
  } catch (const std::invalid_argument& error) {
    rethrow_for(id, error);
  }
}

void Bodies::prepare(std::uint32_t index) {
  const std::size_t size = std::max<std::size_t>(index + 1, scene_.indices());
  if (ids_.size() >= size) return;
  ids_.resize(size);
  owned_.resize(size);
  resend_.resize(size);
  inside_.resize(size);
  unchecked_.resize(size);
  queued_.resize(size);
  is_new_.resize(size);
  departure_of_.resize(size, no_edge);
  edge_of_.resize(size, no_edge);
}

/// Adds a body to the scene with exactly the bits that it has on the other rank, or gives these to the body that is
/// there.
std::uint32_t Bodies::put(const BodyRecord& record, bool owned) {
  ++changes_;
  const GlobalId id = record.motion.id;
  if (const auto before = place(id)) {
    give_back_edge(*before);
    resend_[*before] = queued_[*before] = 0;
    update(*before, record);
    count_ += owned ? 1 : 0;
    count_ -= owned_[*before];
    owned_[*before] = unchecked_[*before] = owned ? 1 : 0;
    return *before;
  }
  const ShapeId shape = scene_.has_shape(record.shape) ? ShapeId{record.shape + 1, 1} : ShapeId{};
  const std::uint32_t index = record.add_to(scene_, shape);
  prepare(index);
  places_[id] = index;
  ids_[index] = id;
  owned_[index] = owned ? 1 : 0;
  count_ += owned ? 1 : 0;
  unchecked_[index] = owned ? 1 : 0;
  is_new_[index] = 1;
  if (kept_ != nullptr) arrivals_.push_back({index, {}});
  return index;
}

void Bodies::update(std::uint32_t index, const BodyRecord& record) {
  const BodyId body = scene_.id(index);
  if (record.is_static != 0) scene_.set_static(body, true);  // first static, for which any shape is permitted
  scene_.set_shape(body, {record.shape + 1, 1});
  scene_.set_filter(body, record.group, record.mask);
  scene_.set_density(body, record.density);
  if (record.is_static == 0) scene_.set_static(body, false);
  scene_.set_sensor(body, record.is_sensor != 0);
  scene_.set_continuous(body, record.is_continuous != 0);
  scene_.move(index, record.motion.pose(), record.motion.speed(), record.motion.spin());
}

void Bodies::drop(std::uint32_t index) {
  ++changes_;
  if (kept_ != nullptr && is_new_[index] == 0) {
    departure_of_[index] = static_cast<std::uint32_t>(departures_.size());
    departures_.push_back({ids_[index], box_now(index, 0)});
  } else if (kept_ != nullptr) {
    std::erase_if(arrivals_, [index](const KeptBody& body) { return body.index == index; });
  }
  count_ -= owned_[index];
  owned_[index] = 0;
  resend_[index] = unchecked_[index] = queued_[index] = 0;
  give_back_edge(index);
  places_.erase(ids_[index]);
  scene_.remove_body(scene_.id(index));
}

void Bodies::apply(const Change& change) {
  using Kind = Change::Kind;
  const GlobalId id = change.id();
  if (change.kind == Kind::add) {
    if (owns_id(id)) throw std::invalid_argument("body " + std::to_string(id) + ": exists already");
    put(change.body, true);
    directory_.arrived(id);
    return;
  }
  const auto index = place(id);
  if (!index || !owns(*index)) throw std::invalid_argument("body " + std::to_string(id) + ": does not exist");
  try {
    apply_to(*index, change);
  } catch (const std::invalid_argument& error) {
    rethrow_for(id, error);
  }
}

void Bodies::apply_to(std::uint32_t index, const Change& change) {
  using Kind = Change::Kind;
  const GlobalId id = change.id();
  const BodyId body = scene_.id(index);
  const MotionRecord& motion = change.body.motion;
  switch (change.kind) {
    case Kind::add:
      break;
    case Kind::remove:
      if (edge_of_[index] != no_edge)
        for (const int rank : edges_[edge_of_[index]].copies) {
          to(rank).put(Item::gone);
          to(rank).put(id);
        }
      drop(index);
      directory_.removed(id);
      if (notes_removed_) removed_.push_back(id);
      break;
    case Kind::pose:
      move(index, motion.pose(), scene_.velocities()[index], scene_.angular_velocities()[index]);
      break;
    case Kind::velocity:
      move(index, scene_.poses()[index], motion.speed(), motion.spin());
      break;
    case Kind::shape:
      scene_.set_shape(body, {change.body.shape + 1, 1});
      break;
    case Kind::filter:
      scene_.set_filter(body, change.body.group, change.body.mask);
      break;
    case Kind::is_static:
      scene_.set_static(body, change.body.is_static != 0);
      break;
    case Kind::density:
      scene_.set_density(body, change.body.density);
      break;
    case Kind::is_sensor:
      scene_.set_sensor(body, change.body.is_sensor != 0);
      break;
    case Kind::continuous:
      scene_.set_continuous(body, change.body.is_continuous != 0);
      break;
  }
  if (change.kind >= Kind::shape) resend_[index] = unchecked_[index] = 1;
}

Vec3 Bodies::centre(std::uint32_t index) const {
  return scene_.poses()[index] * balls_[scene_.shape_indices()[index]].centre;
}

Message& Bodies::to(int rank) {
  expected_ = expected_ && is_neighbour_[static_cast<std::size_t>(rank)] != 0;
  int& place = message_of_[static_cast<std::size_t>(rank)];
  if (place < 0) {
    place = static_cast<int>(used_++);
    if (used_ > outgoing_.size()) outgoing_.emplace_back();
    outgoing_[used_ - 1].rank = rank;
    outgoing_[used_ - 1].content.clear();
  }
  return outgoing_[static_cast<std::size_t>(place)].content;
}

template <class Body>
void Bodies::for_each_index(const Body& body) const {
  const std::size_t count = scene_.indices();
  if (alone_ || count <= bodies_a_block) {
    for (std::size_t i = 0; i < count; ++i) body(static_cast<std::uint32_t>(i));
    return;
  }
  const auto run = [&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, bodies_a_block), [&](const auto& block) {
      for (std::size_t i = block.begin(); i != block.end(); ++i) body(static_cast<std::uint32_t>(i));
    });
  };
  if (arena_)
    arena_->execute(run);
  else
    run();
}

/// True if a body is so far inside the region that no other rank need know of it, in whatever orientation.
bool Bodies::is_calm(std::uint32_t index) const {
  const Vec3& place = scene_.poses()[index].translation;
  const Ball& ball = balls_[scene_.shape_indices()[index]];
  const double reach = ball.reach + ball.grow;
  bool calm = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = place[static_cast<Eigen::Index>(i)];
    calm &= calm_.lo[i] < x - reach && x + reach <= calm_.hi[i];
  }
  return calm;
}

/// True if a body with an edge stays in its skin in whatever orientation.
bool Bodies::is_in_skin(const Edge& edge) const {
  const Vec3& place = scene_.poses()[edge.index].translation;
  const Ball& ball = balls_[scene_.shape_indices()[edge.index]];
  const double reach = ball.reach + ball.grow;
  bool in = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = place[static_cast<Eigen::Index>(i)];
    in &= double{edge.skin.lo[i]} < x - reach && x + reach < double{edge.skin.hi[i]};
  }
  return in;
}

/// The distance in metres by which a box may grow.
double Bodies::skin(std::uint32_t index) const {
  const double radius = balls_[scene_.shape_indices()[index]].radius;
  return scene_.is_static()[index] != 0 ? 0 : skin_share * radius;
}

/// The body's box at present, with a skin; the skin's box also covers where the velocity takes the body.
FloatBox Bodies::box_now(std::uint32_t index, double skin) const {
  Bounds bounds = scene_.shape_of(index).bounds(scene_.poses()[index]);
  const Ball& ball = balls_[scene_.shape_indices()[index]];
  if (skin > 0) {
    const double most = ball.radius;
    const Vec3 ahead = (skin_time * scene_.velocities()[index]).cwiseAbs().cwiseMin(most);
    bounds.lo -= ahead;
    bounds.hi += ahead;
  }
  return outward(bounds, ball.grow + skin);
}

Bodies::Edge& Bodies::edge(std::uint32_t index) {
  std::uint32_t& place = edge_of_[index];
  if (place == no_edge) {
    if (free_edges_.empty()) {
      place = static_cast<std::uint32_t>(edges_.size());
      edges_.emplace_back();
    } else {
      place = free_edges_.back();
      free_edges_.pop_back();
    }
    edges_[place].index = index;
    edges_[place].copies.clear();
  }
  return edges_[place];
}

void Bodies::give_back_edge(std::uint32_t index) {
  const std::uint32_t place = std::exchange(edge_of_[index], no_edge);
  if (place == no_edge) return;
  edges_[place].index = no_edge;
  free_edges_.push_back(place);
}

void Bodies::take_box(Edge& edge, const FloatBox& box) {
  edge.box = box;
  edge.seen = SceneChanges::versions(scene_)[edge.index];
  inside_[edge.index] = regions_.holds(box) ? 1 : 0;
}

void Bodies::queue(std::uint32_t index) {
  if (std::exchange(queued_[index], std::uint8_t{1}) == 0) todo_.push_back(index);
}

/// Marks all bodies to be checked, after the regions have changed: each may be near another region, or in one.
void Bodies::check_all() {
  calm_ = calm_within(regions_.own());
  for_each_index([&](std::uint32_t i) {
    if (owned_[i] == 0 || edge_of_[i] != no_edge) return;
    inside_[i] = is_calm(i) ? 1 : 0;
    unchecked_[i] = 1 - inside_[i];
  });
  for (const Edge& one : edges_) {
    if (one.index == no_edge) continue;
    if (owned_[one.index] != 0)
      queue(one.index);
    else
      inside_[one.index] = regions_.holds(one.box) ? 1 : 0;
  }
}

void Bodies::check_moved() {
  const auto versions = SceneChanges::versions(scene_);
  for (Edge& one : edges_) {
    const std::uint32_t i = one.index;
    if (i == no_edge || owned_[i] == 0 || queued_[i] != 0 || (resend_[i] == 0 && one.seen == versions[i])) continue;
    // Nothing asks for the box of a body that no other rank has, in this rank's region.
    if (one.copies.empty() && inside_[i] != 0 && resend_[i] == 0 && is_in_skin(one)) {
      one.seen = versions[i];
      continue;
    }
    const FloatBox box = box_now(i, 0);
    if (resend_[i] != 0 || !one.skin.holds(box)) {
      queue(i);
      continue;
    }
    take_box(one, box);
    if (one.copies.empty()) continue;
    const MotionRecord motion = MotionRecord::of(ids_[i], scene_, i);
    for (const int rank : one.copies) {
      Message& message = to(rank);
      message.put(Item::moved);
      message.put(motion);
    }
  }
  if (unchecked_.empty()) return;
  std::uint8_t *const begin = unchecked_.data(), *const end = begin + unchecked_.size();
  const auto next = [end](std::uint8_t* from) {
    return static_cast<std::uint8_t*>(std::memchr(from, 1, static_cast<std::size_t>(end - from)));
  };
  for (std::uint8_t* at = next(begin); at != nullptr; at = next(at + 1)) {
    *at = 0;
    queue(static_cast<std::uint32_t>(at - begin));
  }
}

/// True if all ranks that renew() would write to are neighbours.
bool Bodies::are_expected(std::uint32_t index) const {
  const auto known = [&](int rank) {
    return rank == communicator_.rank() || is_neighbour_[static_cast<std::size_t>(rank)] != 0;
  };
  const auto reached = regions_.reached(box_now(index, skin(index)));
  if (!std::all_of(reached.begin(), reached.end(), known)) return false;
  if (!known(regions_.owner(place_of_centre(index)))) return false;
  const std::uint32_t place = edge_of_[index];
  return place == no_edge || std::all_of(edges_[place].copies.begin(), edges_[place].copies.end(), known);
}

bool Bodies::check_ahead() {
  expected_ = true;
  check_moved();
  return expected_ &&
         std::all_of(todo_.begin(), todo_.end(), [this](std::uint32_t index) { return are_expected(index); });
}

void Bodies::check_again() noexcept {
  for (const RankMessage& message : std::span(outgoing_).first(used_))
    message_of_[static_cast<std::size_t>(message.rank)] = -1;
  used_ = 0;
  todo_.clear();
  std::fill(queued_.begin(), queued_.end(), std::uint8_t{0});
  for (std::size_t i = 0; i < owned_.size(); ++i)
    if (owned_[i] != 0 && edge_of_[i] != no_edge) unchecked_[i] = 1;
}

/// Handles an owned body that has left its skin: decides who owns it and who needs a copy from now on.
void Bodies::renew(std::uint32_t index) {
  const int own = communicator_.rank();
  const auto middle = place_of_centre(index);
  const int owner = regions_.holds(middle) ? own : regions_.owner(middle);
  const FloatBox skinned = box_now(index, skin(index));
  bool stays = false;
  std::vector<int> wanted;
  for (const int rank : regions_.reached(skinned)) {
    stays = stays || rank == own;
    if (rank != owner) wanted.push_back(rank);
  }
  Edge& one = edge(index);
  one.skin = skinned;
  take_box(one, box_now(index, 0));
  write_copies(one, owner, wanted);
  resend_[index] = 0;
  if (owner != own) return give_to(owner, index, wanted, stays);
  one.copies = std::move(wanted);
  if (!one.copies.empty() || !is_calm(index)) return;
  give_back_edge(index);
  inside_[index] = 1;
}

void Bodies::write_copies(const Edge& edge, int owner, std::span<const int> wanted) {
  const std::uint32_t index = edge.index;
  const GlobalId id = ids_[index];
  for (const int rank : edge.copies)
    if (rank != owner && !std::binary_search(wanted.begin(), wanted.end(), rank)) {
      if (kept_ != nullptr) {
        to(rank).put(Item::left);
        to(rank).put(BodyRecord::of(id, scene_, index));
      } else {
        to(rank).put(Item::gone);
        to(rank).put(id);
      }
    }
  for (const int rank : wanted) {
    if (rank == communicator_.rank()) continue;
    if (resend_[index] == 0 && std::binary_search(edge.copies.begin(), edge.copies.end(), rank)) {
      to(rank).put(Item::moved);
      to(rank).put(MotionRecord::of(id, scene_, index));
    } else {
      put_body(to(rank), Item::body, index);
    }
    if (owner == communicator_.rank()) continue;
    to(rank).put(Item::owner);
    to(rank).put(id);
    to(rank).put(owner);
  }
}

void Bodies::put_body(Message& message, Item item, std::uint32_t index) const {
  message.put(item);
  message.put(BodyRecord::of(ids_[index], scene_, index));
  if (kept_ != nullptr) message.put(is_new_[index] != 0 ? RestRecord{} : RestRecord::of(kept_->rest(scene_, index)));
}

std::uint32_t Bodies::take_body(Message& message, bool owned) {
  const auto record = message.take<BodyRecord>();
  const bool is_known = has(record.motion.id);
  const std::uint32_t index = put(record, owned);
  if (kept_ == nullptr) return index;
  const auto rest = message.take<RestRecord>();
  if (!is_known) arrivals_.back().rest = rest.rest();  // a rank that has had a copy knows it
  return index;
}

/// Sends a body to another owner; `stays`: a copy of it is needed here.
void Bodies::give_to(int owner, std::uint32_t index, std::span<const int> wanted, bool stays) {
  Message& message = to(owner);
  put_body(message, Item::owned, index);
  message.put(static_cast<std::uint32_t>(wanted.size()));
  for (const int rank : wanted) message.put(rank);
  ++moved_away_;
  if (!stays) return drop(index);
  edge(index).copies.clear();
  edge(index).owner = owner;
  ++changes_;
  owned_[index] = 0;
  --count_;
}

bool Bodies::has_copy(std::uint32_t index, int rank) const {
  const std::uint32_t place = edge_of_[index];
  return place != no_edge && std::binary_search(edges_[place].copies.begin(), edges_[place].copies.end(), rank);
}

void Bodies::write_missing_copy(std::uint32_t index, int rank, Message& message) {
  const bool is_calm = edge_of_[index] == no_edge;
  Edge& one = edge(index);
  if (is_calm) one.box = box_now(index, 0);
  one.seen = SceneChanges::versions(scene_)[index];
  unchecked_[index] = 1;  // others may need a copy where it is now: the next exchange finds out
  one.skin.lo.fill(std::numeric_limits<float>::infinity());
  one.skin.hi.fill(-std::numeric_limits<float>::infinity());
  one.copies.insert(std::upper_bound(one.copies.begin(), one.copies.end(), rank), rank);
  put_body(message, Item::body, index);
}

void Bodies::take_missing_copies(RankMessage& message) {
  while (!message.content.done()) {
    if (message.content.take<Item>() != Item::body) throw std::logic_error("something else came among lent bodies");
    const std::uint32_t index = take_body(message.content, false);
    Edge& one = edge(index);
    take_box(one, box_now(index, 0));
    one.owner = message.rank;
    inside_[index] = 0;  // as of the last exchange, before which it was not here
  }
}

void Bodies::take(RankMessage& received) {
  Message& message = received.content;
  while (!message.done()) {
    switch (message.take<Item>()) {
      case Item::body: {
        const std::uint32_t index = take_body(message, false);
        take_box(edge(index), box_now(index, 0));
        edge(index).owner = received.rank;
        break;
      }
      case Item::owned: {
        const std::uint32_t index = take_body(message, true);
        const auto count = message.take<std::uint32_t>();
        Edge& one = edge(index);
        for (std::uint32_t i = 0; i < count; ++i) one.copies.push_back(message.take<int>());
        one.skin = box_now(index, skin(index));  // the skin for which these copies were chosen
        take_box(one, box_now(index, 0));
        unchecked_[index] = 0;
        directory_.arrived(ids_[index]);
        break;
      }
      case Item::moved: {
        const auto motion = message.take<MotionRecord>();
        const std::uint32_t index = places_.at(motion.id);
        scene_.move(index, motion.pose(), motion.speed(), motion.spin());
        take_box(edge(index), box_now(index, 0));
        edge(index).owner = received.rank;
        break;
      }
      case Item::owner: {
        const std::uint32_t index = places_.at(message.take<GlobalId>());
        edge(index).owner = message.take<int>();
        break;
      }
      case Item::gone:
        if (const auto index = place(message.take<GlobalId>())) drop(*index);
        break;
      case Item::left:
        drop(put(message.take<BodyRecord>(), false));
        break;
      case Item::change:
        throw std::logic_error("a change came among bodies");
      default:
        throw std::out_of_range("a message from another rank has an item of no kind");
    }
  }
}

int Bodies::reporter(Pair last) const {
  const std::uint32_t departure[] = {departure_of_[last.a], departure_of_[last.b]};
  const bool both_are_here = departure[0] == no_edge && departure[1] == no_edge;
  std::array<const FloatBox*, 2> box{};
  for (const std::size_t k : {0u, 1u}) {
    const std::uint32_t index = k == 0 ? last.a : last.b;
    if (departure[k] == no_edge && inside_[index] != 0) return both_are_here ? communicator_.rank() : -1;
    box[k] = departure[k] != no_edge ? &departures_[departure[k]].box : &edges_[edge_of_[index]].box;
  }
  std::array<double, 3> corner{};
  for (std::size_t i = 0; i < 3; ++i) {
    const float lo = std::max(box[0]->lo[i], box[1]->lo[i]);
    if (lo > std::min(box[0]->hi[i], box[1]->hi[i])) return -1;
    corner[i] = lo;
  }
  return regions_.owner(corner);
}

void Bodies::forget_past() {
  for (const KeptBody& body : arrivals_) is_new_[body.index] = 0;
  arrivals_.clear();
  departures_.clear();
  std::fill(departure_of_.begin(), departure_of_.end(), no_edge);
}

/// Makes both directions known: a rank that has sent this rank a message, possibly without getting one, will be sent
/// messages from now on.
void Bodies::add_neighbours(bool recut) {
  if (recut) {
    neighbours_.clear();
    std::fill(is_neighbour_.begin(), is_neighbour_.end(), std::uint8_t{0});
  }
  const auto know = [&](std::span<const RankMessage> messages) {
    for (const RankMessage& message : messages)
      if (std::exchange(is_neighbour_[static_cast<std::size_t>(message.rank)], std::uint8_t{1}) == 0)
        neighbours_.push_back(message.rank);
  };
  know(std::span(outgoing_).first(used_));
  know(received_);
  std::sort(neighbours_.begin(), neighbours_.end());
}

Bodies::Sent Bodies::exchange(bool recut, bool expected) {
  Sent sent;
  sent.begin = Clock::now();
  double cpu = cpu_ms();
  moved_away_ = 0;
  if (recut) check_all();
  if (!expected) check_moved();
  for (const std::uint32_t index : todo_)
    if (std::exchange(queued_[index], std::uint8_t{0}) != 0 && owned_[index] != 0) renew(index);
  todo_.clear();
  if (expected)
    for (const int rank : neighbours_) to(rank);  // an empty message is one, too
  sent.moved_away = moved_away_;
  sent.messages = used_;
  const auto messages = std::span(outgoing_).first(used_);
  for (const RankMessage& message : messages) {
    sent.bytes += message.content.size();
    message_of_[static_cast<std::size_t>(message.rank)] = -1;
  }
  sent.packed = Clock::now();
  sent.cpu_ms = cpu_ms() - cpu;
  if (expected)
    communicator_.exchange_expected(messages, received_);
  else
    communicator_.exchange(messages, received_);
  sent.got = Clock::now();
  cpu = cpu_ms();
  if (!expected) add_neighbours(recut);
  used_ = 0;
  for (RankMessage& message : received_) take(message);
  sent.end = Clock::now();
  sent.cpu_ms += cpu_ms() - cpu;
  return sent;
}

}  // namespace tandem::mpi
