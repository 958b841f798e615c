#include "bodies.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "scene/scene_changes.h"

namespace tandem::mpi {
namespace {

constexpr std::size_t bodies_a_block = 512;

/// The largest float that is not above x.
float down(double x) {
  constexpr double most = std::numeric_limits<float>::max();
  x = std::clamp(x, -most, most);
  const auto nearest = static_cast<float>(x);
  return double{nearest} > x ? std::nextafterf(nearest, -std::numeric_limits<float>::infinity()) : nearest;
}

FloatBox outward(const Bounds& bounds, double grow) {
  FloatBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    box.lo[i] = down(bounds.lo[axis] - grow);
    box.hi[i] = -down(-(bounds.hi[axis] + grow));
  }
  return box;
}

/// A scene calls a body by its index, which nobody knows here.
[[noreturn]] void rethrow_for(GlobalId id, const std::invalid_argument& error) {
  const std::string text = error.what();
  const std::size_t colon = text.find(':');
  const bool named = text.starts_with("body ") && colon != std::string::npos;
  throw std::invalid_argument("body " + std::to_string(id) + ": " + (named ? text.substr(colon + 2) : text));
}

std::uint64_t mixed(std::uint64_t hash, double x) {
  hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x100000001b3u;
  return hash ^ hash >> 32;
}

}  // namespace

Bodies::Bodies(Communicator& communicator, double margin, int threads)
    : communicator_(communicator), margin_(margin), alone_(threads == 1), directory_(communicator) {
  if (threads > 1) arena_ = std::make_unique<tbb::task_arena>(threads);
  letter_of_.assign(static_cast<std::size_t>(communicator.ranks()), -1);
}

ShapeId Bodies::add_shape(Shape shape, std::string name) {
  if (shape.is_bounded()) {
    const Bounds box = shape.bounds({});
    centres_.push_back((box.lo + box.hi) / 2);
  } else {
    centres_.push_back(Vec3::Zero());
  }
  // What tells shapes apart in all but contrived cases.
  const MassProperties& mass = shape.mass();
  shapes_hash_ = mixed(shapes_hash_, static_cast<double>(shape.kind()));
  for (const double parameter : shape.parameters()) shapes_hash_ = mixed(shapes_hash_, parameter);
  for (const double x : {shape.size(), mass.volume, mass.centre.x(), mass.centre.y(), mass.centre.z(),
                         mass.inertia(0, 0), mass.inertia(1, 1), mass.inertia(2, 2), mass.inertia(0, 1)})
    shapes_hash_ = mixed(shapes_hash_, x);
  door_.add_shape(shape);
  return scene_.add_shape(std::move(shape), std::move(name));
}

