#include "tandem/engine/response.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>

#include "response/contact_solver.h"
#include "response/parallel_blocks.h"
#include "tandem/engine/continuous_motion.h"

namespace tandem {
namespace {

constexpr std::size_t bodies_a_block = 128;

void require(bool allowed, const char* field, double value, const char* range) {
  if (allowed) return;
  std::ostringstream message;
  message.precision(17);
  message << "response: " << field << " is " << value << ", allowed: " << range;
  throw std::invalid_argument(message.str());
}

bool is_positive(double x) { return std::isfinite(x) && x > 0; }
bool is_not_negative(double x) { return std::isfinite(x) && x >= 0; }

void limit(Vec3& v, double most) {
  if (!(v.squaredNorm() <= most * most)) v = most * v.stableNormalized();
}

/// Beyond an eighth of a turn in a time step a direction of turning means little.
double fastest_turn(double time_step) { return std::numbers::pi / 4 / time_step; }

/// First order in the turn, then made a unit again; good for turns of a few tenths of a radian.
void turn(Quat& orientation, const Vec3& rotation) {
  const Quat rate(0, rotation.x(), rotation.y(), rotation.z());
  orientation.coeffs() += 0.5 * (rate * orientation).coeffs();
  orientation.normalize();
}

/// With density 1, in the shape's frame.
struct ShapeMass {
  double volume = 0;
  Vec3 centre;
  Mat3 inertia, inverse_inertia;
  double radius = 0;
};

/// A radius for any body: a ball's own.
double mean_radius(const Shape& shape) { return shape.size() / std::sqrt(12.0); }

}  // namespace

struct Response::Impl {
  ResponseOptions options;
  ParallelTime parallel;
  ContactSolver solver{parallel};
  std::vector<ShapeMass> shapes;
  std::vector<SolverBody> bodies;  // one an index of the scene
  std::vector<Quat> orientations;  // the same, and so are the rotations half a step ahead
  std::vector<Mat3> half_turned;
  std::vector<std::uint32_t> moving;
  std::optional<ContinuousMotion> motion;
  std::vector<Pose> ends;       // one an index, where there are continuous bodies
  ContactList with_stopped;     // the contacts, and those of bodies that were stopped in the step before
  std::size_t stops_before = 0;

  void prepare_bodies(const Scene& scene);
  void accelerate(const Vec3& change);
  void advance(double h);
  const ContactList& with_stops(const Scene& scene, const ContactList& contacts);
  std::size_t limit_motion(const Scene& scene);
  Pose end_of(const Scene& scene, std::uint32_t index) const;
  double put_back(Scene& scene);
  double put_back(Scene& scene, std::uint32_t index) const;
  ResponseReport step(Scene& scene, const ContactList& contacts);
  void prepare_body(const Scene& scene, std::uint32_t index);

  std::unique_ptr<tbb::task_arena> arena;  // where the caller's has another number of threads
};

void Response::Impl::prepare_bodies(const Scene& scene) {
  shapes.clear();
  for (const Shape& shape : scene.shapes()) {
    const MassProperties& mass = shape.mass();
    shapes.push_back({mass.volume, mass.centre, mass.inertia, mass.inertia.inverse(), mean_radius(shape)});
  }
  bodies.resize(scene.indices());
  orientations.resize(scene.indices());
  half_turned.resize(scene.indices());
  for_blocks(scene.indices(), bodies_a_block, parallel, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) prepare_body(scene, static_cast<std::uint32_t>(i));
  });
  moving.clear();
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (bodies[i].inverse_mass != 0) moving.push_back(i);
}

