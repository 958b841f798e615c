// The records that ranks send each other.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "pipeline/kept_contacts.h"
#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// A body's pose and velocities, as bytes: the content of the message for a copy whose body has moved.
struct MotionRecord {
  GlobalId id = 0;
  std::array<double, 9> rotation{};  // by columns
  std::array<double, 3> translation{}, velocity{}, angular_velocity{};

  static MotionRecord of(GlobalId id, const Scene& scene, std::uint32_t index) {
    return of(id, scene.poses()[index], scene.velocities()[index], scene.angular_velocities()[index]);
  }
  static MotionRecord of(GlobalId id, const Pose& pose, const Vec3& velocity, const Vec3& angular_velocity) {
    MotionRecord out;
    out.id = id;
    Eigen::Map<Mat3>(out.rotation.data()) = pose.rotation;
    Eigen::Map<Vec3>(out.translation.data()) = pose.translation;
    Eigen::Map<Vec3>(out.velocity.data()) = velocity;
    Eigen::Map<Vec3>(out.angular_velocity.data()) = angular_velocity;
    return out;
  }
  Pose pose() const { return {Eigen::Map<const Mat3>(rotation.data()), Eigen::Map<const Vec3>(translation.data())}; }
  Vec3 speed() const { return Eigen::Map<const Vec3>(velocity.data()); }
  Vec3 spin() const { return Eigen::Map<const Vec3>(angular_velocity.data()); }
};

/// All data of a body, as bytes. Its shape is given by its place among the shapes, which are the same on all ranks.
struct BodyRecord {
  MotionRecord motion;
  double density = 0;
  std::uint32_t shape = 0, group = 0, mask = 0;
  std::uint8_t is_static = 0, is_sensor = 0, is_continuous = 0;
  std::uint8_t unused = 0;  // padding: without it a byte, and so a checksum of records, would be indeterminate

  static BodyRecord of(GlobalId id, const Scene& scene, std::uint32_t index) {
    BodyRecord out;
    out.motion = MotionRecord::of(id, scene, index);
    out.density = scene.densities()[index];
    out.shape = scene.shape_indices()[index];
    out.group = scene.groups()[index];
    out.mask = scene.masks()[index];
    out.is_static = scene.is_static()[index];
    out.is_sensor = scene.is_sensor()[index];
    out.is_continuous = scene.continuous()[index];
    return out;
  }
  /// Adds the body to a scene, with exactly these bits: a pose that comes from a response must not be made orthonormal
  /// again. Returns its index.
  std::uint32_t add_to(Scene& scene, ShapeId its_shape) const {
    BodyOptions options;
    options.shape = its_shape;
    options.density = density;
    options.is_static = is_static != 0;
    options.is_sensor = is_sensor != 0;
    options.continuous = is_continuous != 0;
    options.group = group;
    options.mask = mask;
    const std::uint32_t index = scene.add_body(options).index();
    scene.move(index, motion.pose(), motion.speed(), motion.spin());
    return index;
  }
};

/// A change of a body that some rank requested.
struct Change {
  /// From `shape` on more than the pose changes: copies need all data of the body.
  enum class Kind : std::uint32_t {
    add,
    remove,
    pose,
    velocity,
    shape,
    filter,
    is_static,
    density,
    is_sensor,
    continuous
  };
  Kind kind = Kind::add;
  std::uint32_t unused = 0;
  BodyRecord body;  ///< its id, and the data of the kind of change

  GlobalId id() const { return body.motion.id; }
};

struct AnswerRecord {
  double signed_distance = 0, error_bound = 0;
  std::array<double, 3> point_a{}, point_b{}, normal{};
  std::uint32_t status = 0;
  std::uint8_t collide = 0, farther = 0;
  std::uint16_t unused = 0;

  static AnswerRecord of(const PairAnswer& answer) {
    AnswerRecord out;
    out.signed_distance = answer.signed_distance;
    out.error_bound = answer.error_bound;
    Eigen::Map<Vec3>(out.point_a.data()) = answer.point_a;
    Eigen::Map<Vec3>(out.point_b.data()) = answer.point_b;
    Eigen::Map<Vec3>(out.normal.data()) = answer.normal;
    out.status = static_cast<std::uint32_t>(answer.status);
    out.collide = answer.collide ? 1 : 0;
    out.farther = answer.farther ? 1 : 0;
    return out;
  }
  PairAnswer answer() const {
    PairAnswer out;
    out.signed_distance = signed_distance;
    out.error_bound = error_bound;
    out.point_a = Eigen::Map<const Vec3>(point_a.data());
    out.point_b = Eigen::Map<const Vec3>(point_b.data());
    out.normal = Eigen::Map<const Vec3>(normal.data());
    out.status = static_cast<Status>(status);
    out.collide = collide != 0;
    out.farther = farther != 0;
    return out;
  }
};

