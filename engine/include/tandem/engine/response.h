// A contact response for rigid bodies: gravity, contacts and friction.
#pragma once
#include <memory>

#include "tandem/broadphase/pair.h"
#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// Parameters of a response, none above 1e30, but for speeds, of which more counts as that. Defaults suit metre-sized
/// rigid bodies at 60 Hz.
struct ResponseOptions {
  int substeps = 4;                   ///< [1, 64]; more makes contacts stiffer
  double friction = 0.5;              ///< Coulomb, >= 0
  double rolling_resistance = 0.05;   ///< torque over normal force and body radius, >= 0; also against twisting
  double contact_hertz = 30;          ///< stiffness of a contact, > 0; limited to a quarter of the sub-step rate
  double contact_damping_ratio = 10;  ///< > 0
  double max_push_out = 3;            ///< m/s, largest speed at which overlap is removed, > 0
  double max_speed = 500;             ///< m/s, > 0: faster bodies are slowed to this
  /// The same as the pipeline's, if it has one: continuous bodies pass through dropped pairs.
  PairPredicate predicate{};
  int threads = 0;  ///< in all, the caller counted, [0, 1024]; 0: those of the arena it is called in
};

struct ResponseReport {
  double kinetic_energy = 0;  ///< J, all moving bodies, after the step
  double max_depth = 0;       ///< metres, as detected
  std::size_t stops = 0;      ///< number of stops of continuous bodies
  double ms = 0;              ///< wall
  /// The part of it outside of loops that threads may share: on one thread the serial fraction of Amdahl's law.
  double serial_ms = 0;
};

/// The recommended AnswerOptions::margin for a response, metres, so that bodies are stopped in time: the distance that
/// 6 m/s cover in a step, but at most a tenth of the smallest moving body's size. 0 if nothing moves.
double recommended_margin(const Scene& scene);

/// Moves the bodies of a scene by one `dt`: gravity, contacts with friction, no restitution. Soft-constraint
/// sequential impulses with sub-steps (Catto, "Soft Step", 2024; Macklin et al., "Small Steps", SCA 2019), warm started
/// from the step before. One response a scene. Contacts of bodies that have nothing to do with each other are solved in
/// parallel; the order of the others follows the contact list, so the motion is the same bits for any executor and any
/// number of threads. Continuous bodies go as far as ContinuousMotion lets them. A body without weight (a point),
/// or with a mass (kg) or a moment of inertia (kg m^2) below 1e-80 or above 1e80, stays where it is. Moments of inertia
/// below 1e-8 of a body's largest count as that much.
class Response {
 public:
  /// Throws std::invalid_argument that names the option, its value and what is allowed.
  explicit Response(ResponseOptions options = {});
  ~Response();
  Response(Response&&) noexcept;
  Response& operator=(Response&&) noexcept;
  /// Detection must have run on these poses; contacts with negative depth are used to stop bodies in time. Throws
  /// std::invalid_argument if the scene's dt is not > 0 or more than 1000 s, a component of its gravity is not a number
  /// of at most 1e30 m/s^2 in size, or the contacts are of bodies that it does not have.
  ResponseReport step(Scene& scene, const ContactList& contacts);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
