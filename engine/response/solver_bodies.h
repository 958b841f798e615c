// The bodies of a scene as a response moves them in a step.
#pragma once
#include <cstdint>
#include <vector>

#include "response/contact_solver.h"
#include "response/parallel_blocks.h"
#include "scene/scene_changes.h"
#include "tandem/engine/scene.h"

namespace tandem {

class SolverBodies {
 public:
  /// `parallel` measures the time that threads may share.
  explicit SolverBodies(ParallelTime& parallel) : parallel_(parallel) {}

  /// Takes the scene's bodies.
  void begin_step(const Scene& scene, double max_speed);
  /// Adds a velocity to all bodies that move.
  void accelerate(const Vec3& change);
  /// Moves by the velocities for a time.
  void advance(double h);
  /// The present pose of a body.
  Pose end_of(const Scene& scene, std::uint32_t index) const;
  /// The end poses of all bodies; a static body moves with its given velocity.
  void find_ends(const Scene& scene, std::vector<Pose>& ends) const;

  struct End {
    Vec3 velocity, angular_velocity;
    double kinetic_energy = 0;
  };
  /// The state of a body that ends at a pose.
  End end_at(const Scene& scene, std::uint32_t index, const Pose& pose) const;

  std::vector<SolverBody>& all() { return bodies_; }  ///< one an index of the scene
  bool moves(std::uint32_t index) const { return bodies_[index].inverse_mass != 0; }
  const std::vector<std::uint32_t>& moving() const { return moving_; }

 private:
  /// Mass properties with density 1, in the shape's frame.
  struct ShapeMass {
    double volume = 0;
    Vec3 centre;
    Mat3 inertia, inverse_inertia;
    double radius = 0;
  };

  void learn_shapes(const Scene& scene);
  void begin_body(const Scene& scene, std::uint32_t index);

  ParallelTime& parallel_;
  double max_speed_ = 0;
  SceneChanges::ShapesName known_shapes_;
  std::vector<ShapeMass> shapes_;
  std::vector<SolverBody> bodies_;
  std::vector<Quat> orientations_;  // one an index, as the rotations half a step ahead
  std::vector<Mat3> half_turned_;
  std::vector<std::uint32_t> moving_;
};

/// Bodies in a block of a parallel loop.
constexpr std::size_t response_bodies_a_block = 128;

}  // namespace tandem
