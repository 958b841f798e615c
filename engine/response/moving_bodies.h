// The motions of a scene's bodies in a step, for ContinuousMotion.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "response/inner_ball.h"
#include "scene/scene_changes.h"
#include "tandem/engine/continuous_motion.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// The motion of a body from a time of the step to its end.
struct Leg {
  double begin = 0;  ///< start time, [0, 1]
  Motion motion;     ///< over the remaining step
  /// True until the body is stopped: it follows its given motion, or what held off cores have left of it.
  bool free = true;
  /// Metres that the carrying body moves in the step; the body's own length if none carries it and it is not
  /// continuous.
  double speed = 0;

  Pose at(double t) const;
  Motion from(double t) const { return {at(t), motion.to, motion.straight_of}; }
};

/// Metres: the largest motion of a point in the step over all bodies, and that over all others than this fastest body.
struct FastestTwo {
  double first = 0, second = 0;

  void add(double length) {
    second = std::max(second, std::min(length, first));
    first = std::max(first, length);
  }
  double of_others(double length) const { return length == first ? second : first; }
};

/// A contact of two bodies in a step, in its time.
struct BodiesTouch : FirstTouch {
  static constexpr std::uint32_t none = 0xffffffffu;
  std::uint32_t core = none;  ///< the body whose core touches the other one; none: the surfaces touch
};

class MovingBodies {
 public:
  explicit MovingBodies(PairPredicate predicate) : predicate_(std::move(predicate)) {}

  /// Takes the scene and the end poses, which must outlive the step. `own`: one an index, not 0: the body takes part;
  /// empty: all do.
  void begin(const Scene& scene, std::span<const Pose> ends, std::span<const std::uint8_t> own = {});
  /// The two fastest bodies of those that take part.
  FastestTwo fastest() const;
  /// Chooses the watched bodies, given the fastest of all bodies, also on other ranks; false: there are none.
  bool watch(const FastestTwo& of_all);

  /// The continuous bodies that may hit something, ascending.
  std::span<const std::uint32_t> watched() const { return watched_; }
  bool is_watched(std::uint32_t body) const { return place_[body] != none; }
  Leg& leg_of(std::uint32_t watched_body) { return legs_[place_[watched_body]]; }
  Leg leg(std::uint32_t body) const;
  const Scene& scene() const { return *scene_; }
  /// The inner ball of a continuous body's shape; of a static or another body none.
  InnerBall ball_of(const Scene& scene, std::uint32_t body) const;
  /// True for a living body, not a sensor, that takes part here.
  bool takes_part(std::uint32_t body) const { return takes_part_[body] != 0; }
  /// True if the pair must be examined from t on: it is allowed, at least one of the two would be stopped or carried,
  /// and they move enough.
  bool may_meet(std::uint32_t a, std::uint32_t b, double t) const;

  /// The first contact of the two from t on, in time of the step; a < b.
  std::optional<BodiesTouch> meet(std::uint32_t a, std::uint32_t b, double t) const;

 private:
  static constexpr std::uint32_t none = 0xffffffffu;

  void learn_shapes();
  void measure(std::uint32_t body);
  Motion whole(std::uint32_t body) const;
  bool allows(std::uint32_t a, std::uint32_t b) const;
  /// Metres: a body that moves less cannot pass through anything in a step.
  double short_motion(std::uint32_t body) const;
  double short_motion(std::uint32_t a, std::uint32_t b) const;
  /// Pairs that move less together are not examined, with this short motion. 0 if gravity moves a body at rest farther
  /// in a step: contacts that yield would let it through in many steps, each of them short.
  double least_fast_motion(double length) const;
  /// The largest relative motion of points of the two from t on, metres.
  double left(std::uint32_t a, std::uint32_t b, double t) const;
  std::optional<BodiesTouch> whole_meet(std::uint32_t a, std::uint32_t b, double t, bool& touching) const;
  /// The first contact of the core of a with b, for bodies that touch at t, and that would touch at `soon`. A core that
  /// touches b at t is replaced by a smaller one that does not.
  std::optional<BodiesTouch> core_meets(std::uint32_t a, std::uint32_t b, double t, double soon) const;
  std::optional<BodiesTouch> cores_meet(std::uint32_t a, std::uint32_t b, double t, double soon) const;

  const PairPredicate predicate_;
  NarrowPhase narrow_;
  const Scene* scene_ = nullptr;
  std::span<const Pose> ends_;
  SceneChanges::ShapesName known_shapes_;
  std::vector<InnerBall> balls_;        // one for each shape of a continuous body
  std::vector<std::uint8_t> has_ball_;  // balls_ of the shape is known
  std::vector<double> reach_;           // one for each shape
  std::vector<double> length_;          // one a body: the largest motion of a point of it in the step
  std::vector<std::uint8_t> takes_part_;
  std::vector<std::uint32_t> watched_, place_;  // one a body: its place in legs_
  std::vector<Leg> legs_;
};

}  // namespace tandem
