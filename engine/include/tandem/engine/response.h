#pragma once
#include <memory>

#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// What a response needs to know beyond the scene. Defaults suit metre-sized rigid bodies at 60 Hz.
struct ResponseOptions {
  int substeps = 4;                 ///< [1, 64]; more is stiffer
  double friction = 0.5;            ///< Coulomb, >= 0
  double rolling_resistance = 0.02; ///< torque over normal force and body radius, >= 0
  double contact_hertz = 30;        ///< stiffness of a contact, > 0, below a quarter of the sub-step rate
  double contact_damping_ratio = 10;
  double max_push_out = 3;          ///< m/s at which overlap is undone
};

struct ResponseReport {
  double kinetic_energy = 0;  ///< J, all moving bodies, after the step
  double max_depth = 0;       ///< metres, as detected
  double ms = 0;              ///< wall
};

/// Moves the bodies of a scene by one `dt`: gravity, contacts with friction, no restitution. Soft-constraint
/// sequential impulses with sub-steps (Catto, "Soft Step", 2024; Macklin et al., "Small Steps", SCA 2019).
/// The order of everything follows the contact list, so the motion is the same bits for any executor.
class Response {
 public:
  explicit Response(ResponseOptions options = {});
  ~Response();
  /// Detection must have run on these poses; contacts with negative depth (gaps) are used to stop in time.
  ResponseReport step(Scene& scene, const ContactList& contacts);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
