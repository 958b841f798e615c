#include "tandem/engine/scene.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

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

std::string body_name(std::uint32_t index) { return "body " + std::to_string(index); }

}  // namespace

Scene::History::History() : mark_(std::make_shared<char>()) {}
Scene::History::History(const History&) : History() {}
Scene::History& Scene::History::operator=(const History& other) {
  if (this != &other) mark_ = std::make_shared<char>();
  return *this;
}

ShapeId Scene::add_shape(Shape shape, std::string shape_name) {
  shapes_.push_back(std::move(shape));
  shape_names_.push_back(std::move(shape_name));
  return {static_cast<std::uint32_t>(shapes_.size())};
}

BodyId Scene::add_body(const BodyOptions& options) {
  const std::uint32_t index = free_.empty() ? static_cast<std::uint32_t>(poses_.size()) : free_.back();
  const std::string what = body_name(index);
  if (options.shape.index_plus_one == 0 || options.shape.index_plus_one > shapes_.size())
    refuse(what, "shape", "number " + std::to_string(options.shape.index_plus_one),
           "1 to " + std::to_string(shapes_.size()) + ", the shapes of this scene");
  const std::uint32_t shape = options.shape.index_plus_one - 1;
  require_valid(options.pose, what);
  require_finite(options.velocity, what, "velocity");
  require_finite(options.angular_velocity, what, "angular_velocity");
  if (!options.is_static) {
    if (!std::isfinite(options.density) || options.density <= 0)
      refuse(what, "density", options.density, "finite, > 0 kg/m^3");
    if (!shapes_[shape].is_bounded()) refuse(what, "is_static", "false", "true, as its shape is a half-space");
  }
  if (free_.empty()) {
    if (index == 0xffffffffu) refuse("scene", "bodies", index, "fewer than 4294967295");
    const std::size_t size = poses_.size() + 1;
    shape_.resize(size);
    generation_.resize(size, 1);
    groups_.resize(size);
    masks_.resize(size);
    poses_.resize(size);
    velocities_.resize(size);
    angular_velocities_.resize(size);
    densities_.resize(size);
    is_static_.resize(size);
    alive_.resize(size);
    versions_.resize(size);
  } else {
    free_.pop_back();
  }
  shape_[index] = shape;
  groups_[index] = options.group;
  masks_[index] = options.mask;
  poses_[index] = orthonormalized(options.pose);
  velocities_[index] = options.velocity;
  angular_velocities_[index] = options.angular_velocity;
  densities_[index] = options.density;
  is_static_[index] = options.is_static;
  alive_[index] = 1;
  ++versions_[index];
  ++comings_and_goings_;
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

void Scene::remove_body(BodyId id) {
  const std::uint32_t index = checked(id);
  alive_[index] = 0;
  ++versions_[index];
  ++comings_and_goings_;
  --count_;
  // A slot whose generations are used up is given away: an old id must never come true again.
  if (++generation_[index] != 0) free_.push_back(index);
}

void Scene::set_pose(BodyId id, const Pose& pose) {
  const std::uint32_t index = checked(id);
  require_valid(pose, body_name(index));
  poses_[index] = orthonormalized(pose);
  ++versions_[index];
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
