// The scene: bodies and shapes by id, validation of all changes, and the versions that pipelines and queries compare.
#include "tandem/engine/scene.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "tandem/narrowphase/shape_memory.h"

namespace tandem {
namespace {

template <typename Value>
[[noreturn]] void refuse(const std::string& what, std::string_view field, const Value& found,
                         std::string_view allowed) {
  std::ostringstream message;
  message.precision(17);
  message << what << ": " << field << " is " << found << ", allowed: " << allowed;
  throw std::invalid_argument(message.str());
}

std::string written(const Vec3& v) {
  std::ostringstream out;
  out.precision(17);
  out << '[' << v.x() << ", " << v.y() << ", " << v.z() << ']';
  return out.str();
}

void require_finite(const Vec3& v, const std::string& what, std::string_view field) {
  if (!v.allFinite()) refuse(what, field, written(v), "finite numbers");
}

/// The capacity of full lists of this size: a quarter more, where a vector would double it and leave a third of it
/// empty on average.
std::size_t grown(std::size_t size) { return size + size / 4 + 8; }

std::string body_name(std::uint32_t index) { return "body " + std::to_string(index); }

}  // namespace

Scene::History::History() : mark_(std::make_shared<char>()) {}
Scene::History::History(const History&) : History() {}
Scene::History& Scene::History::operator=(const History& other) {
  if (this != &other) mark_ = std::make_shared<char>();
  return *this;
}

ShapeId Scene::add_shape(Shape shape, std::string shape_name) {
  ++kinds_[static_cast<std::size_t>(shape.kind())];
  ++shape_changes_;
  if (free_shapes_.empty()) {
    if (shapes_.size() == shapes_.capacity()) reserve(0, grown(shapes_.size()));
    shapes_.push_back(std::move(shape));
    shape_generation_.push_back(1);
    shape_users_.push_back(0);
    shape_alive_.push_back(1);
    set_name(shapes_.size() - 1, std::move(shape_name));
    return {static_cast<std::uint32_t>(shapes_.size()), 1};
  }
  const std::uint32_t place = free_shapes_.back();
  free_shapes_.pop_back();
  shapes_[place] = std::move(shape);
  set_name(place, std::move(shape_name));
  shape_alive_[place] = 1;
  return {place + 1, shape_generation_[place]};
}

void Scene::set_name(std::size_t place, std::string shape_name) {
  if (place >= shape_names_.size()) {
    if (shape_name.empty()) return;
    shape_names_.resize(place + 1);
  }
  shape_names_[place] = std::move(shape_name);
}

std::string_view Scene::shape_name(std::uint32_t place) const {
  return place < shape_names_.size() ? std::string_view(shape_names_[place]) : std::string_view();
}

SceneMemory Scene::memory() const {
  const auto bytes = [](const auto&... list) { return (std::size_t{0} + ... + (list.capacity() * sizeof(list[0]))); };
  SceneMemory memory;
  memory.bodies = bytes(shape_, generation_, groups_, masks_, free_, poses_, velocities_, angular_velocities_,
                        densities_, is_static_, is_sensor_, continuous_, alive_, versions_);
  memory.shapes = bytes(shapes_, shape_generation_, shape_users_, free_shapes_, shape_alive_);
  memory.shape_names = bytes(shape_names_);
  for (const std::string& shape_name : shape_names_)
    if (shape_name.capacity() > std::string().capacity()) memory.shape_names += shape_name.capacity() + 1;
  memory.shapes += memory_of(shapes_);
  return memory;
}

std::uint32_t Scene::checked(ShapeId id, std::string_view what) const {
  const std::uint32_t place = id.index_plus_one - 1;
  if (id.index_plus_one == 0 || id.index_plus_one > shapes_.size())
    refuse(std::string(what), "shape", "number " + std::to_string(id.index_plus_one),
           "1 to " + std::to_string(shapes_.size()) + ", the shapes of this scene");
  if (!shape_alive_[place] || shape_generation_[place] != id.generation)
    refuse(std::string(what), "shape",
           "number " + std::to_string(id.index_plus_one) + " of generation " + std::to_string(id.generation),
           "a shape that was not removed");
  return place;
}

void Scene::remove_shape(ShapeId id) {
  const std::uint32_t place = checked(id, "remove_shape");
  if (shape_users_[place] != 0)
    refuse("remove_shape", "shape", "number " + std::to_string(id.index_plus_one),
           "one that no body has; this one has " + std::to_string(shape_users_[place]));
  --kinds_[static_cast<std::size_t>(shapes_[place].kind())];
  ++shape_changes_;
  shapes_[place] = Sphere{0};
  set_name(place, {});
  shape_alive_[place] = 0;
  if (++shape_generation_[place] != 0) free_shapes_.push_back(place);
}

void Scene::replace_shape(ShapeId id, Shape shape) {
  const std::uint32_t place = checked(id, "replace_shape");
  const auto has_it = [&](std::uint32_t index) { return alive_[index] != 0 && shape_[index] == place; };
  for (std::uint32_t i = 0; i < shape_.size() && !shape.is_bounded(); ++i)
    if (has_it(i) && is_static_[i] == 0) require_may_move(i, shape, densities_[i]);
  --kinds_[static_cast<std::size_t>(shapes_[place].kind())];
  ++kinds_[static_cast<std::size_t>(shape.kind())];
  ++shape_changes_;
  shapes_[place] = std::move(shape);
  for (std::uint32_t i = 0; i < shape_.size(); ++i)
    if (has_it(i)) changed(i);
}

void Scene::require_may_move(std::uint32_t index, const Shape& shape, double density) const {
  if (!std::isfinite(density) || density <= 0) refuse(body_name(index), "density", density, "finite, > 0 kg/m^3");
  if (shape.is_bounded()) return;
  const std::string kind = shape.kind() == ShapeKind::plane ? "plane" : "half-space";
  refuse(body_name(index), "is_static", "false", "true, as its shape is a " + kind);
}

BodyId Scene::add_body(const BodyOptions& options) {
  const std::uint32_t index = free_.empty() ? static_cast<std::uint32_t>(poses_.size()) : free_.back();
  const std::string what = body_name(index);
  const std::uint32_t shape = checked(options.shape, what);
  require_valid(options.pose, what);
  require_finite(options.velocity, what, "velocity");
  require_finite(options.angular_velocity, what, "angular_velocity");
  if (!options.is_static) require_may_move(index, shapes_[shape], options.density);
  if (free_.empty()) {
    if (index == 0xffffffffu) refuse("scene", "bodies", index, "fewer than 4294967295");
    const std::size_t size = poses_.size() + 1;
    if (size > poses_.capacity()) reserve(grown(poses_.size()));
    shape_.resize(size);
    generation_.resize(size, 1);
    groups_.resize(size);
    masks_.resize(size);
    poses_.resize(size);
    velocities_.resize(size);
    angular_velocities_.resize(size);
    densities_.resize(size);
    is_static_.resize(size);
    is_sensor_.resize(size);
    continuous_.resize(size);
    alive_.resize(size);
    versions_.resize(size);
  } else {
    free_.pop_back();
  }
  shape_[index] = shape;
  ++shape_users_[shape];
  groups_[index] = options.group;
  masks_[index] = options.mask;
  poses_[index] = orthonormalized(options.pose);
  velocities_[index] = options.velocity;
  angular_velocities_[index] = options.angular_velocity;
  densities_[index] = options.density;
  is_static_[index] = options.is_static;
  is_sensor_[index] = options.is_sensor;
  continuous_[index] = options.continuous;
  continuous_count_ += continuous_[index];
  alive_[index] = 1;
  changed(index);
  ++count_;
  return {index + 1, generation_[index]};
}

std::uint32_t Scene::checked(BodyId id) const {
  if (id.slot_plus_one == 0 || id.slot_plus_one > poses_.size())
    refuse("body id", "slot_plus_one", id.slot_plus_one, "1 to " + std::to_string(poses_.size()));
  const std::uint32_t index = id.index();
  if (!alive_[index] || generation_[index] != id.generation)
    refuse(body_name(index), "generation", id.generation,
           alive_[index] ? std::to_string(generation_[index]) + ": the body this id named was removed"
                         : "none: the body was removed");
  return index;
}

/// Records a change of more than the pose: as if another body came in its place.
void Scene::changed(std::uint32_t index) {
  ++versions_[index];
  ++comings_and_goings_;
}

void Scene::remove_body(BodyId id) {
  const std::uint32_t index = checked(id);
  alive_[index] = 0;
  --shape_users_[shape_[index]];
  continuous_count_ -= continuous_[index];
  changed(index);
  --count_;
  // A slot whose generations are used up is abandoned: an old id must never become valid again.
  if (++generation_[index] != 0) free_.push_back(index);
}

void Scene::set_pose(BodyId id, const Pose& pose) {
  const std::uint32_t index = checked(id);
  require_valid(pose, body_name(index));
  poses_[index] = orthonormalized(pose);
  ++versions_[index];
}

void Scene::set_poses(std::span<const BodyId> ids, std::span<const Pose> poses) {
  if (ids.size() != poses.size())
    refuse("set_poses", "poses", std::to_string(poses.size()), std::to_string(ids.size()) + ", one a body");
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ids.size(), 512), [&](const auto& block) {
    for (std::size_t i = block.begin(); i != block.end(); ++i) {
      const std::uint32_t index = checked(ids[i]);
      if (!is_valid(poses[i])) require_valid(poses[i], body_name(index));
    }
  });
  // In order: the last pose of a repeated body counts.
  for (std::size_t i = 0; i < ids.size(); ++i) {
    poses_[ids[i].index()] = orthonormalized(poses[i]);
    ++versions_[ids[i].index()];
  }
}