BodyRecord Bodies::checked(GlobalId id, const BodyOptions& body) {
  try {
    const BodyId visitor = door_.add_body(body);
    const BodyRecord record = BodyRecord::of(id, door_, visitor.index());
    door_.remove_body(visitor);
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
  fresh_.resize(size);
  seen_.resize(size);
  boxes_.resize(size);
  copies_.resize(size);
}

/// Adds a body to the scene with the very bits that it has elsewhere, or puts it in the place of the one that is there.
std::uint32_t Bodies::put(const BodyRecord& record, bool owned) {
  const GlobalId id = record.motion.id;
  if (const auto before = place(id)) drop(*before);
  BodyOptions options;
  options.shape = scene_.has_shape(record.shape) ? ShapeId{record.shape + 1, 1} : ShapeId{};
  options.density = record.density;
  options.is_static = record.is_static != 0;
  options.is_sensor = record.is_sensor != 0;
  options.group = record.group;
  options.mask = record.mask;
  const std::uint32_t index = scene_.add_body(options).index();
  // Not by the options: what comes from a response is not made orthonormal again.
  scene_.move(index, record.motion.pose(), record.motion.speed(), record.motion.spin());
  prepare(index);
  places_[id] = index;
  ids_[index] = id;
  owned_[index] = owned ? 1 : 0;
  count_ += owned ? 1 : 0;
  resend_[index] = 0;
  seen_[index] = SceneChanges::versions(scene_)[index] - 1;
  copies_[index].clear();
  return index;
}

void Bodies::drop(std::uint32_t index) {
  count_ -= owned_[index];
  owned_[index] = 0;
  places_.erase(ids_[index]);
  scene_.remove_body(scene_.id(index));
}

void Bodies::apply(const Change& change) {
  using Kind = Change::Kind;
  const GlobalId id = change.id();
  if (change.kind == Kind::add) {
    if (owns_id(id)) throw std::invalid_argument("body " + std::to_string(id) + ": exists already");
    put(change.body, true);
    directory_.came(id);
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
      for (const int rank : copies_[index]) {
        to(rank).put(Item::gone);
        to(rank).put(id);
      }
      drop(index);
      directory_.gone(id);
      if (notes_removed_) removed_.push_back(id);
      break;
    case Kind::pose:
      scene_.move(index, motion.pose(), scene_.velocities()[index], scene_.angular_velocities()[index]);
      break;
    case Kind::velocity:
      scene_.move(index, scene_.poses()[index], motion.speed(), motion.spin());
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
  }
  if (change.kind == Kind::shape || change.kind == Kind::filter || change.kind == Kind::is_static) resend_[index] = 1;
}

Vec3 Bodies::centre(std::uint32_t index) const {
  return scene_.poses()[index] * centres_[scene_.shape_indices()[index]];
}

Message& Bodies::to(int rank) {
  int& place = letter_of_[static_cast<std::size_t>(rank)];
  if (place < 0) {
    place = static_cast<int>(used_++);
    if (used_ > letters_.size()) letters_.emplace_back();
    letters_[used_ - 1].rank = rank;
    letters_[used_ - 1].message.clear();
  }
  return letters_[static_cast<std::size_t>(place)].message;
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

void Bodies::look_at(std::uint32_t index, const Regions& regions) {
  seen_[index] = SceneChanges::versions(scene_)[index];
  boxes_[index] = outward(scene_.shape_of(index).bounds(scene_.poses()[index]), 0.5 * margin_);
  inside_[index] = regions.holds(boxes_[index]) ? 1 : 0;
  fresh_[index] = 1;
}

/// Of an owned body whose box is new: to whom it goes, and who needs a copy.
void Bodies::tell_about(std::uint32_t index, const Regions& regions) {
  const auto middle = place_of_centre(index);
  const bool stays = regions.holds(middle);
  std::vector<int>& copies = copies_[index];
  const bool resend = std::exchange(resend_[index], std::uint8_t{0}) != 0;
  if (stays && inside_[index] != 0 && copies.empty()) return;
  const int own = communicator_.rank(), owner = stays ? own : regions.owner(middle);
  const GlobalId id = ids_[index];
  bool stays_as_copy = false;
  std::vector<int> wanted;
  for (const int rank : regions.reached(boxes_[index])) {
    stays_as_copy = stays_as_copy || (rank == own && owner != own);
    if (rank != owner) wanted.push_back(rank);
  }
  for (const int rank : copies)
    if (rank != owner && !std::binary_search(wanted.begin(), wanted.end(), rank)) {
      to(rank).put(Item::gone);
      to(rank).put(id);
    }
  for (const int rank : wanted) {
    if (rank == own) continue;
    if (!resend && std::binary_search(copies.begin(), copies.end(), rank)) {
      to(rank).put(Item::moved);
      to(rank).put(MotionRecord::of(id, scene_, index));
    } else {
      to(rank).put(Item::body);
      to(rank).put(BodyRecord::of(id, scene_, index));
    }
  }
  if (owner == own) {
    copies = std::move(wanted);
    return;
  }
  Message& letter = to(owner);
  letter.put(Item::owned);
  letter.put(BodyRecord::of(id, scene_, index));
  letter.put(static_cast<std::uint32_t>(wanted.size()));
  for (const int rank : wanted) letter.put(rank);
  ++moved_away_;
  copies.clear();
  if (!stays_as_copy) return drop(index);
  owned_[index] = 0;
  --count_;
}

void Bodies::take(Letter& letter) {
  Message& message = letter.message;
  while (!message.done()) {
    switch (message.take<Item>()) {
      case Item::body:
        put(message.take<BodyRecord>(), false);
        break;
      case Item::owned: {
        const auto record = message.take<BodyRecord>();
        const std::uint32_t index = put(record, true);
        const auto count = message.take<std::uint32_t>();
        for (std::uint32_t i = 0; i < count; ++i) copies_[index].push_back(message.take<int>());
        directory_.came(record.motion.id);
        break;
      }
      case Item::moved: {
        const auto motion = message.take<MotionRecord>();
        scene_.move(places_.at(motion.id), motion.pose(), motion.speed(), motion.spin());
        break;
      }
      case Item::gone:
        if (const auto index = place(message.take<GlobalId>())) drop(*index);
        break;
      case Item::change:
        throw std::logic_error("a change came among bodies");
    }
  }
}

Bodies::Sent Bodies::exchange(const Regions& regions, bool recut) {
  moved_away_ = 0;
  const auto versions = SceneChanges::versions(scene_);
  prepare(0);
  for_each_index([&](std::uint32_t i) {
    fresh_[i] = 0;
    if (owned_[i] == 0) return;
    if (recut || resend_[i] != 0 || seen_[i] != versions[i]) look_at(i, regions);
  });
  for (std::uint32_t i = 0; i < scene_.indices(); ++i)
    if (fresh_[i] != 0 && owned_[i] != 0) tell_about(i, regions);
  Sent sent{moved_away_, 0, used_};
  for (Letter& letter : std::span(letters_).first(used_)) {
    sent.bytes += letter.message.size();
    letter_of_[static_cast<std::size_t>(letter.rank)] = -1;
  }
  communicator_.exchange(std::span(letters_).first(used_), received_);
  used_ = 0;
  for (Letter& letter : received_) take(letter);
  // Copies, and what has come: where the regions are others, all copies are either side of other cuts.
  for_each_index([&](std::uint32_t i) {
    if (!scene_.alive(i)) return;
    if (seen_[i] != SceneChanges::versions(scene_)[i] || (recut && owned_[i] == 0)) look_at(i, regions);
  });
  return sent;
}

}  // namespace tandem::mpi
