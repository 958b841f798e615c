// Scenes: bodies with shapes, poses and velocities, which a pipeline reads and a response moves.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Identifies a body. Safe to keep: the id of a removed body is recognised, and never identifies a newer body.
/// Zero-initialised: "no body".
struct BodyId {
  std::uint32_t slot_plus_one = 0;
  std::uint32_t generation = 0;
  std::uint32_t index() const { return slot_plus_one - 1; }  ///< the index in contacts and pairs
  friend bool operator==(BodyId, BodyId) = default;
};

/// Identifies a shape of a scene, as BodyId identifies a body.
struct ShapeId {
  std::uint32_t index_plus_one = 0;
  std::uint32_t generation = 0;
  friend bool operator==(ShapeId, ShapeId) = default;
};

struct BodyOptions {
  ShapeId shape{};
  Pose pose{};
  Vec3 velocity = Vec3::Zero();          ///< m/s, of the centre of mass, which may differ from the shape's origin
  Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, world axes
  double density = 1000;                 ///< kg/m^3, finite, > 0; ignored if is_static
  /// Never moved by a response; two static bodies form no pair. A static body with a velocity drags bodies that touch
  /// it: a conveyor, or a body that its owner moves by set_pose.
  bool is_static = false;
  bool is_sensor = false;            ///< its contacts are reported but have no response
  bool continuous = false;           ///< does not pass through others at any speed: continuous_motion.h
  std::uint32_t group = 1;           ///< bits of the groups to which this body belongs
  std::uint32_t mask = 0xffffffffu;  ///< bits of the groups with which it collides; a pair needs both directions
};

/// Bytes that a scene holds, including the spare capacity of its lists.
struct SceneMemory {
  std::size_t bodies = 0;  ///< poses, velocities, densities, groups and other data of each
  std::size_t shapes = 0;  ///< the list of shapes and the data of shapes; shared data counts once
  std::size_t shape_names = 0;

  std::size_t total() const { return bodies + shapes + shape_names; }
};

namespace detail {
class SceneChanges;
}

/// Bodies and their shapes, the input of a pipeline; a response moves the bodies. Plain data; arguments are validated
/// on entry unless noted. Not thread-safe while it is changed. A body keeps its index until it is removed; free indices
/// are reused.
class Scene {
 public:
  ShapeId add_shape(Shape shape, std::string name = {});
  /// Throws std::invalid_argument for an id without a shape, and for a shape that a body has.
  void remove_shape(ShapeId id);
  /// Replaces a shape by another one in all bodies that have it, as set_shape does, for example after a deformation
  /// (DeformableMesh::shape). The next step and the next SceneQueries::update use it, and discard answers kept for
  /// these bodies. Throws std::invalid_argument, without changes, for an id without a shape, and for a half-space or
  /// plane for bodies that are not static.
  void replace_shape(ShapeId id, Shape shape);
  /// Throws std::invalid_argument that names the body, field and value: an invalid pose or number, an unknown shape, or
  /// a half-space or plane that is not static. So two of these never form a pair; all other pairs of kinds have a
  /// solver.
  BodyId add_body(const BodyOptions& options);
  /// Throws std::invalid_argument for an id without a body, as do all calls that take an id.
  void remove_body(BodyId id);
  void set_pose(BodyId id, const Pose& pose);
  /// Sets the poses of many bodies; they are validated on the threads of the caller's oneTBB arena. Throws before any
  /// is changed. Both spans have one length; the last pose of a repeated body counts.
  void set_poses(std::span<const BodyId> ids, std::span<const Pose> poses);
  /// Changes the body's shape, groups or static flag; the conditions of add_body apply.
  void set_shape(BodyId id, ShapeId shape);
  void set_filter(BodyId id, std::uint32_t group, std::uint32_t mask);
  void set_static(BodyId id, bool is_static);
  void set_continuous(BodyId id, bool continuous);
  void set_density(BodyId id, double density);
  void set_sensor(BodyId id, bool is_sensor);
  void reserve(std::size_t bodies, std::size_t shapes = 0);  ///< room for so many in all
  SceneMemory memory() const;
  /// m/s of the centre of mass; rad/s, world axes; finite, else std::invalid_argument.
  void set_velocity(BodyId id, const Vec3& velocity, const Vec3& angular_velocity);

