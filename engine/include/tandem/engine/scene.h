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

/// Names a body. Safe to keep: an id of a removed body is found out, it never names a newer one.
/// Zero-initialised means "no body".
struct BodyId {
  std::uint32_t slot_plus_one = 0;
  std::uint32_t generation = 0;
  std::uint32_t index() const { return slot_plus_one - 1; }  ///< as in contacts and pairs
  friend bool operator==(BodyId, BodyId) = default;
};

/// Names a shape of a scene, as BodyId a body.
struct ShapeId {
  std::uint32_t index_plus_one = 0;
  std::uint32_t generation = 0;
  friend bool operator==(ShapeId, ShapeId) = default;
};

struct BodyOptions {
  ShapeId shape{};
  Pose pose{};
  Vec3 velocity = Vec3::Zero();          ///< m/s, of the centre of mass, which need not be the shape's origin
  Vec3 angular_velocity = Vec3::Zero();  ///< rad/s, world axes
  double density = 1000;                 ///< kg/m^3, finite, > 0; not used when is_static
  /// Never moved by a response; two static bodies make no pair. One with a velocity carries along what lies on it: a
  /// conveyor, or a body that its owner moves by set_pose.
  bool is_static = false;
  bool is_sensor = false;                ///< its contacts are reported, and no response pushes by them
  bool continuous = false;               ///< does not pass through others however fast it is: continuous_motion.h
  std::uint32_t group = 1;               ///< bits of the groups this body is in
  std::uint32_t mask = 0xffffffffu;      ///< bits of the groups it meets; a pair needs both directions
};

/// Bytes that a scene holds; room that its lists have grown by counts.
struct SceneMemory {
  std::size_t bodies = 0;  ///< poses, velocities, densities, groups and the rest of each
  std::size_t shapes = 0;  ///< the list of shapes, and what is held beside them; what several have in common once
  std::size_t shape_names = 0;

  std::size_t total() const { return bodies + shapes + shape_names; }
};

namespace detail {
class SceneChanges;
}

/// Bodies and their shapes: what a pipeline looks at and a response moves. Plain data; arguments are checked on entry,
/// but where said. Not thread-safe while it is changed. A body's index stays the same until it is removed; freed
/// indices are used again.
class Scene {
 public:
  ShapeId add_shape(Shape shape, std::string name = {});
  /// Throws std::invalid_argument for an id that names no shape (any more) or one that a body has.
  void remove_shape(ShapeId id);
  /// Gives all bodies of this shape another one in its place, as set_shape does: one that has bent
  /// (DeformableMesh::shape), say. The next step and the next SceneQueries::update see it, and nothing that was kept
  /// for these bodies stands. Throws std::invalid_argument, and nothing has changed, for an id that names no shape and
  /// a half-space or plane for bodies that are not static.
  void replace_shape(ShapeId id, Shape shape);
  /// Throws std::invalid_argument that names the body, field and value: a bad pose or number, an unknown shape, or
  /// a half-space or plane that is not static. Two of these thus never meet: all other pairs of kinds have a solver.
  BodyId add_body(const BodyOptions& options);
  /// Throws std::invalid_argument for an id that names no body (any more); so do all calls that take an id.
  void remove_body(BodyId id);
  void set_pose(BodyId id, const Pose& pose);
  /// Sets the poses of many bodies; checked on the threads of the caller's oneTBB arena. Throws before any is changed.
  /// Both spans one length; of a body named twice the last pose counts.
  void set_poses(std::span<const BodyId> ids, std::span<const Pose> poses);
  /// Gives the body another shape, other groups, fixes or frees it: what holds of add_body holds of these, too.
  void set_shape(BodyId id, ShapeId shape);
  void set_filter(BodyId id, std::uint32_t group, std::uint32_t mask);
  void set_static(BodyId id, bool is_static);
  void set_continuous(BodyId id, bool continuous);
  void set_density(BodyId id, double density);
  void set_sensor(BodyId id, bool is_sensor);
  void reserve(std::size_t bodies);  ///< room for so many in all
  SceneMemory memory() const;
  /// m/s of the centre of mass; rad/s, world axes; finite, else std::invalid_argument.
  void set_velocity(BodyId id, const Vec3& velocity, const Vec3& angular_velocity);

  const Pose& pose(BodyId id) const;
  std::size_t bodies() const { return count_; }          ///< alive
  std::size_t indices() const { return poses_.size(); }  ///< one past the largest index ever used
  /// `index` < indices(), not checked.
  bool alive(std::uint32_t index) const { return alive_[index] != 0; }
  BodyId id(std::uint32_t index) const;  ///< throws std::invalid_argument unless a body is alive there
  ShapeId shape_id(BodyId id) const;
  bool has_kind(ShapeKind kind) const { return kinds_[static_cast<std::size_t>(kind)] != 0; }  ///< among its shapes

  /// In the order added; in the place of a removed shape stands a point, until another one takes it.
  std::span<const Shape> shapes() const { return shapes_; }
  /// `place` < shapes().size(), not checked.
  bool has_shape(std::uint32_t place) const { return shape_alive_[place] != 0; }
  std::string_view shape_name(std::uint32_t place) const;  ///< empty if it was given none
  /// The shape of the body at `index` < indices(), not checked.
  const Shape& shape_of(std::uint32_t index) const { return shapes_[shape_[index]]; }

  /// One element an index; those of removed bodies are stale.
  std::span<const std::uint32_t> shape_indices() const { return shape_; }
  std::span<const Pose> poses() const { return poses_; }
  std::span<const Vec3> velocities() const { return velocities_; }
  std::span<const Vec3> angular_velocities() const { return angular_velocities_; }
  std::span<const double> densities() const { return densities_; }
  std::span<const std::uint8_t> is_static() const { return is_static_; }
  std::span<const std::uint8_t> is_sensor() const { return is_sensor_; }
  std::span<const std::uint8_t> continuous() const { return continuous_; }
  bool has_continuous() const { return continuous_count_ != 0; }  ///< is any body?
  std::span<const std::uint32_t> groups() const { return groups_; }
  std::span<const std::uint32_t> masks() const { return masks_; }

  /// For an integrator, yours or Response: moves a body without the checks of set_pose; the rotation must be
  /// orthonormal, velocities finite, `index` < indices(). Several threads may move different bodies.
  void move(std::uint32_t index, const Pose& pose, const Vec3& velocity, const Vec3& angular_velocity);

  std::string name;
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, finite, else Response throws
  double dt = 1.0 / 60;       ///< s, of one step; finite, > 0, else Response throws
  Request request = Request::contacts;

 private:
  friend class detail::SceneChanges;

  /// Names the past of a scene: a copy has another one.
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
  std::vector<std::string> shape_names_;  // up to the last shape that was given one
  std::vector<std::uint32_t> shape_generation_, shape_users_, free_shapes_;
  std::vector<std::uint8_t> shape_alive_;
  std::array<std::size_t, shape_kinds> kinds_{};
  std::vector<std::uint32_t> shape_, generation_, groups_, masks_, free_;
  std::vector<Pose> poses_;
  std::vector<Vec3> velocities_, angular_velocities_;
  std::vector<double> densities_;
  std::vector<std::uint8_t> is_static_, is_sensor_, continuous_, alive_;
  std::size_t count_ = 0, continuous_count_ = 0;

  // For who looks at the scene step by step, see SceneChanges.
  std::vector<std::uint32_t> versions_;
  std::uint64_t comings_and_goings_ = 0, shape_changes_ = 0;
  History history_;
};

}  // namespace tandem