void Response::Impl::prepare_body(const Scene& scene, std::uint32_t i) {
  SolverBody& body = bodies[i];
  body = {};
  if (!scene.alive(i)) return;
  const Pose& pose = scene.poses()[i];
  const ShapeMass& shape = shapes[scene.shape_indices()[i]];
  body.centre = scene.is_static()[i] ? pose.translation : pose * shape.centre;
  body.is_sensor = scene.is_sensor()[i] != 0;
  if (scene.is_static()[i]) {
    body.velocity = scene.velocities()[i];
    body.angular_velocity = scene.angular_velocities()[i];
    limit(body.velocity, options.max_speed);
    limit(body.angular_velocity, fastest_turn(scene.dt));
    return;
  }
  const double density = scene.densities()[i];
  orientations[i] = Quat(pose.rotation);
  // While a body turns its angular momentum stays, not its angular velocity: that is the gyroscopic torque. With the
  // inertia of half a step ahead it is kept exactly, impulses included, and the energy to second order.
  Vec3 spin = scene.angular_velocities()[i];
  limit(spin, fastest_turn(scene.dt));
  Quat half = orientations[i];
  turn(half, scene.dt / 2 * spin);
  half_turned[i] = half.toRotationMatrix();
  const Mat3& to_world = half_turned[i];
  const Mat3 inverse_inertia = to_world * shape.inverse_inertia * to_world.transpose() / density;
  const double mass = shape.volume * density;
  if (!is_positive(mass) || !inverse_inertia.allFinite() || !(inverse_inertia.diagonal().minCoeff() > 0)) return;
  body.inverse_mass = 1 / mass;
  body.inverse_inertia = inverse_inertia;
  body.velocity = scene.velocities()[i];
  const Vec3 own_momentum = shape.inertia * (pose.rotation.transpose() * spin);
  const Vec3 momentum = pose.rotation * own_momentum;
  body.angular_velocity = to_world * (shape.inverse_inertia * (to_world.transpose() * momentum));
  body.radius = shape.radius;
}

void Response::Impl::accelerate(const Vec3& change) {
  for (const std::uint32_t i : moving) bodies[i].velocity += change;
}

void Response::Impl::advance(double h) {
  const double fastest = fastest_turn(h);
  for_blocks(moving.size(), bodies_a_block, parallel, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t i : std::span(moving).subspan(begin, end - begin)) {
      SolverBody& body = bodies[i];
      limit(body.velocity, options.max_speed);
      limit(body.angular_velocity, fastest);
      body.moved += h * body.velocity;
      const Vec3 rotation = h * body.angular_velocity;
      body.turned += rotation;
      turn(orientations[i], rotation);
    }
  });
}

/// Those of a step, and the nearest points of pairs that were stopped in the step before.
const ContactList& Response::Impl::with_stops(const Scene& scene, const ContactList& contacts) {
  if (stops_before == 0) return contacts;
  with_stopped = contacts;
  motion->add_contacts(scene, with_stopped);
  return with_stopped;
}

/// Where continuous bodies end; returns how many stops there were.
std::size_t Response::Impl::limit_motion(const Scene& scene) {
  ends.clear();
  if (!scene.has_continuous()) return 0;
  free_ends(scene, ends);  // of the static ones
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (bodies[i].inverse_mass != 0)
      ends[i] = end_of(scene, i);
    else if (!scene.is_static()[i] || !is_valid(ends[i]))
      ends[i] = scene.poses()[i];
  return motion->limit(scene, ends).size();
}

Pose Response::Impl::end_of(const Scene& scene, std::uint32_t i) const {
  Pose pose;
  pose.rotation = orientations[i].toRotationMatrix();
  pose.translation = bodies[i].centre + bodies[i].moved - pose.rotation * shapes[scene.shape_indices()[i]].centre;
  return pose;
}

/// Returns the kinetic energy.
double Response::Impl::put_back(Scene& scene) {
  // Summed by blocks, so that the rounding does not depend on threads either.
  std::vector<double> energies((moving.size() + bodies_a_block - 1) / bodies_a_block, 0.0);
  for_blocks(moving.size(), bodies_a_block, parallel, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t i : std::span(moving).subspan(begin, end - begin))
      energies[begin / bodies_a_block] += put_back(scene, i);
  });
  return std::accumulate(energies.begin(), energies.end(), 0.0);
}

