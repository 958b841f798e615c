// Stops continuous bodies at their first contact: all contacts of a step in the order of time, since stopping one body
// changes the contacts of others. After Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996 (the heap
// of first contacts), with motions that end instead of velocities that change.
#pragma once
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "response/moving_bodies.h"
#include "tandem/broadphase/box_queries.h"
#include "tandem/engine/continuous_motion.h"

namespace tandem {

/// The parts of ContinuousMotion's work in a step, for callers with a share of all bodies, such as a rank.
///
/// Only bodies that overlap the search box of a watched body matter; others may be left out. The search box is first
/// that of the body's own motion, around(); after it was stopped or carried along, also strays().
class FirstStops {
 public:
  explicit FirstStops(PairPredicate predicate) : bodies_(std::move(predicate)) {}

  /// Begins a step, as MovingBodies; returns the fastest of the bodies that take part.
  FastestTwo begin(const Scene& scene, std::span<const Pose> ends, std::span<const std::uint8_t> own = {});
  /// Chooses the watched bodies; false: there are none.
  bool watch(const FastestTwo& of_all) { return bodies_.watch(of_all); }
  /// Computes the boxes of all motions.
  void sweep();
  std::span<const std::uint32_t> watched() const { return bodies_.watched(); }
  bool takes_part(std::uint32_t body) const { return bodies_.takes_part(body); }
  /// A box that contains all positions of a body in the step, if nothing stops it. After sweep().
  const Aabb& around(std::uint32_t body) const { return around_[body]; }

  /// Stops the watched bodies. After sweep().
  void find();
  std::span<const MotionStop> stops() const { return stops_; }
  void clear() { stops_.clear(); }
  /// The end pose of a watched body; its given end if it was not stopped.
  Pose end(std::uint32_t watched_body) const { return bodies_.leg(watched_body).motion.to; }
  /// True if its motion was ended or changed.
  bool is_stopped(std::uint32_t watched_body) const { return changes_[watched_body] != 0; }
  struct Stray {
    std::uint32_t body = 0;
    Aabb box;
  };
  /// Appends to a list's contacts those of two bodies that were stopped by each other in the step before, and returns
  /// the pair: `known`, their contacts in this step, or null; without any, the contact at their nearest points, with
  /// negative depth. To these are added the contacts of inner balls that overlap the other body.
  PairResult contacts_of_stop(const Scene& scene, std::uint32_t a, std::uint32_t b, const PairResult* known,
                              ContactList& contacts) const;
  /// The boxes that stopped or carried bodies searched, as far as these exceed their around().
  std::span<const Stray> strays() const { return strays_; }

 private:
  /// A future contact, valid unless one of the two bodies is stopped before.
  struct Meeting {
    double t = 0;
    std::uint32_t a = 0, b = 0;
    std::uint32_t changes_a = 0, changes_b = 0;
    Vec3 point, normal;
    std::uint32_t core = BodiesTouch::none;
    bool operator>(const Meeting& other) const { return std::tie(t, a, b) > std::tie(other.t, other.a, other.b); }
  };

  void build_hierarchy_near_watched();
  template <class Visit>
  void each_near(const Aabb& box, bool anywhere, Visit&& visit);
  void find_impacts(std::uint32_t body, double t, std::vector<Meeting>& found);
  void apply(const Meeting& meeting);
  bool hold_off(const Meeting& meeting);
  void rest_at(std::uint32_t body, double t);
  Motion carried_by(std::uint32_t other, const Leg& leg, double t) const;
  void follow(std::uint32_t body, std::uint32_t other, double t);
  void change(std::uint32_t body, const Leg& leg);

  MovingBodies bodies_;
  std::vector<Aabb> around_;            // one a body: contains its motion in the step
  std::vector<std::uint32_t> nearby_;   // bodies near a watched one
  std::vector<std::uint32_t> changes_;  // one a body: how often its leg changed
  std::vector<std::uint8_t> held_off_;  // one a body: how often its core was held off
  std::vector<std::uint32_t> changed_;  // bodies whose leg changed in the present contact
  std::vector<std::uint32_t> strayed_;  // bodies that were carried along: they may be anywhere
  std::vector<Stray> strays_;
  BoxArray boxes_;  // of `nearby_`
  BoxQueries tree_;
  std::vector<MotionStop> stops_;
  std::vector<std::vector<Meeting>> found_;  // one a watched body
};

}  // namespace tandem
