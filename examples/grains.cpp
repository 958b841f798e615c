// The discrete element method with tandem as its contact detection: spheres fall into a box, each contact pushes by a
// spring and a dashpot and holds by a spring along the surface (Cundall, Strack, A discrete numerical model for
// granular assemblies, Geotechnique 1979), which is kept with its contact from step to step. Prints what the bed
// weighs; exit code 1 when floor and walls do not carry it, or no spring lasts long enough to take a load.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/contact_memory.h"
#include "tandem/engine/pipeline.h"

namespace {

using tandem::Vec3;

constexpr double stiffness = 2e7, damping = 1e5;              // of a contact: N/m, N s/m
constexpr double along_stiffness = 1e7, along_damping = 5e4;  // of the spring along the surface
constexpr double friction = 0.5, dt = 2e-4;                   // a contact of the smallest grains lasts forty steps

/// A vector initialised to zero: Eigen's own is not initialised.
struct Spring {
  Vec3 stretch = Vec3::Zero();
};

struct Grains {
  explicit Grains(std::size_t count) : scene(tandem::make_builtin_scene("grains", count)) {
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      const double r = scene.is_static()[i] ? 0 : scene.shape_of(i).radius();
      radius.push_back(r);
      mass.push_back(scene.densities()[i] * 4 / 3 * std::numbers::pi * r * r * r);
    }
  }

  void step() {
    pipeline.step(scene);
    const tandem::ContactList& contacts = pipeline.contacts();
    springs.update(scene, contacts);
    force.assign(scene.indices(), Vec3::Zero());
    torque.assign(scene.indices(), Vec3::Zero());
    for (const tandem::PairResult& pair : contacts.pairs)
      for (std::size_t k = pair.first_contact; k < pair.first_contact + pair.contact_count; ++k)
        push(pair.a, pair.b, contacts.contacts[k], springs[k].stretch);
    for (std::uint32_t i = 0; i < scene.indices(); ++i)
      if (!scene.is_static()[i]) move(i);
  }

  /// Spheres have one contact a pair; its spring rotates with the surface.
  void push(std::uint32_t a, std::uint32_t b, const tandem::Contact& contact, Vec3& spring) {
    const Vec3 velocity = velocity_at(b, contact.point) - velocity_at(a, contact.point), &n = contact.normal;
    const double approach = -velocity.dot(n), pressure = std::max(stiffness * contact.depth + damping * approach, 0.0);
    const Vec3 along = velocity + approach * n;
    spring += along * dt - spring.dot(n) * n;
    Vec3 hold = -along_stiffness * spring - along_damping * along;
    if (const double most = friction * pressure; hold.norm() > most) {
      hold *= most / hold.norm();
      spring = -hold / along_stiffness;
    }
    for (const auto& [body, sign] : {std::pair(a, -1.0), std::pair(b, 1.0)}) {
      const Vec3 on_body = sign * (pressure * n + hold);
      force[body] += on_body;
      torque[body] += (contact.point - scene.poses()[body].translation).cross(on_body);
    }
  }

  Vec3 velocity_at(std::uint32_t i, const Vec3& point) const {
    return scene.velocities()[i] + scene.angular_velocities()[i].cross(point - scene.poses()[i].translation);
  }

  void move(std::uint32_t i) {
    const double inertia = 0.4 * mass[i] * radius[i] * radius[i];
    const Vec3 velocity = scene.velocities()[i] + (force[i] / mass[i] + scene.gravity) * dt;
    const Vec3 turning = scene.angular_velocities()[i] + torque[i] / inertia * dt;
    const tandem::Pose& old = scene.poses()[i];
    const double angle = turning.norm() * dt;
    const tandem::Quat turn(Eigen::AngleAxisd(angle, angle > 0 ? Vec3(turning.normalized()) : Vec3::UnitZ()));
    scene.move(i, tandem::Pose::from(turn * tandem::Quat(old.rotation), old.translation + velocity * dt), velocity,
               turning);
  }

  tandem::Scene scene;
  tandem::Pipeline pipeline;
  tandem::ContactMap<Spring> springs{0.1};  // metres: contacts move less in a step
  std::vector<double> radius, mass;
  std::vector<Vec3> force, torque;
};

}  // namespace

int main() {
  constexpr int settling = 30000, watched = 1000;
  Grains grains(120);
  Vec3 carried = Vec3::Zero();  // by fixed bodies, on average
  double weight = 0, deepest = 0, longest = 0;
  for (int step = 0; step < settling + watched; ++step) {
    grains.step();
    if (step < settling) continue;
    for (std::uint32_t i = 0; i < grains.scene.indices(); ++i)
      if (grains.scene.is_static()[i]) carried += grains.force[i] / watched;
    for (const tandem::Contact& contact : grains.pipeline.contacts().contacts)
      deepest = std::max(deepest, contact.depth);
    for (std::size_t k = 0; k < grains.springs.size(); ++k)
      longest = std::max(longest, grains.springs[k].stretch.norm());
  }
  for (std::uint32_t i = 0; i < grains.scene.indices(); ++i)
    if (!grains.scene.is_static()[i]) weight -= grains.mass[i] * grains.scene.gravity.z();
  std::printf(
      "%zu contacts; the bed weighs %.0f N, floor and walls carry %.0f N; deepest %.2g m, longest spring %.2g m\n",
      grains.springs.size(), weight, -carried.z(), deepest, longest);
  const bool right = std::abs(carried.z() + weight) < 0.02 * weight && longest > 1e-3 && deepest < 0.05;
  if (!right) std::printf("WRONG\n");
  return right ? 0 : 1;
}