  const Pose& pose(BodyId id) const;
  std::size_t bodies() const { return count_; }          ///< number of bodies
  std::size_t indices() const { return poses_.size(); }  ///< one past the largest index ever used
  /// `index` < indices(), not checked.
  bool alive(std::uint32_t index) const { return alive_[index] != 0; }
  BodyId id(std::uint32_t index) const;  ///< throws std::invalid_argument unless a body is alive there
  ShapeId shape_id(BodyId id) const;
  bool has_kind(ShapeKind kind) const { return kinds_[static_cast<std::size_t>(kind)] != 0; }  ///< among its shapes

  /// In the order of addition; a removed shape is replaced by a point until its place is reused.
  std::span<const Shape> shapes() const { return shapes_; }
  /// `place` < shapes().size(), not checked.
  bool has_shape(std::uint32_t place) const { return shape_alive_[place] != 0; }
  std::string_view shape_name(std::uint32_t place) const;  ///< empty if it has no name
  /// The shape of the body at `index` < indices(), not checked.
  const Shape& shape_of(std::uint32_t index) const { return shapes_[shape_[index]]; }

  /// One element per index; those of removed bodies are stale.
  std::span<const std::uint32_t> shape_indices() const { return shape_; }
  std::span<const Pose> poses() const { return poses_; }
  std::span<const Vec3> velocities() const { return velocities_; }
  std::span<const Vec3> angular_velocities() const { return angular_velocities_; }
  std::span<const double> densities() const { return densities_; }
  std::span<const std::uint8_t> is_static() const { return is_static_; }
  std::span<const std::uint8_t> is_sensor() const { return is_sensor_; }
  std::span<const std::uint8_t> continuous() const { return continuous_; }
  bool has_continuous() const { return continuous_count_ != 0; }  ///< whether any body is continuous
  std::span<const std::uint32_t> groups() const { return groups_; }
  std::span<const std::uint32_t> masks() const { return masks_; }

  /// For an integrator (a host's, or Response): moves a body without the checks of set_pose; the rotation must be
  /// orthonormal, velocities finite, `index` < indices(). Several threads may move different bodies.
  void move(std::uint32_t index, const Pose& pose, const Vec3& velocity, const Vec3& angular_velocity);

  std::string name;
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, at most 1e30 each, else Response throws
  double dt = 1.0 / 60;       ///< s, of one step; finite, > 0, else Response throws
  Request request = Request::contacts;

 private:
  friend class detail::SceneChanges;

  /// Identifies the history of a scene: a copy has another one.
  class History {
   public:
    History();
    History(const History&);
    History& operator=(const History&);
    History(History&&) noexcept = default;
    History& operator=(History&&) noexcept = default;
    ~History() = default;
    const std::shared_ptr<const char>& mark() const { return mark_; }

   private:
    std::shared_ptr<const char> mark_;
  };

  std::uint32_t checked(BodyId id) const;
  std::uint32_t checked(ShapeId id, std::string_view what) const;
  void set_name(std::size_t place, std::string shape_name);
  void require_may_move(std::uint32_t index, const Shape& shape, double density) const;
  void changed(std::uint32_t index);

  std::vector<Shape> shapes_;
  std::vector<std::string> shape_names_;  // up to the last shape with a name
  std::vector<std::uint32_t> shape_generation_, shape_users_, free_shapes_;
  std::vector<std::uint8_t> shape_alive_;
  std::array<std::size_t, shape_kinds> kinds_{};
  std::vector<std::uint32_t> shape_, generation_, groups_, masks_, free_;
  std::vector<Pose> poses_;
  std::vector<Vec3> velocities_, angular_velocities_;
  std::vector<double> densities_;
  std::vector<std::uint8_t> is_static_, is_sensor_, continuous_, alive_;
  std::size_t count_ = 0, continuous_count_ = 0;

  // For step-by-step observers of the scene, see SceneChanges.
  std::vector<std::uint32_t> versions_;
  std::uint64_t comings_and_goings_ = 0, shape_changes_ = 0;
  History history_;
};

}  // namespace tandem