struct ContactRecord {
  std::array<double, 3> point{}, normal{};
  double depth = 0;
  std::uint64_t feature = 0;

  static ContactRecord of(const Contact& contact) {
    ContactRecord out;
    Eigen::Map<Vec3>(out.point.data()) = contact.point;
    Eigen::Map<Vec3>(out.normal.data()) = contact.normal;
    out.depth = contact.depth;
    out.feature = contact.feature;
    return out;
  }
  Contact contact() const {
    return {Eigen::Map<const Vec3>(point.data()), Eigen::Map<const Vec3>(normal.data()), depth,
            static_cast<std::uint32_t>(feature)};
  }
};

/// An optional KeptRest, as bytes.
struct RestRecord {
  std::array<double, 9> rotation{};  // by columns
  std::array<double, 3> translation{};
  double reach = 0;
  std::uint32_t steps = 0;
  std::uint16_t is_known = 0, has_shape = 0;

  static RestRecord of(const std::optional<KeptRest>& rest) {
    RestRecord out;
    if (!rest) return out;
    Eigen::Map<Mat3>(out.rotation.data()) = rest->anchor.rotation;
    Eigen::Map<Vec3>(out.translation.data()) = rest->anchor.translation;
    out.reach = rest->reach;
    out.steps = rest->steps;
    out.is_known = 1;
    out.has_shape = rest->has_shape ? 1 : 0;
    return out;
  }
  std::optional<KeptRest> rest() const {
    if (is_known == 0) return {};
    return KeptRest{{Eigen::Map<const Mat3>(rotation.data()), Eigen::Map<const Vec3>(translation.data())},
                    reach,
                    steps,
                    has_shape != 0};
  }
};

/// A KeptPair without its contacts, as bytes.
struct KeptPairRecord {
  std::array<double, 9> rotation{};  // by columns
  std::array<double, 3> translation{};
  AnswerRecord answer;

  static KeptPairRecord of(const KeptPair& kept) {
    KeptPairRecord out;
    Eigen::Map<Mat3>(out.rotation.data()) = kept.rotation;
    Eigen::Map<Vec3>(out.translation.data()) = kept.translation;
    out.answer = AnswerRecord::of(kept.answer);
    return out;
  }
  KeptPair kept() const {
    KeptPair out;
    out.rotation = Eigen::Map<const Mat3>(rotation.data());
    out.translation = Eigen::Map<const Vec3>(translation.data());
    out.answer = answer.answer();
    return out;
  }
};

/// The items of a message of the exchange: each is one of these numbers, then the listed data.
enum class Item : std::uint8_t {
  body,   ///< BodyRecord, with RestRecord where answers are kept, as in `owned`: a copy, or one that takes the place of
          ///< the copy that is there
  owned,  ///< BodyRecord, RestRecord, the number of copies (std::uint32_t), their ranks (int): from now on the
          ///< receiver's
  moved,  ///< MotionRecord: a copy's body has moved
  owner,  ///< GlobalId, rank (int): the new owner of a copy's body, which reports it from now on
  gone,   ///< GlobalId: the copy is no longer needed
  left,   ///< BodyRecord: the same where answers are kept; pairs of the body continue on other ranks
  change,  ///< Change: a change of a body that the receiver owns
};

/// The items of a message of the response: each is one of these numbers, then the listed data.
enum class ResponseItem : std::uint8_t {
  moved,   ///< MotionRecord: a copy's body, moved by the host after the step
  use,     ///< GlobalId, IdPair: a body that the receiver owns, moved by a pair that the sender reports
  order,   ///< GlobalId, a number (std::uint32_t), so many ranks (int): those that report the body's pairs, in the
           ///< order of the pairs' ids
  left,    ///< IdPair, impulses: a pair that the sender solved in the step before and no longer reports
  wanted,  ///< IdPair: a pair that the sender solves and did not solve before
  kept,    ///< IdPair, impulses: the answer to `wanted`
};

}  // namespace tandem::mpi
