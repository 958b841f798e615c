// The response: stacks, friction, rolling, momentum, determinism.
#include "tandem/engine/response.h"

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

#include "catch.h"
#include "message_of.h"
#include "response/exact_sum.h"
#include "scene/random.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using Catch::Matchers::Contains;

namespace {

constexpr double gravity = 9.81;

/// All pairs of the scene, in canonical order, including contacts of negative depth within `margin`.
ContactList detect(const Scene& scene, double margin) {
  NarrowPhaseOptions options;
  options.margin = margin;
  const NarrowPhase narrow_phase(options);
  ContactList list;
  for (std::uint32_t a = 0; a < scene.indices(); ++a)
    for (std::uint32_t b = a + 1; b < scene.indices(); ++b) {
      if (scene.is_static()[a] && scene.is_static()[b]) continue;
      const auto first = static_cast<std::uint32_t>(list.contacts.size());
      PairResult result;
      result.a = a;
      result.b = b;
      result.first_contact = first;
      result.answer = narrow_phase.solve(scene.shape_of(a), scene.poses()[a], scene.shape_of(b), scene.poses()[b],
                                         Request::contacts, &list.contacts);
      result.contact_count = static_cast<std::uint32_t>(list.contacts.size()) - first;
      if (result.contact_count > 0) list.pairs.push_back(result);
    }
  return list;
}

struct Run {
  ResponseReport last;
  double deepest = 0;
};

Run run(Scene& scene, Response& response, int steps, double margin = 0.1) {
  Run result;
  for (int i = 0; i < steps; ++i) {
    result.last = response.step(scene, detect(scene, margin));
    result.deepest = std::max(result.deepest, result.last.max_depth);
  }
  return result;
}

BodyId add(Scene& scene, const Shape& shape, const Pose& pose, bool is_static = false) {
  BodyOptions body;
  body.shape = scene.add_shape(shape);
  body.pose = pose;
  body.is_static = is_static;
  return scene.add_body(body);
}

void add_ground(Scene& scene) { add(scene, Shape(HalfSpace{}), {}, true); }

struct Momenta {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();  ///< about the world's origin
  double energy = 0;
};

Momenta momenta(const Scene& scene) {
  Momenta sum;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (scene.is_static()[i]) continue;
    const MassProperties mass = scene.shape_of(i).mass();
    const Pose& pose = scene.poses()[i];
    const Vec3 linear = scene.densities()[i] * mass.volume * scene.velocities()[i];
    const Vec3 spin = scene.densities()[i] *
                      (pose.rotation * (mass.inertia * (pose.rotation.transpose() * scene.angular_velocities()[i])));
    sum.linear += linear;
    sum.angular += (pose * mass.centre).cross(linear) + spin;
    sum.energy += 0.5 * (linear.dot(scene.velocities()[i]) + spin.dot(scene.angular_velocities()[i]));
  }
  return sum;
}

bool equal(const Scene& a, const Scene& b) {
  for (std::uint32_t i = 0; i < a.indices(); ++i)
    if (a.poses()[i].rotation != b.poses()[i].rotation || a.poses()[i].translation != b.poses()[i].translation ||
        a.velocities()[i] != b.velocities()[i] || a.angular_velocities()[i] != b.angular_velocities()[i])
      return false;
  return true;
}

Scene pile_of_boxes() {
  Scene scene;
  add_ground(scene);
  Random random(11);
  for (int i = 0; i < 30; ++i) {
    Pose pose = Pose::at(i % 3 * 1.1, i / 3 % 3 * 1.1, 1 + i / 9 * 1.9);
    pose.rotation = random.rotation();
    add(scene, Shape(Box{{1, 0.8, 0.6}}), pose);
  }
  return scene;
}

}  // namespace

