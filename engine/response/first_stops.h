// Continuous bodies are stopped where they first touch something: all touches of a step in the order of time, as
// stopping one body changes what the others meet. After Mirtich, Impulse-based dynamic simulation of rigid body
// systems, 1996 (the heap of first touches), with motions that end in place of velocities that change.
#pragma once
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "response/moving_bodies.h"
#include "tandem/broadphase/box_queries.h"
#include "tandem/engine/continuous_motion.h"

namespace tandem {

/// What ContinuousMotion does in a step, in pieces: for whoever has but a share of all bodies.
///
/// Bodies that no box in which a watched one looks for others meets make no difference: they may be left out. At first
/// that is where it goes by itself, around(); where it was stopped or taken along, strays().
class FirstStops {
 public:
  explicit FirstStops(PairPredicate predicate) : bodies_(std::move(predicate)) {}

  /// As MovingBodies has them; the fastest of those that take part.
  FastestTwo begin(const Scene& scene, std::span<const Pose> ends, std::span<const std::uint8_t> own = {});
  /// Which bodies are watched; false: none.
  bool watch(const FastestTwo& of_all) { return bodies_.watch(of_all); }
  /// Where each body goes.
  void sweep();
  std::span<const std::uint32_t> watched() const { return bodies_.watched(); }
  bool takes_part(std::uint32_t body) const { return bodies_.takes_part(body); }
  /// Holds what a body that takes part goes through in the step, if nothing stops it. After sweep().
  const Aabb& around(std::uint32_t body) const { return around_[body]; }

  /// Stops the watched bodies. After sweep().
  void find();
  std::span<const MotionStop> stops() const { return stops_; }
  void clear() { stops_.clear(); }
  /// Where a watched body ends; its own end if it was not stopped.
  Pose end(std::uint32_t watched_body) const { return bodies_.leg(watched_body).motion.to; }
  bool is_stopped(std::uint32_t watched_body) const { return !bodies_.leg(watched_body).free; }
  struct Stray {
    std::uint32_t body = 0;
    Aabb box;
  };
  /// Where bodies that were stopped or taken along looked for others, as far as that is not within their around().
  std::span<const Stray> strays() const { return strays_; }

 private:
  /// A touch that is to come, unless one of the two is stopped before.
  struct Meeting {
    double t = 0;
    std::uint32_t a = 0, b = 0;
    std::uint32_t changes_a = 0, changes_b = 0;
    Vec3 point, normal;
    bool operator>(const Meeting& other) const { return std::tie(t, a, b) > std::tie(other.t, other.a, other.b); }
  };

  void look_around();
  template <class Visit>
  void each_near(const Aabb& box, bool anywhere, Visit&& visit);
  void look_for(std::uint32_t body, double t, std::vector<Meeting>& found);
  void note_stray(std::uint32_t body);
  void apply(const Meeting& meeting);
  void stand(std::uint32_t body, double t);
  void go_with(std::uint32_t body, std::uint32_t other, double t);
  void change(std::uint32_t body, const Leg& leg);

  MovingBodies bodies_;
  std::vector<Aabb> around_;            // one a body: holds what it goes through in the step
  std::vector<std::uint32_t> nearby_;   // bodies near a watched one
  std::vector<std::uint32_t> changes_;  // one a body: how often its leg changed
  std::vector<std::uint32_t> changed_;  // bodies whose leg did in the meeting at hand
  std::vector<std::uint32_t> strayed_;  // those that were taken along: they may be anywhere
  std::vector<Stray> strays_;
  BoxArray boxes_;  // of `nearby_`
  BoxQueries tree_;
  std::vector<MotionStop> stops_;
  std::vector<std::vector<Meeting>> found_;  // one a watched body
};

/// Appends to a list's contacts the one of two bodies at their nearest points, as a gap; returns the pair, which is not
/// in the list yet.
PairResult pair_at_nearest_points(const Scene& scene, std::uint32_t a, std::uint32_t b, ContactList& contacts);

}  // namespace tandem
