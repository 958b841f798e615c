// The bodies of a step of the response: masses, velocities and poses.
#include "response/solver_bodies.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "response/free_end.h"
#include "scene/tolerances.h"

namespace tandem {
namespace {

/// Of a mass, or of the inverse of a moment of inertia.
bool is_mass(double x) { return x >= tolerance::lightest_mass && x <= tolerance::heaviest_mass; }

void limit(Vec3& v, double most) {
  if (!(v.squaredNorm() <= most * most)) v = most * v.stableNormalized();
}

/// The largest angular velocity: beyond an eighth of a turn in a time step a direction of rotation means little.
double fastest_turn(double time_step) {
  return std::min(std::numbers::pi / 4 / time_step, tolerance::largest_of_response);
}

/// Rotates to first order, then normalises; good for a few tenths of a radian.
void turn(Quat& orientation, const Vec3& rotation) {
  const Quat rate(0, rotation.x(), rotation.y(), rotation.z());
  orientation.coeffs() += 0.5 * (rate * orientation).coeffs();
  orientation.normalize();
}

/// The moments of inertia of a shape, none less than a share of the largest: the inverse of a needle's, in axes of the
/// world, is lost in rounding.
Mat3 rounded_up(const Mat3& inertia) {
  const Eigen::SelfAdjointEigenSolver<Mat3> principal(inertia);
  const Vec3 moments = principal.eigenvalues();  // ascending
  const double least = tolerance::least_moment * moments[2];
  if (!(moments[0] < least)) return inertia;
  return principal.eigenvectors() * moments.cwiseMax(least).asDiagonal() * principal.eigenvectors().transpose();
}

/// A radius for any body; for a ball its own.
double mean_radius(const Shape& shape) { return shape.size() / std::sqrt(12.0); }

}  // namespace

void SolverBodies::begin_step(const Scene& scene, double max_speed) {
  max_speed_ = max_speed;
  learn_shapes(scene);
  bodies_.resize(scene.indices());
  orientations_.resize(scene.indices());
  half_turned_.resize(scene.indices());
  for_blocks(scene.indices(), response_bodies_a_block, parallel_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) begin_body(scene, static_cast<std::uint32_t>(i));
  });
  moving_.clear();
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (bodies_[i].inverse_mass != 0) moving_.push_back(i);
}

void SolverBodies::learn_shapes(const Scene& scene) {
  const SceneChanges::ShapesName now(scene);
  if (now == known_shapes_) return;
  known_shapes_ = now;
  shapes_.clear();
  for (const Shape& shape : scene.shapes()) {
    const MassProperties mass = shape.mass();
    const Mat3 inertia = rounded_up(mass.inertia);
    shapes_.push_back({mass.volume, mass.centre, inertia, inertia.inverse(), mean_radius(shape)});
  }
}

void SolverBodies::begin_body(const Scene& scene, std::uint32_t i) {
  SolverBody& body = bodies_[i];
  body = {};
  if (!scene.alive(i)) return;
  const Pose& pose = scene.poses()[i];
  const ShapeMass& shape = shapes_[scene.shape_indices()[i]];
  body.centre = scene.is_static()[i] ? pose.translation : pose * shape.centre;
  body.is_sensor = scene.is_sensor()[i] != 0;
  if (scene.is_static()[i]) {
    body.velocity = scene.velocities()[i];
    body.angular_velocity = scene.angular_velocities()[i];
    limit(body.velocity, max_speed_);
    limit(body.angular_velocity, fastest_turn(scene.dt));
    return;
  }
  const double density = scene.densities()[i];
  orientations_[i] = Quat(pose.rotation);
  // While a body rotates its angular momentum is constant, not its angular velocity: the gyroscopic torque. With the
  // inertia half a step ahead the momentum is conserved exactly, impulses included, and the energy to second order.
  Vec3 spin = scene.angular_velocities()[i];
  limit(spin, fastest_turn(scene.dt));
  Quat half = orientations_[i];
  turn(half, scene.dt / 2 * spin);
  half_turned_[i] = half.toRotationMatrix();
  const Mat3& to_world = half_turned_[i];
  const Mat3 inverse_inertia = to_world * shape.inverse_inertia * to_world.transpose() / density;
  const double mass = shape.volume * density;
  // The inverse of the sum of two of them is a quotient of products of three.
  const Vec3 turns = inverse_inertia.diagonal();
  if (!is_mass(mass) || !is_mass(turns.minCoeff()) || !is_mass(turns.maxCoeff())) return;
  body.inverse_mass = 1 / mass;
  body.inverse_inertia = inverse_inertia;
  body.velocity = scene.velocities()[i];
  limit(body.velocity, max_speed_);
  const Vec3 own_momentum = shape.inertia * (pose.rotation.transpose() * spin);
  const Vec3 momentum = pose.rotation * own_momentum;
  body.angular_velocity = to_world * (shape.inverse_inertia * (to_world.transpose() * momentum));
  body.radius = shape.radius;
}

void SolverBodies::accelerate(const Vec3& change) {
  for (const std::uint32_t i : moving_) bodies_[i].velocity += change;
}

void SolverBodies::advance(double h) {
  const double fastest = fastest_turn(h);
  for_blocks(moving_.size(), response_bodies_a_block, parallel_, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t i : std::span(moving_).subspan(begin, end - begin)) {
      SolverBody& body = bodies_[i];
      limit(body.velocity, max_speed_);
      limit(body.angular_velocity, fastest);
      body.moved += h * body.velocity;
      const Vec3 rotation = h * body.angular_velocity;
      body.turned += rotation;
      turn(orientations_[i], rotation);
    }
  });
}

Pose SolverBodies::end_of(const Scene& scene, std::uint32_t i) const {
  Pose pose;
  pose.rotation = orientations_[i].toRotationMatrix();
  pose.translation = bodies_[i].centre + bodies_[i].moved - pose.rotation * shapes_[scene.shape_indices()[i]].centre;
  return pose;
}

void SolverBodies::find_ends(const Scene& scene, std::vector<Pose>& ends) const {
  ends.assign(scene.poses().begin(), scene.poses().end());
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (moves(i))
      ends[i] = end_of(scene, i);
    else if (scene.alive(i) && scene.is_static()[i])
      if (const Pose end = free_end(scene, i); is_valid(end)) ends[i] = end;
}

SolverBodies::End SolverBodies::end_at(const Scene& scene, std::uint32_t i, const Pose& pose) const {
  const SolverBody& body = bodies_[i];
  const ShapeMass& shape = shapes_[scene.shape_indices()[i]];
  const Mat3& to_world = half_turned_[i];
  const Vec3 momentum = to_world * (shape.inertia * (to_world.transpose() * body.angular_velocity));
  const Vec3 own_momentum = pose.rotation.transpose() * momentum;
  const Vec3 own_velocity = shape.inverse_inertia * own_momentum;
  return {body.velocity, pose.rotation * own_velocity,
          0.5 * scene.densities()[i] * (shape.volume * body.velocity.squaredNorm() + own_velocity.dot(own_momentum))};
}

}  // namespace tandem