TEST_CASE("response: options that make no sense are refused by name") {
  const auto refusal = [](auto change) {
    ResponseOptions options;
    change(options);
    CHECK_THROWS_AS(Response(options), std::invalid_argument);
    return message_of([&] { Response response(options); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(refusal([](auto& o) { o.substeps = 0; }), Contains("substeps is 0"));
  CHECK_THAT(refusal([](auto& o) { o.threads = -1; }), Contains("threads is -1"));
  CHECK_THAT(refusal([](auto& o) { o.substeps = 65; }), Contains("substeps is 65"));
  CHECK_THAT(refusal([](auto& o) { o.friction = -1; }), Contains("friction"));
  CHECK_THAT(refusal([&](auto& o) { o.rolling_resistance = nan; }), Contains("rolling_resistance is nan"));
  CHECK_THAT(refusal([](auto& o) { o.contact_hertz = 0; }), Contains("contact_hertz"));
  CHECK_THAT(refusal([](auto& o) { o.contact_damping_ratio = 0; }), Contains("contact_damping_ratio"));
  CHECK_THAT(refusal([](auto& o) { o.max_push_out = 0; }), Contains("max_push_out"));
  CHECK_THAT(refusal([](auto& o) { o.max_speed = 0; }), Contains("max_speed"));
  CHECK_THAT(refusal([](auto& o) { o.friction = 1.1e30; }), Contains("friction") && Contains("at most 1e30"));
  Scene scene;
  Response response;
  scene.dt = 0;
  CHECK_THROWS_AS(response.step(scene, {}), std::invalid_argument);
  scene.dt = 0.01;
  for (const double bad : {nan, 1.1e30, -1e308}) {
    scene.gravity.x() = bad;
    CHECK_THAT(message_of([&] { response.step(scene, {}); }),
               Contains("gravity is ") && Contains("at most 1e30 m/s^2"));
  }
}

TEST_CASE("response: the margin that is recommended follows speed, time step and the smallest moving body") {
  Scene scene;
  CHECK(recommended_margin(scene) == 0);
  add(scene, Shape(Sphere{0.001}), {}, true);
  CHECK(recommended_margin(scene) == 0);
  add(scene, Shape(Box{{1, 1, 1}}), {});
  CHECK(recommended_margin(scene) == Approx(0.1));
  const BodyId small = add(scene, Shape(Box{{0.03, 0.04, 0.12}}), {});
  CHECK(recommended_margin(scene) == Approx(0.013));
  scene.remove_body(small);
  CHECK(recommended_margin(scene) == Approx(0.1));
}

TEST_CASE("response: free fall is gravity's, exact in velocity, within a sub-step in height") {
  Scene scene;
  const BodyId ball = add(scene, Shape(Sphere{0.5}), Pose::at(0, 0, 100));
  Response response;
  const Run result = run(scene, response, 60);
  CHECK(scene.velocities()[0].z() == Approx(-gravity).epsilon(1e-12));
  CHECK(100 - scene.pose(ball).translation.z() == Approx(gravity / 2).epsilon(1.01 / 240));
  CHECK(result.last.kinetic_energy == Approx(momenta(scene).energy).epsilon(1e-12));
}

TEST_CASE("response: a box comes to rest on a plane, level and still") {
  for (const double margin : {0.1, 0.0}) {
    CAPTURE(margin);
    Scene scene;
    add_ground(scene);
    Pose pose = Pose::at(0, 0, 1.2);
    pose.rotation = Quat(0.95, 0.2, 0.2, 0.1).normalized().toRotationMatrix();
    const BodyId box = add(scene, Shape(Box{{1, 1, 1}}), pose);
    Response response;
    const Run result = run(scene, response, 300, margin);
    CHECK(result.last.kinetic_energy < 1e-3);
    CHECK(scene.pose(box).translation.z() == Approx(0.5).margin(0.005));
    CHECK(scene.pose(box).rotation.cwiseAbs().rowwise().maxCoeff()(2) > 0.9999);
    CHECK(result.deepest < 0.09);
  }
}

TEST_CASE("response: a body whose weight lies beside its origin rests where its weight is") {
  Scene scene;
  add_ground(scene);
  Convex wedge;
  for (const double x : {0.0, 1.0})
    for (const double y : {0.0, 1.0})
      for (const double z : {0.0, 0.5}) wedge.vertices.emplace_back(x + 3, y - 2, z + 5);
  const BodyId body = add(scene, Shape(wedge), Pose::at(0, 0, -4.9));
  Response response;
  run(scene, response, 200);
  CHECK((scene.pose(body).translation - Vec3(0, 0, -5)).norm() < 0.01);
  CHECK(scene.pose(body).rotation.isIdentity(0.01));
}

TEST_CASE("response: a sliding box stops after v^2 / (2 mu g)") {
  for (const double friction : {0.2, 0.5}) {
    CAPTURE(friction);
    Scene scene;
    add_ground(scene);
    const BodyId box = add(scene, Shape(Box{{1, 1, 0.2}}), Pose::at(0, 0, 0.1));
    const double speed = 4;
    scene.set_velocity(box, {speed * 0.6, speed * 0.8, 0}, Vec3::Zero());
    ResponseOptions options;
    options.friction = friction;
    Response response(options);
    run(scene, response, 240);
    const Vec3 moved = scene.pose(box).translation - Vec3(0, 0, 0.1);
    CHECK(moved.head<2>().norm() == Approx(speed * speed / (2 * friction * gravity)).epsilon(0.03));
    // A cone of friction: the direction stays, except for a small rotation by unequally loaded corners. A pyramid would
    // give 1.78 or 1.
    CHECK(moved.y() / moved.x() == Approx(0.8 / 0.6).epsilon(0.1));
    CHECK(scene.velocities()[1].norm() < 1e-3);
  }
}

TEST_CASE("response: without friction nothing stops a slide") {
  Scene scene;
  add_ground(scene);
  const BodyId box = add(scene, Shape(Box{{1, 1, 0.2}}), Pose::at(0, 0, 0.1));
  scene.set_velocity(box, {3, 0, 0}, Vec3::Zero());
  ResponseOptions options;
  options.friction = 0;
  Response response(options);
  run(scene, response, 120);
  CHECK(scene.velocities()[1].x() == Approx(3).epsilon(1e-9));
}

TEST_CASE("response: a rolling ball slows down by its rolling resistance, and not without") {
  const auto speed_after = [](double resistance) {
    Scene scene;
    add_ground(scene);
    const BodyId ball = add(scene, Shape(Sphere{0.5}), Pose::at(0, 0, 0.5));
    scene.set_velocity(ball, {2, 0, 0}, {0, 4, 0});
    ResponseOptions options;
    options.rolling_resistance = resistance;
    Response response(options);
    run(scene, response, 60);
    return scene.velocities()[1].x();
  };
  CHECK(speed_after(0) == Approx(2).epsilon(1e-3));
  // The torque c m g r against the inertia about the point of contact, 7/5 m r^2.
  CHECK(speed_after(0.1) == Approx(2 - 0.1 * gravity * 5 / 7).epsilon(0.01));
  CHECK(std::abs(speed_after(0.5)) < 1e-3);
}

TEST_CASE("response: balls stacked stay stacked, barely deeper than the softness of contacts") {
  Scene scene;
  add_ground(scene);
  for (int i = 0; i < 8; ++i) add(scene, Shape(Sphere{0.5}), Pose::at(0, 0, 0.5 + i));
  Response response;
  const Run result = run(scene, response, 300);
  for (std::uint32_t i = 1; i < scene.indices(); ++i) {
    CHECK(scene.poses()[i].translation.z() == Approx(i - 0.5).margin(0.03));
    CHECK(scene.poses()[i].translation.head<2>().norm() < 1e-6);
  }
  CHECK(result.deepest < 0.02);
  CHECK(result.last.kinetic_energy < 1e-3);
}

TEST_CASE("response: stacks come to rest, whichever face their patches are cut by and wherever a disc is deepest") {
  Random random(91);
  const auto still_moving = [&random](const Shape& shape, double height, int high) {
    Scene scene;
    add_ground(scene);
    for (int i = 0; i < high; ++i) {
      const auto any = [&](double most) { return random.uniform(-most, most); };
      const Mat3 lean = Eigen::AngleAxisd(any(0.01), Vec3::UnitX()).toRotationMatrix();
      add(scene, shape,
          {Eigen::AngleAxisd(any(M_PI), Vec3::UnitZ()) * lean,
           Vec3{any(0.05), any(0.05), i * (height + 0.01) + 0.5 * height + 0.01}});
    }
    Response response;
    return run(scene, response, 600, recommended_margin(scene)).last.kinetic_energy;
  };
  int at_rest = 0;
  for (int i = 0; i < 12; ++i) at_rest += still_moving(Shape(Box{{0.8, 0.8, 0.8}}), 0.8, 2) < 1e-6 ? 1 : 0;
  CHECK(at_rest >= 9);
  std::vector<double> of_cans;
  for (int i = 0; i < 9; ++i) of_cans.push_back(still_moving(Shape(Cylinder{0.5, 1}), 1, 4));
  std::sort(of_cans.begin(), of_cans.end());
  CHECK(of_cans[6] < 1e-3);  // with 3 tons: a millimetre a second
}

TEST_CASE("response: a gap stops a fast body before it touches") {
  Scene scene;
  scene.gravity.setZero();
  add_ground(scene);
  const BodyId box = add(scene, Shape(Box{{1, 1, 1}}), Pose::at(0, 0, 0.55));
  scene.set_velocity(box, {0, 0, -6}, Vec3::Zero());
  Response response;
  const Run result = run(scene, response, 2);
  CHECK(result.deepest < 2e-3);  // 0.1 m a step without a margin
  CHECK(scene.pose(box).translation.z() == Approx(0.5).margin(5e-3));
}

TEST_CASE("response: overlap is undone slowly, without a leap") {
  Scene scene;
  add_ground(scene);
  const BodyId box = add(scene, Shape(Box{{1, 1, 1}}), Pose::at(0, 0, 0.2));
  Response response;
  double fastest = 0;
  for (int i = 0; i < 120; ++i) {
    run(scene, response, 1);
    fastest = std::max(fastest, scene.velocities()[1].z());
  }
  CHECK(scene.pose(box).translation.z() == Approx(0.5).margin(0.01));
  CHECK(fastest < 0.5);
}

TEST_CASE("response: what collides in free space keeps its momentum and gains no energy") {
  Scene scene;
  scene.gravity.setZero();
  Random random(5);
  for (int i = 0; i < 12; ++i) {
    Pose pose = Pose::at(i % 3 * 1.4, i / 3 % 2 * 1.4, i / 6 * 1.4);
    pose.rotation = random.rotation();
    const BodyId id = i % 2 == 0 ? add(scene, Shape(Box{{1, 0.7, 0.5}}), pose) : add(scene, Shape(Sphere{0.5}), pose);
    const Vec3 inwards = Vec3(1.4, 0.7, 0.7) - pose.translation;
    scene.set_velocity(id, 2 * inwards, {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
  }
  const Momenta before = momenta(scene);
  Response response;
  std::size_t contacts = 0;
  for (int i = 0; i < 120; ++i) {
    const ContactList list = detect(scene, 0.05);
    contacts += list.contacts.size();
    response.step(scene, list);
  }
  const Momenta after = momenta(scene);
  const double scale = before.linear.norm() + std::sqrt(before.energy * 1000);
  CHECK(contacts > 200);
  CHECK((after.linear - before.linear).norm() < 1e-9 * scale);
  // Contact arms are those of the beginning of the step: the angular momentum is conserved except for the motion within
  // a step.
  CHECK((after.angular - before.angular).norm() < 0.02 * scale);
  CHECK(after.energy < before.energy);
  CHECK(after.energy < 0.7 * before.energy);
}

TEST_CASE("response: a body turning freely keeps its angular momentum and nearly its energy") {
  Scene scene;
  scene.gravity.setZero();
  const BodyId box = add(scene, Shape(Box{{1, 0.6, 0.2}}), {});
  scene.set_velocity(box, Vec3::Zero(), {0.1, 3, 0.1});  // about the intermediate axis: it tumbles
  const Momenta before = momenta(scene);
  Response response;
  double most = 0, least = 1e300, lowest_y = 1;
  for (int i = 0; i < 600; ++i) {
    response.step(scene, {});
    const Momenta now = momenta(scene);
    REQUIRE((now.angular - before.angular).norm() < 1e-9 * before.angular.norm());
    most = std::max(most, now.energy);
    least = std::min(least, now.energy);
    lowest_y = std::min(lowest_y, scene.pose(box).rotation(1, 1));
  }
  CHECK(lowest_y < -0.5);  // it did tumble
  CHECK(most < 1.1 * before.energy);
  CHECK(least > 0.9 * before.energy);
  CHECK(scene.pose(box).rotation.determinant() == Approx(1).epsilon(1e-12));
}

TEST_CASE("response: static bodies, and those without weight, stay where they are") {
  Scene scene;
  const BodyId wall = add(scene, Shape(Box{{1, 1, 1}}), {}, true);
  const BodyId point = add(scene, Shape(Sphere{0}), Pose::at(0, 0, 3));
  const BodyId ball = add(scene, Shape(Sphere{0.5}), Pose::at(0, 0, 0.9));
  Response response;
  run(scene, response, 100);
  CHECK(scene.pose(wall).translation == Vec3::Zero());
  CHECK(scene.pose(point).translation == Vec3(0, 0, 3));
  CHECK(scene.pose(ball).translation.allFinite());
}

TEST_CASE("response: speeds beyond all bounds stay finite") {
  Scene scene;
  const BodyId ball = add(scene, Shape(Sphere{0.5}), {});
  scene.set_velocity(ball, {1e308, -1e308, 0}, {1e308, 1e308, 1e308});
  Response response;
  run(scene, response, 10);
  CHECK(scene.velocities()[0].norm() == Approx(500));
  CHECK(scene.angular_velocities()[0].allFinite());
  CHECK(scene.pose(ball).rotation.allFinite());
}

TEST_CASE("response: the largest options and gravity leave bodies at finite places") {
  const auto moved = [](const ResponseOptions& options, double gravity, double speed, double dt = 1.0 / 60) {
    Scene scene;
    scene.dt = dt;
    scene.gravity = {0, 0, -gravity};
    scene.add_body({.shape = scene.add_shape(HalfSpace{{0, 0, 1}, 0}), .is_static = true});
    const ShapeId shapes[] = {scene.add_shape(Sphere{1}), scene.add_shape(Box{{1, 1, 1}})};
    for (int i = 0; i < 4; ++i)
      scene.add_body({.shape = shapes[i % 2],
                      .pose = Pose::at(0.1 * i, 0, 0.9 + i),
                      .velocity = {speed, 0, -speed},
                      .angular_velocity = {speed, 0, 0}});
    Response response(options);
    for (int step = 0; step < 4; ++step) {
      const ResponseReport report = response.step(scene, detect(scene, 0.1));
      CHECK(std::isfinite(report.kinetic_energy));
    }
    for (std::uint32_t i = 1; i < scene.indices(); ++i) {
      CHECK(scene.poses()[i].translation.allFinite());
      CHECK(scene.poses()[i].rotation.allFinite());
      CHECK(scene.velocities()[i].allFinite());
    }
  };
  constexpr double most = 1e30;
  moved({}, most, 10);
  moved({}, 9.81, 10, 1e-300);
  moved({.max_push_out = 1.7e308, .max_speed = 1.7e308}, most, 1e308, 1e-300);
  moved({.max_speed = most}, most, 1e308);
  for (double ResponseOptions::*option :
       {&ResponseOptions::friction, &ResponseOptions::rolling_resistance, &ResponseOptions::contact_hertz,
        &ResponseOptions::contact_damping_ratio, &ResponseOptions::max_push_out, &ResponseOptions::max_speed}) {
    ResponseOptions options;
    options.*option = most;
    moved(options, 9.81, 10);
  }
}

TEST_CASE("response: needles, however thin, are not thrown away by contacts") {
  Random random(3);
  for (const double width : {1e-4, 1e-6, 1e-9, 1e-12, 1e-20}) {
    CAPTURE(width);
    for (const Shape& needle : {Shape(Cylinder{width, 1}), Shape(Box{{width, width, 1}}), Shape(Capsule{width, 1})}) {
      Scene scene;
      scene.add_body({.shape = scene.add_shape(HalfSpace{{0, 0, 1}, 0}), .is_static = true});
      const ShapeId shape = scene.add_shape(needle);
      for (int i = 0; i < 12; ++i) {
        const auto any = [&](double most) { return random.uniform(-most, most); };
        const Mat3 turned = random.rotation();
        const Vec3 place{any(0.3), any(0.3), random.uniform(0, 0.3)}, spin{any(3), any(3), any(3)};
        scene.add_body({.shape = shape, .pose = {turned, place}, .angular_velocity = spin});
      }
      Response response({.rolling_resistance = 0.3});
      for (int step = 0; step < 12; ++step) response.step(scene, detect(scene, 1e-3));
      for (std::uint32_t i = 1; i < scene.indices(); ++i) CHECK(scene.poses()[i].translation.norm() < 2);
    }
  }
}

TEST_CASE("response: huge and tiny bodies in contact stay at finite places") {
  for (const double radius : {1e-29, 1e-25, 1e-20, 1e-18, 1e-12, 1e-10, 1e10, 1e15, 1e18, 1e20, 1e22, 1e25, 1e29})
    for (const double density : {1e-300, 1e-60, 1e-30, 1e-20, 1.0, 1e3, 1e15, 1e30}) {
      CAPTURE(radius, density);
      Scene scene;
      scene.gravity.setZero();
      const ShapeId ball = scene.add_shape(Sphere{radius});
      scene.add_body({.shape = ball, .density = density});
      scene.add_body({.shape = ball, .pose = Pose::at(1e-5 * radius, 7e-6 * radius, 0), .density = density});
      Response response;
      for (int step = 0; step < 3; ++step) {
        CHECK(std::isfinite(response.step(scene, detect(scene, 0)).kinetic_energy));
        for (const Pose& pose : scene.poses()) REQUIRE(is_valid(pose));
      }
    }
}

TEST_CASE("response: a tiny body as deep in a half-space as can be stays at a finite place") {
  Scene scene;
  scene.add_body({.shape = scene.add_shape(HalfSpace{{0.6, 0, 0.8}, 1e30}), .is_static = true});
  scene.add_body({.shape = scene.add_shape(Cone{1e-20, 1e-20})});
  Response response;
  for (int step = 0; step < 3; ++step) {
    response.step(scene, detect(scene, 0));
    REQUIRE(is_valid(scene.poses()[1]));
    CHECK(scene.velocities()[1].allFinite());
  }
}

TEST_CASE("response: the same contacts make the same bits, and a pile comes to rest") {
  Scene one = pile_of_boxes(), two = pile_of_boxes();
  Response first, second;
  double peak = 0;
  Run result;
  for (int i = 0; i < 400; ++i) {
    result = run(one, first, 1);
    run(two, second, 1);
    peak = std::max(peak, result.last.kinetic_energy);
    REQUIRE(equal(one, two));
  }
  CHECK(result.last.kinetic_energy < 1e-3 * peak);
  for (std::uint32_t i = 1; i < one.indices(); ++i) CHECK(one.poses()[i].translation.z() > 0.25);
}

TEST_CASE("response: the motion is the same bits on any number of threads") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  Scene reference = make_builtin_scene("cubes-on-plane", 400);
  std::vector<Scene> scenes(3, reference);
  Pipeline pipeline({.answer = {.margin = recommended_margin(reference)}});
  Response alone({.threads = 1});
  std::vector<Response> responses;
  for (const int threads : {2, 3, 8}) responses.emplace_back(ResponseOptions{.threads = threads});
  std::uint64_t contacts = 0;
  for (int step = 0; step < 60; ++step) {
    contacts = pipeline.step(reference).contacts;
    const ResponseReport expected = alone.step(reference, pipeline.contacts());
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      CHECK(responses[i].step(scenes[i], pipeline.contacts()).kinetic_energy == expected.kinetic_energy);
      REQUIRE(equal(scenes[i], reference));
    }
  }
  CHECK(contacts > 1000);  // many blocks of pairs
}

TEST_CASE("response: bodies removed and added between steps do no harm") {
  Scene scene = pile_of_boxes();
  Response response;
  const Shape box(Box{{1, 1, 1}});
  const ShapeId shape = scene.add_shape(box);
  for (int i = 0; i < 100; ++i) {
    if (i % 5 == 0) {
      scene.remove_body(scene.id(static_cast<std::uint32_t>(1 + i % 7)));
      BodyOptions body;
      body.shape = shape;
      body.pose = Pose::at(i % 3, 0, 8);
      scene.add_body(body);
    }
    run(scene, response, 1);
  }
  for (std::uint32_t i = 0; i < scene.indices(); ++i) CHECK(scene.poses()[i].translation.allFinite());
}

TEST_CASE("response: a static body with a velocity is a conveyor, a sensor pushes nothing") {
  Scene scene;
  const ShapeId ground = scene.add_shape(HalfSpace{}), box = scene.add_shape(Box{{1, 1, 0.5}});
  const BodyId belt = scene.add_body({.shape = ground, .velocity = {0.8, 0, 0}, .is_static = true});
  const BodyId load = scene.add_body({.shape = box, .pose = Pose::at(0, 0, 0.25)});
  const BodyId falls = scene.add_body({.shape = box, .pose = Pose::at(5, 0, 0.25), .is_sensor = true});
  Pipeline pipeline({.threads = 1, .answer = {.margin = recommended_margin(scene)}});
  Response response;
  bool sensed = false;
  for (int i = 0; i < 120; ++i) {
    pipeline.step(scene);
    for (const PairResult& pair : pipeline.contacts().pairs)
      sensed = sensed || (pair.b == falls.index() && pair.answer.collide);
    response.step(scene, pipeline.contacts());
  }
  CHECK(std::abs(scene.velocities()[load.index()].x() - 0.8) < 1e-3);
  CHECK(scene.pose(load).translation.x() > 1);
  CHECK(std::abs(scene.pose(load).translation.z() - 0.25) < 0.01);
  CHECK(scene.pose(belt).translation.isZero(0));
  CHECK(sensed);
  CHECK(scene.pose(falls).translation.z() < -5);
}

TEST_CASE("a sum of energies does not depend on their order, and is exact") {
  std::mt19937_64 random(11);
  std::vector<double> numbers{0.0, 5e-324, 1e-310, 1e300, 3.0, 1.0};
  for (int i = 0; i < 2000; ++i)
    numbers.push_back(
        std::ldexp(std::uniform_real_distribution<double>(1, 2)(random), static_cast<int>(random() % 120)));
  const auto sum = [](std::span<const double> of) {
    ExactSum out;
    for (const double x : of) out.add(x);
    return out;
  };
  const double all = sum(numbers).value();
  for (int shuffle = 0; shuffle < 10; ++shuffle) {
    std::shuffle(numbers.begin(), numbers.end(), random);
    ExactSum halves = sum(std::span(numbers).first(700));
    halves.add(sum(std::span(numbers).subspan(700)));
    CHECK(halves.value() == all);
  }
  CHECK(sum(std::array{0x1p53, 1.0, 1.0}).value() == 0x1p53 + 2);  // added one after the other: 2^53
  CHECK(sum(std::array{5e-324, 5e-324}).value() == 1e-323);
  CHECK(sum(std::vector<double>(1000, 0x1p1000)).value() == 1000 * 0x1p1000);
  CHECK(std::isinf(sum(std::array{1.0, std::numeric_limits<double>::quiet_NaN()}).value()));
}

TEST_CASE("contacts of bodies that the scene does not have are refused, and nothing moves") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  std::vector<BodyId> bodies;
  for (const double x : {0.0, 1.5, 3.0})
    bodies.push_back(scene.add_body({.shape = ball, .pose = {Mat3::Identity(), {x, 0, 0}}}));
  const ContactList contacts = detect(scene, 0);
  REQUIRE(contacts.pairs.size() == 2);
  Scene other;
  other.add_body({.shape = other.add_shape(Sphere{1})});
  CHECK_THAT(message_of([&] { Response().step(other, contacts); }), Contains("body 1, which does not exist"));
  CHECK(other.velocities()[0].isZero(0));
  ContactList cut = contacts;
  cut.contacts.pop_back();
  CHECK_THAT(message_of([&] { Response().step(scene, cut); }), Contains("contacts that the list does not have"));
  scene.remove_body(bodies[2]);
  CHECK_THAT(message_of([&] { Response().step(scene, contacts); }), Contains("body 2, which does not exist"));
}

TEST_CASE("whatever bodies a scene takes, the response leaves poses that it takes") {
  for (const double density : {1e-300, 1e-200, 1e-100, 1e100, 1e300})
    for (const double speed : {0.0, 1e308}) {
      CAPTURE(density, speed);
      Scene scene;
      const ShapeId box = scene.add_shape(Box{{1, 1, 1}}), ball = scene.add_shape(Sphere{1});
      scene.add_body(
          {.shape = box, .velocity = {speed, speed, 0}, .angular_velocity = {speed, 0, speed}, .density = density});
      scene.add_body({.shape = ball, .pose = {Mat3::Identity(), {1.2, 0, 0}}});
      Response response;
      for (int step = 0; step < 3; ++step) response.step(scene, detect(scene, 0));
      for (std::uint32_t i = 0; i < scene.indices(); ++i) {
        CHECK(is_valid(scene.poses()[i]));
        CHECK(scene.velocities()[i].allFinite());
      }
    }
  Scene scene;
  scene.dt = 1e4;
  CHECK_THAT(message_of([&] { Response().step(scene, {}); }), Contains("dt is 10000, allowed: > 0, at most 1000 s"));
}
