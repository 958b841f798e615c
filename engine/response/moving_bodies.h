// The bodies of a scene on their way through a step, as ContinuousMotion sees them.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "scene/scene_changes.h"
#include "tandem/engine/continuous_motion.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// Where a body goes from a time of the step to its end.
struct Leg {
  double begin = 0;  ///< [0, 1]
  Motion motion;     ///< of all that is left of the step
  /// Not stopped yet: goes where it was to go.
  bool free = true;
  /// Metres the body goes in a step that took it along; its own length if none did and it is not continuous.
  double speed = 0;

  Pose at(double t) const;
  Motion from(double t) const { return {at(t), motion.to, motion.straight_of}; }
};

/// A ball inside a shape.
struct InnerBall {
  Vec3 centre = Vec3::Zero();
  double radius = 0;  ///< 0: none
};

/// Metres: the most that a point of a body goes in the step, and of one of the others.
struct FastestTwo {
  double first = 0, second = 0;

  void add(double length) {
    second = std::max(second, std::min(length, first));
    first = std::max(first, length);
  }
  double of_others(double length) const { return length == first ? second : first; }
};

class MovingBodies {
 public:
  explicit MovingBodies(PairPredicate predicate) : predicate_(std::move(predicate)) {}

  /// Takes over the scene and the ends, which must outlive the step. `own`: one an index, not 0: takes part; empty: all
  /// do.
  void begin(const Scene& scene, std::span<const Pose> ends, std::span<const std::uint8_t> own = {});
  /// Of those that take part.
  FastestTwo fastest() const;
  /// Finds the bodies to be watched, where `of_all` are the fastest ones, also of those that are not here; false: none.
  bool watch(const FastestTwo& of_all);

  /// Continuous bodies that may meet something, ascending.
  std::span<const std::uint32_t> watched() const { return watched_; }
  bool is_watched(std::uint32_t body) const { return place_[body] != none; }
  Leg& leg_of(std::uint32_t watched_body) { return legs_[place_[watched_body]]; }
  Leg leg(std::uint32_t body) const;
  const Scene& scene() const { return *scene_; }
  /// Alive, no sensor, and here.
  bool takes_part(std::uint32_t body) const { return takes_part_[body] != 0; }
  /// Whether the pair need be looked at from t on: it is allowed, at least one of the two would be stopped or taken
  /// along, and they move enough.
  bool may_meet(std::uint32_t a, std::uint32_t b, double t) const;

  /// The first touch of the two from t on, in time of the step; a < b.
  std::optional<FirstTouch> meet(std::uint32_t a, std::uint32_t b, double t) const;

 private:
  static constexpr std::uint32_t none = 0xffffffffu;

  void learn_shapes();
  void measure(std::uint32_t body);
  Motion whole(std::uint32_t body) const;
  bool allows(std::uint32_t a, std::uint32_t b) const;
  /// Metres: pairs that move less together are not looked at.
  double not_fast(std::uint32_t body) const;
  double not_fast(std::uint32_t a, std::uint32_t b) const;
  /// The most that points of the two may go from t on, metres.
  double left(std::uint32_t a, std::uint32_t b, double t) const;
  std::optional<FirstTouch> whole_meet(std::uint32_t a, std::uint32_t b, double t, bool& touching) const;
  /// Of the core of a with b, which touch as a whole at t, and do `soon`.
  std::optional<FirstTouch> core_meets(std::uint32_t a, std::uint32_t b, double t, double soon) const;
  std::optional<FirstTouch> cores_meet(std::uint32_t a, std::uint32_t b, double t, double soon) const;

  const PairPredicate predicate_;
  NarrowPhase narrow_;
  const Scene* scene_ = nullptr;
  std::span<const Pose> ends_;
  SceneChanges::HistoryName history_;
  std::uint64_t shape_changes_ = 0;
  std::vector<InnerBall> balls_;        // one a shape that a continuous body has
  std::vector<std::uint8_t> has_ball_;  // known
  std::vector<double> reach_;           // one a shape
  std::vector<double> length_;          // one a body: the most that a point of it goes in the step
  std::vector<std::uint8_t> takes_part_;
  std::vector<std::uint32_t> watched_, place_;  // one a body: its place in legs_
  std::vector<Leg> legs_;
};

}  // namespace tandem