void Scene::set_shape(BodyId id, ShapeId shape) {
  const std::uint32_t index = checked(id), place = checked(shape, body_name(index));
  if (is_static_[index] == 0) require_may_move(index, shapes_[place], densities_[index]);
  --shape_users_[shape_[index]];
  ++shape_users_[place];
  shape_[index] = place;
  changed(index);
}

void Scene::set_filter(BodyId id, std::uint32_t group, std::uint32_t mask) {
  const std::uint32_t index = checked(id);
  groups_[index] = group;
  masks_[index] = mask;
  changed(index);
}

void Scene::set_static(BodyId id, bool is_static) {
  const std::uint32_t index = checked(id);
  if (!is_static) require_may_move(index, shapes_[shape_[index]], densities_[index]);
  is_static_[index] = is_static;
  changed(index);
}

void Scene::set_continuous(BodyId id, bool continuous) {
  const std::uint32_t index = checked(id);
  continuous_count_ -= continuous_[index];
  continuous_[index] = continuous;
  continuous_count_ += continuous_[index];
}

void Scene::set_density(BodyId id, double density) {
  const std::uint32_t index = checked(id);
  if (is_static_[index] == 0) require_may_move(index, shapes_[shape_[index]], density);
  densities_[index] = density;
}

void Scene::set_sensor(BodyId id, bool is_sensor) { is_sensor_[checked(id)] = is_sensor; }

