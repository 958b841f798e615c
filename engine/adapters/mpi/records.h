#pragma once
#include <array>
#include <cstdint>

#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// Where a body is and how it moves, as bytes: what a copy needs to be told of a body that has moved.
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

/// All of a body, as bytes. Its shape is told by its place among the shapes, which are the same on all ranks.
struct BodyRecord {
  MotionRecord motion;
  double density = 0;
  std::uint32_t shape = 0, group = 0, mask = 0;
  std::uint8_t is_static = 0, is_sensor = 0;
  std::uint16_t unused = 0;  // without it two bytes were of no value, and a checksum of records too

  static BodyRecord of(GlobalId id, const Scene& scene, std::uint32_t index) {
    BodyRecord out;
    out.motion = MotionRecord::of(id, scene, index);
    out.density = scene.densities()[index];
    out.shape = scene.shape_indices()[index];
    out.group = scene.groups()[index];
    out.mask = scene.masks()[index];
    out.is_static = scene.is_static()[index];
    out.is_sensor = scene.is_sensor()[index];
    return out;
  }
};

/// A change of a body that some rank asked for.
struct Change {
  enum class Kind : std::uint32_t { add, remove, pose, velocity, shape, filter, is_static };
  Kind kind = Kind::add;
  std::uint32_t unused = 0;
  BodyRecord body;  ///< its id, and what the kind says

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

/// What a letter of the exchange holds, item after item: one of these, then what it says.
enum class Item : std::uint8_t {
  body,    ///< BodyRecord: a copy, or one that takes the place of the copy that is there
  owned,   ///< BodyRecord, the number of copies (std::uint32_t), their ranks (int): from now on the receiver's
  moved,   ///< MotionRecord
  owner,   ///< GlobalId, rank (int): of a copy, told of by that rank from now on
  gone,    ///< GlobalId: the copy is no longer needed
  change,  ///< Change: of a body that the receiver owns
};

/// What a letter of the response holds, item after item: one of these, then what it says.
enum class ResponseItem : std::uint8_t {
  moved,   ///< MotionRecord: of a copy, by a host's hand after the step
  use,     ///< GlobalId, IdPair: of a body that the receiver owns, moved by a pair that the sender reports
  order,   ///< GlobalId, a number (std::uint32_t), so many ranks (int): of a used body's pairs, in the order of their
           ///< ids
  left,    ///< IdPair, impulses: of a pair that the sender solved in the step before and no longer reports
  wanted,  ///< IdPair: which the sender solves and did not before
  kept,    ///< IdPair, impulses: an answer to it
};

}  // namespace tandem::mpi
