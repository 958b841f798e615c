// Continuous collision detection for fast bodies: their motions are ended at the first contact.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "tandem/broadphase/pair.h"
#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// A pair is examined if the sum of its two motions in a step exceeds this fraction of the inner radius of the
/// continuous body (of two the smaller): a body that moves less cannot pass through anything, since the next step finds
/// it overlapping. The inner radius is that of an inscribed ball: about the centre of mass, or, for a closed mesh, the
/// largest one found. Triangles and open meshes have none: a hundredth of their size replaces this fraction. Where
/// gravity moves a body at rest farther in a step than that, as at 60 Hz on Earth with inner radii below 11 mm, every
/// pair that moves is examined, at several times the cost: contacts that yield would let it through in many short
/// steps.
inline constexpr double fast_motion = 0.25;

/// A continuous body that was stopped during its motion, or whose core was held off.
struct MotionStop {
  double t = 0;  ///< of the step, [0, 1]
  BodyId a, b;   ///< index of a < index of b; at least one is continuous
  /// At that time; as in PairAnswer: midway, unit, from a to b, world.
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
};

/// The poses of all bodies after dt by their velocities alone, static ones included: one an index.
/// Throws std::invalid_argument if such a pose is not valid, for example because the body is farther from the origin
/// than poses may be.
void free_ends(const Scene& scene, std::vector<Pose>& ends);

/// Keeps continuous bodies (BodyOptions::continuous) from passing through others within a step, however fast they are:
/// for a host that moves bodies itself; Response does it by itself.
///
/// A step is seen as a motion of each body: its centre of mass (a static body's origin) moves on a straight line at
/// constant speed, while the body rotates about it by at most half a turn. Guarantees:
/// - A continuous body enters no body from which it is separated at the start of the step by more than the gap that
///   NarrowPhase::time_of_impact counts as a touch. It moves up to the first touch, and from then on with the body that
///   it touches: it stops at one at rest, and a moving one carries it. Two continuous bodies that meet both stop. If
///   two bodies close in on it from two sides, the faster one carries it, and it may enter the other one.
/// - The same holds for a pair that touches at the start, and is separated after a motion of fast_motion of the inner
///   radius. If it still touches then, as a body that slides along a floor, contacts have to keep the two apart, which
///   is not certain; but the core, the inner ball with half its radius, enters no body from which it is separated, and
///   gets no deeper into one that it touches: its approach is taken from the motion, and the body slides and turns on.
///   The same holds for touching pairs of which one body is carried.
/// - Pairs whose motions are together shorter than that are not examined: they end at most that deep in each other.
///
/// Sensors stop nothing and are not stopped. Static bodies are assumed to move by their velocity. The rest of a stopped
/// body's motion is lost; its velocity stays, for the contacts of the next step to change.
///
/// Cost: scenes without continuous bodies none; where none is fast a pass over the bodies. The answer is the same bits
/// on any number of threads.
class ContinuousMotion {
 public:
  /// `predicate`: drops pairs, as PipelineOptions::predicate; called with one pair at a time from any thread.
  explicit ContinuousMotion(PairPredicate predicate = {});
  ~ContinuousMotion();
  ContinuousMotion(ContinuousMotion&&) noexcept;
  ContinuousMotion& operator=(ContinuousMotion&&) noexcept;

  /// `ends`: the pose of each body at the end of the step, one an index; the scene is in its state at the start. Those
  /// of continuous bodies are moved back as far as needed. Returns the stops, sorted by (t, a, b); valid until the next
  /// call. Throws std::invalid_argument that names the body whose end is no valid pose, or for a wrong number of ends.
  std::span<const MotionStop> limit(const Scene& scene, std::span<Pose> ends);

  /// Adds to a step's contacts, for each pair that was stopped in the last call and still exists: if it has no contact
  /// in the list, that at their nearest points, with negative depth; and that of an inner ball which overlaps the other
  /// body, as its core may be what stopped the motion. So a response removes the approach of stopped bodies whatever
  /// the margin of detection, between meshes, too.
  void add_contacts(const Scene& scene, ContactList& contacts) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