/// Returns its kinetic energy.
double Response::Impl::put_back(Scene& scene, std::uint32_t i) const {
  const SolverBody& body = bodies[i];
  const ShapeMass& shape = shapes[scene.shape_indices()[i]];
  const Pose pose = ends.empty() ? end_of(scene, i) : ends[i];
  const Mat3& to_world = half_turned[i];
  const Vec3 momentum = to_world * (shape.inertia * (to_world.transpose() * body.angular_velocity));
  const Vec3 own_momentum = pose.rotation.transpose() * momentum;
  const Vec3 own_velocity = shape.inverse_inertia * own_momentum;
  scene.move(i, pose, body.velocity, pose.rotation * own_velocity);
  return 0.5 * scene.densities()[i] * (shape.volume * body.velocity.squaredNorm() + own_velocity.dot(own_momentum));
}

double recommended_margin(const Scene& scene) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (scene.alive(i) && !scene.is_static()[i]) smallest = std::min(smallest, scene.shape_of(i).size());
  return std::isfinite(smallest) ? std::min(6 * scene.dt, smallest / 10) : 0;
}

Response::Response(ResponseOptions options) : impl_(std::make_unique<Impl>()) {
  require(options.threads >= 0 && options.threads <= 1024, "threads", options.threads, "0 (ask the runtime) to 1024");
  require(options.substeps >= 1 && options.substeps <= 64, "substeps", options.substeps, "1 to 64");
  require(is_not_negative(options.friction), "friction", options.friction, "finite, >= 0");
  require(is_not_negative(options.rolling_resistance), "rolling_resistance", options.rolling_resistance,
          "finite, >= 0");
  require(is_positive(options.contact_hertz), "contact_hertz", options.contact_hertz, "finite, > 0");
  require(is_positive(options.contact_damping_ratio), "contact_damping_ratio", options.contact_damping_ratio,
          "finite, > 0");
  require(is_positive(options.max_push_out), "max_push_out", options.max_push_out, "finite, > 0");
  require(is_positive(options.max_speed), "max_speed", options.max_speed, "finite, > 0");
  impl_->motion.emplace(options.predicate);
  impl_->options = std::move(options);
}

Response::~Response() = default;
Response::Response(Response&&) noexcept = default;
Response& Response::operator=(Response&&) noexcept = default;

ResponseReport Response::Impl::step(Scene& scene, const ContactList& contacts) {
  parallel = {};
  prepare_bodies(scene);
  solver.prepare(with_stops(scene, contacts), bodies, options);
  const double h = scene.dt / options.substeps;
  solver.begin_substeps(h, options);
  for (int substep = 0; substep < options.substeps; ++substep) {
    accelerate(h * scene.gravity);
    solver.warm_start(bodies);
    solver.solve(bodies, ContactSolver::Overlap::push_out);
    advance(h);
    solver.solve(bodies, ContactSolver::Overlap::leave);
  }
  ResponseReport report;
  report.stops = stops_before = limit_motion(scene);
  report.kinetic_energy = put_back(scene);
  return report;
}

ResponseReport Response::step(Scene& scene, const ContactList& contacts) {
  const auto start = std::chrono::steady_clock::now();
  require(is_positive(scene.dt), "dt", scene.dt, "finite, > 0 s");
  require(scene.gravity.allFinite(), "gravity", scene.gravity.norm(), "finite");
  Impl& own = *impl_;
  const int threads = own.options.threads;
  ResponseReport report;
  if (threads == 0 || threads == tbb::this_task_arena::max_concurrency()) {
    report = own.step(scene, contacts);
  } else {
    if (!own.arena) own.arena = std::make_unique<tbb::task_arena>(threads);
    own.arena->execute([&] { report = own.step(scene, contacts); });
  }
  for (const Contact& contact : contacts.contacts) report.max_depth = std::max(report.max_depth, contact.depth);
  const auto ms = [](auto time) { return std::chrono::duration<double, std::milli>(time).count(); };
  const auto all = std::chrono::steady_clock::now() - start;
  report.ms = ms(all);
  report.serial_ms = ms(all - own.parallel.sum);
  return report;
}

}  // namespace tandem
