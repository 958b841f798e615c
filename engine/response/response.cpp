// A step of the response: solves contacts and moves the bodies.
#include "tandem/engine/response.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "response/contact_solver.h"
#include "response/exact_sum.h"
#include "response/parallel_blocks.h"
#include "response/solver_bodies.h"
#include "scene/scene_contacts.h"
#include "scene/tolerances.h"
#include "tandem/engine/continuous_motion.h"

namespace tandem {
namespace {

void require(bool allowed, const char* field, double value, const char* range) {
  if (allowed) return;
  std::ostringstream message;
  message.precision(17);
  message << "response: " << field << " is " << value << ", allowed: " << range;
  throw std::invalid_argument(message.str());
}

constexpr const char* positive = "> 0, at most 1e30";
constexpr const char* not_negative = ">= 0, at most 1e30";
bool is_positive(double x) { return x > 0 && x <= tolerance::largest_of_response; }
bool is_not_negative(double x) { return x >= 0 && x <= tolerance::largest_of_response; }

}  // namespace

struct Response::Impl {
  ResponseOptions options;
  ParallelTime parallel;
  ContactSolver solver{parallel};
  SolverBodies bodies{parallel};
  std::optional<ContinuousMotion> motion;
  std::vector<Pose> ends;    // one an index, if there are continuous bodies
  ContactList with_stopped;  // the contacts, and those of bodies that were stopped in the step before
  std::size_t stops_before = 0;

  const ContactList& with_stops(const Scene& scene, const ContactList& contacts);
  std::size_t limit_motion(const Scene& scene);
  double put_back(Scene& scene);
  ResponseReport step(Scene& scene, const ContactList& contacts);

  std::unique_ptr<tbb::task_arena> arena;  // if the caller's has another number of threads
};

/// The contacts of a step, and those at the nearest points of pairs that were stopped in the step before.
const ContactList& Response::Impl::with_stops(const Scene& scene, const ContactList& contacts) {
  if (stops_before == 0) return contacts;
  with_stopped = contacts;
  motion->add_contacts(scene, with_stopped);
  return with_stopped;
}

/// Limits the end poses of continuous bodies; returns the number of stops.
std::size_t Response::Impl::limit_motion(const Scene& scene) {
  ends.clear();
  if (!scene.has_continuous()) return 0;
  bodies.find_ends(scene, ends);
  return motion->limit(scene, ends).size();
}

/// Writes the bodies back; returns the kinetic energy.
double Response::Impl::put_back(Scene& scene) {
  const std::vector<std::uint32_t>& moving = bodies.moving();
  std::vector<ExactSum> energies((moving.size() + response_bodies_a_block - 1) / response_bodies_a_block);
  for_blocks(moving.size(), response_bodies_a_block, parallel, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t i : std::span(moving).subspan(begin, end - begin)) {
      const Pose pose = ends.empty() ? bodies.end_of(scene, i) : ends[i];
      const SolverBodies::End its = bodies.end_at(scene, i, pose);
      scene.move(i, pose, its.velocity, its.angular_velocity);
      energies[begin / response_bodies_a_block].add(its.kinetic_energy);
    }
  });
  ExactSum all;
  for (const ExactSum& some : energies) all.add(some);
  return all.value();
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
  require(is_not_negative(options.friction), "friction", options.friction, not_negative);
  require(is_not_negative(options.rolling_resistance), "rolling_resistance", options.rolling_resistance, not_negative);
  require(is_positive(options.contact_hertz), "contact_hertz", options.contact_hertz, positive);
  require(is_positive(options.contact_damping_ratio), "contact_damping_ratio", options.contact_damping_ratio, positive);
  for (const auto& [name, speed] :
       {std::pair("max_push_out", &options.max_push_out), {"max_speed", &options.max_speed}}) {
    require(std::isfinite(*speed) && *speed > 0, name, *speed, "finite, > 0");
    *speed = std::min(*speed, tolerance::largest_of_response);
  }
  impl_->motion.emplace(options.predicate);
  impl_->options = std::move(options);
}

Response::~Response() = default;
Response::Response(Response&&) noexcept = default;
Response& Response::operator=(Response&&) noexcept = default;

ResponseReport Response::Impl::step(Scene& scene, const ContactList& contacts) {
  parallel = {};
  bodies.begin_step(scene, options.max_speed);
  solver.prepare(with_stops(scene, contacts), bodies.all(), options);
  const double h = scene.dt / options.substeps;
  solver.begin_substeps(h, options);
  for (int substep = 0; substep < options.substeps; ++substep) {
    bodies.accelerate(h * scene.gravity);
    solver.warm_start(bodies.all());
    solver.solve(bodies.all(), ContactSolver::Overlap::push_out);
    bodies.advance(h);
    solver.solve(bodies.all(), ContactSolver::Overlap::leave);
  }
  ResponseReport report;
  report.stops = stops_before = limit_motion(scene);
  report.kinetic_energy = put_back(scene);
  return report;
}

ResponseReport Response::step(Scene& scene, const ContactList& contacts) {
  const auto start = std::chrono::steady_clock::now();
  require(scene.dt > 0 && scene.dt <= tolerance::longest_time_step, "dt", scene.dt, tolerance::time_step_range);
  for (const double g : scene.gravity)
    require(std::abs(g) <= tolerance::largest_of_response, "gravity", g, "components of at most 1e30 m/s^2 in size");
  require_contacts_of(scene, contacts, "response");
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