void Scene::reserve(std::size_t bodies, std::size_t shapes) {
  const auto each = [](std::size_t size, auto&... lists) { (lists.reserve(size), ...); };
  each(bodies, shape_, generation_, groups_, masks_, poses_, velocities_, angular_velocities_, densities_, is_static_,
       is_sensor_, continuous_, alive_, versions_);
  each(shapes, shape_generation_, shape_users_, shape_alive_, shapes_);
}

ShapeId Scene::shape_id(BodyId id) const {
  const std::uint32_t place = shape_[checked(id)];
  return {place + 1, shape_generation_[place]};
}

void Scene::set_velocity(BodyId id, const Vec3& velocity, const Vec3& angular_velocity) {
  const std::uint32_t index = checked(id);
  require_finite(velocity, body_name(index), "velocity");
  require_finite(angular_velocity, body_name(index), "angular_velocity");
  velocities_[index] = velocity;
  angular_velocities_[index] = angular_velocity;
}

const Pose& Scene::pose(BodyId id) const { return poses_[checked(id)]; }

BodyId Scene::id(std::uint32_t index) const {
  if (index >= poses_.size() || !alive_[index])
    refuse("scene", "index", index, "that of a body, below " + std::to_string(poses_.size()));
  return {index + 1, generation_[index]};
}

void Scene::move(std::uint32_t index, const Pose& pose, const Vec3& velocity, const Vec3& angular_velocity) {
  poses_[index] = pose;
  ++versions_[index];
  velocities_[index] = velocity;
  angular_velocities_[index] = angular_velocity;
}

}  // namespace tandem
