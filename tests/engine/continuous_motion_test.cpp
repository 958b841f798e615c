// Continuous bodies do not pass through others: thousands of shots compared with samples, rooms full of bullets, and
// the rules of which body carries which.
#include "tandem/engine/continuous_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "catch.h"
#include "message_of.h"
#include "narrowphase/mesh_samples.h"
#include "narrowphase/random_pairs.h"
#include "tandem/engine/contact_memory.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"

using namespace tandem;
using namespace tandem::test;
using Catch::Matchers::Contains;

namespace {

const NarrowPhase narrow;

bool same(const Pose& a, const Pose& b) { return a.translation == b.translation && a.rotation == b.rotation; }

/// The pose of a body whose given point moves straight while it rotates; independent of the library's.
Pose in_between(const Pose& from, const Pose& to, const Vec3& centre, double t) {
  Pose at;
  at.rotation = Quat(from.rotation).slerp(t, Quat(to.rotation)).toRotationMatrix();
  at.translation = (1 - t) * (from * centre) + t * (to * centre) - at.rotation * centre;
  return at;
}

Vec3 centre_of(const Scene& scene, std::uint32_t i) {
  return scene.is_static()[i] ? Vec3(Vec3::Zero()) : scene.shape_of(i).mass().centre;
}

double distance(const Scene& scene, std::uint32_t a, const Pose& at_a, std::uint32_t b, const Pose& at_b) {
  return narrow.solve(scene.shape_of(a), at_a, scene.shape_of(b), at_b, Request::distance).signed_distance;
}

bool collide(const Scene& scene, std::uint32_t a, const Pose& at_a, std::uint32_t b, const Pose& at_b) {
  return narrow.solve(scene.shape_of(a), at_a, scene.shape_of(b), at_b, Request::collide).collide;
}

/// A body about 30 in size, thin if possible, at `at` after the fraction `f` of the step.
BodyOptions target(Scene& scene, int kind, const Vec3& at, double f, Random& r) {
  BodyOptions body{.pose = Pose{r.rotation(), at}, .is_static = true};
  const auto moves = [&](const Vec3& shift) {
    body.velocity = shift;
    body.pose.translation -= f * shift;
  };
  const auto shift_of_any_order = [&]() -> Vec3 {
    const double length = std::pow(10, r.in(0, 3));
    return length * r.direction();
  };
  switch (kind) {
    case 0:
      body.shape = scene.add_shape(Box{{30, 20, 0.001}});
      break;
    case 1:
      body.shape = scene.add_shape(Triangle{{Vec3(-15, -9, 0), Vec3(15, -9, 0), Vec3(0, 18, 0)}});
      break;
    case 2:
      body.shape = scene.add_shape(Shape(box_mesh({30, 20, 0.01}, 4)));
      break;
    case 3:
      body.pose.translation.setZero();
      body.shape =
          scene.add_shape(HalfSpace{body.pose.rotation.col(0), body.pose.rotation.col(0).dot(body.pose.rotation * at)});
      body.pose.translation = Vec3::Zero();
      break;
    case 4:
      body.shape = scene.add_shape(Box{{0.2, 0.1, 40}});
      body.angular_velocity = r.vec_of_length(0.1, 2.5);
      moves(r.vec_of_length(0, 3));
      break;
    case 5:
      body.shape = scene.add_shape(Box{{30, 20, 0.001}});
      moves(shift_of_any_order());
      break;
    default:
      body.shape = scene.add_shape(random_shape(bounded_convex[kind % 7], r));
      body.is_static = false;
      body.continuous = kind % 2 == 0;
      body.angular_velocity = r.vec_of_length(0, 2);
      moves(shift_of_any_order());
  }
  return body;
}

struct Seen {
  int stopped = 0, free = 0, passes = 0;
};

/// One step of a scene of two bodies, checked at many sampled times.
void look_at_step(const Scene& scene, Seen& seen) {
  const std::uint32_t bullet = 0, other = 1;
  std::vector<Pose> whole;
  free_ends(scene, whole);
  std::vector<Pose> ends = whole;
  ContinuousMotion motion;
  const auto stops = motion.limit(scene, ends);
  const Pose start = scene.poses()[bullet], other_start = scene.poses()[other];
  const auto path = [&](std::uint32_t i, double t) {
    return in_between(scene.poses()[i], whole[i], centre_of(scene, i), t);
  };
  const double shift =
      (whole[0].translation - start.translation).norm() + (whole[1].translation - other_start.translation).norm();
  const double until = stops.empty() ? 1 : stops[0].t;
  const auto samples = static_cast<int>(shift / 0.15) + 20;
  bool would_pass = false;
  for (int k = 0; k <= samples; ++k) {
    const double t = static_cast<double>(k) / samples;
    if (!collide(scene, bullet, path(bullet, t), other, path(other, t))) continue;
    would_pass = true;
    if (t < until) CHECK(distance(scene, bullet, path(bullet, t), other, path(other, t)) > -1e-9 * shift);
  }
  seen.passes += would_pass ? 1 : 0;
  if (stops.empty()) {
    ++seen.free;
    CHECK_FALSE(would_pass);
    CHECK(same(ends[bullet], whole[bullet]));
    return;
  }
  ++seen.stopped;
  REQUIRE(stops.size() == 1);
  CHECK(stops[0].a.index() == 0);
  CHECK(stops[0].b.index() == 1);
  // It touches, and keeps its pose relative to the other body.
  CHECK(std::abs(distance(scene, bullet, path(bullet, until), other, path(other, until))) < 2e-9 * shift);
  CHECK(std::abs(distance(scene, bullet, ends[bullet], other, ends[other])) < 2e-9 * shift);
  if (scene.is_static()[other]) {
    const Pose then = path(other, until), at = path(bullet, until);
    const Vec3 seen_then = then.rotation.transpose() * (at.translation - then.translation);
    const Vec3 seen_last = ends[other].rotation.transpose() * (ends[bullet].translation - ends[other].translation);
    CHECK((seen_then - seen_last).norm() < 1e-10 * (shift + 40));
    CHECK(same(ends[other], whole[other]));
  }
}

/// Bodies that fly in a room of thin walls, which none may leave.
struct Room {
  static constexpr double half = 5;
  Scene scene;
  std::vector<BodyId> bullets;

  explicit Room(Random& r, int count, double fastest) {
    scene.gravity.setZero();
    scene.dt = 1.0 / 60;
    for (int k = 0; k < 3; ++k)
      for (const double side : {-half, half}) {
        Vec3 size = Vec3::Constant(2 * half + 1);
        size[k] = 0.002;
        const Vec3 at = side * Vec3::Unit(k);
        const ShapeId wall = k == 2 ? scene.add_shape(Shape(box_mesh(size, 3))) : scene.add_shape(Box{size});
        scene.add_body({.shape = wall, .pose = Pose::at(at[0], at[1], at[2]), .is_static = true});
      }
    for (int i = 0; i < count; ++i) {
      BodyOptions body;
      switch (i % 5) {
        case 0:
          body.shape = scene.add_shape(Sphere{0.1});
          break;
        case 1:
          body.shape = scene.add_shape(Box{{0.3, 0.05, 0.05}});
          break;
        case 2:
          body.shape = scene.add_shape(Cylinder{0.1, 0.3});
          break;
        case 3:
          body.shape = scene.add_shape(Shape(torus(0.15, 0.05, 8, 4)));
          break;
        default:
          body.shape = scene.add_shape(Capsule{0.05, 0.2});
      }
      const auto place = [&](int k) { return (k - 1.5) * 2; };
      body.pose = {r.rotation(), Vec3(place(i % 4), place(i / 4 % 4), place(i / 16 % 4))};
      body.velocity = fastest * r.vec_of_length(0.1, 1);
      body.angular_velocity = r.vec_of_length(0, 60);
      body.continuous = true;
      bullets.push_back(scene.add_body(body));
    }
  }

  /// The id of a body outside, or 0: by its centre; for rings, whose cores are in their tubes, by all of it.
  std::uint32_t outside() const {
    for (const BodyId id : bullets) {
      const Shape& shape = scene.shape_of(id.index());
      const Pose& pose = scene.pose(id);
      const Bounds bounds =
          shape.kind() == ShapeKind::mesh ? shape.bounds(pose) : Bounds{pose.translation, pose.translation};
      if (!(bounds.lo.maxCoeff() < half && bounds.hi.minCoeff() > -half)) return id.index();
    }
    return 0;
  }
};

/// A hash of the motion of all bodies.
std::uint64_t bits_of(const Scene& scene) {
  std::uint64_t hash = 1469598103934665603u;
  for (const Pose& pose : scene.poses()) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(&pose);
    for (std::size_t i = 0; i < sizeof(Pose); ++i) hash = (hash ^ bytes[i]) * 1099511628211u;
  }
  return hash;
}

/// A surface: a floor whose upper side is at 0.25, and a wall across it at x = 3.
Shape floor_with_wall() {
  Mesh mesh = box_mesh({40, 40, 0.5});
  mesh.solid = false;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3& corner : {Vec3(3, -20, 0), Vec3(3, 20, 0), Vec3(3, 20, 5), Vec3(3, -20, 5)})
    mesh.vertices.push_back(corner);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  return Shape(mesh);
}

}  // namespace

TEST_CASE("continuous: thousands of shots at thin things that stand, turn and move, held against samples") {
  Random r(29);
  Seen seen;
  constexpr int targets = 14;
  for (int i = 0; i < 1680; ++i) {
    Scene scene;
    scene.dt = 1;
    const int kind = i % targets;
    CAPTURE(i, kind);
    const double length = std::pow(10, r.in(1, 3));
    const Vec3 shift = length * r.direction(), at = r.vec(-50, 50);
    const double f = r.in(0.1, 1.1);
    const auto body_kind = i / targets % 8;
    BodyOptions bullet{.shape = scene.add_shape(body_kind == 7 ? Shape(torus(0.5, 0.15, 9, 5))
                                                               : random_shape(bounded_convex[body_kind], r)),
                       .pose = Pose{r.rotation(), at - f * shift + r.vec(-2, 2)},
                       .velocity = shift,
                       .angular_velocity = i % 3 == 0 ? Vec3(Vec3::Zero()) : Vec3(r.vec_of_length(0, 2.5)),
                       .continuous = true};
    scene.add_body(bullet);
    scene.add_body(target(scene, kind, at, std::min(f, 1.0), r));
    if (collide(scene, 0, scene.poses()[0], 1, scene.poses()[1])) continue;
    look_at_step(scene, seen);
  }
  CHECK(seen.stopped > 600);
  CHECK(seen.free > 200);
  CHECK(seen.passes > 600);
}

TEST_CASE("continuous: no bullet leaves a room of thin walls and meshes, whatever it meets there") {
  Random r(5);
  Room room(r, 40, 3000);  // up to 50 m a step
  // A paddle in the middle, rotated by its owner.
  const BodyId paddle = room.scene.add_body(
      {.shape = room.scene.add_shape(Box{{2, 0.01, 2}}), .angular_velocity = {0, 0, 40}, .is_static = true});
  ContinuousMotion motion;
  std::vector<Pose> ends;
  std::size_t stops = 0, moved = 0;
  for (int step = 0; step < 150; ++step) {
    free_ends(room.scene, ends);
    const auto found = motion.limit(room.scene, ends);
    stops += found.size();
    CHECK(std::is_sorted(found.begin(), found.end(), [](const auto& x, const auto& y) { return x.t < y.t; }));
    for (const BodyId id : room.bullets) {
      moved += same(ends[id.index()], room.scene.pose(id)) ? 0 : 1;
      room.scene.set_pose(id, ends[id.index()]);
    }
    room.scene.set_pose(paddle, ends[paddle.index()]);
    CAPTURE(step);
    REQUIRE(room.outside() == 0);
    // Away from what it hit, into the room.
    for (const MotionStop& stop : found)
      for (const auto& [id, away] : {std::pair(stop.a, -1.0), std::pair(stop.b, 1.0)}) {
        if (room.scene.is_static()[id.index()]) continue;
        const Vec3 out = away * stop.normal + 0.9 * r.direction();
        const double speed = r.in(100, 3000);
        room.scene.set_velocity(id, speed * out.normalized(), r.vec_of_length(0, 60));
      }
  }
  CHECK(stops > 3000);
  CHECK(moved > 3000);
}

TEST_CASE("continuous: a response keeps bullets in, the same bits with every executor and number of threads") {
  std::uint64_t bits = 0;
  for (const ExecutorKind executor : executor_kinds)
    for (const int threads : {1, 3}) {
      if (executor != ExecutorKind::flowgraph && threads == 1) continue;
      Random r(8);
      Room room(r, 20, 1500);
      Pipeline pipeline({.executor = executor, .threads = threads});  // no margin: nothing is found before it touches
      Response response({.max_speed = 3000, .threads = threads});
      std::size_t stops = 0;
      for (int step = 0; step < 40; ++step) {
        CAPTURE(step);
        pipeline.step(room.scene);
        stops += response.step(room.scene, pipeline.contacts()).stops;
        REQUIRE(room.outside() == 0);
      }
      CHECK(stops > 20);
      // Stopped bodies were also slowed: none approaches a wall for ever.
      double fastest = 0;
      for (const BodyId id : room.bullets) fastest = std::max(fastest, room.scene.velocities()[id.index()].norm());
      CHECK(fastest < 1500);
      if (bits == 0) bits = bits_of(room.scene);
      CHECK(bits_of(room.scene) == bits);
    }
}

TEST_CASE("continuous: without the flag the same bullets leave") {
  Random r(8);
  Room room(r, 30, 1500);
  for (const BodyId id : room.bullets) room.scene.set_continuous(id, false);
  CHECK_FALSE(room.scene.has_continuous());
  Pipeline pipeline({.threads = 1});
  Response response({.max_speed = 3000, .threads = 1});
  for (int step = 0; step < 5; ++step) {
    pipeline.step(room.scene);
    CHECK(response.step(room.scene, pipeline.contacts()).stops == 0);
  }
  CHECK(room.outside() != 0);
}

TEST_CASE("continuous: two bullets head-on stand, what moves takes along, and one that stands is picked up") {
  Scene scene;
  scene.dt = 1;
  const ShapeId ball = scene.add_shape(Sphere{0.5}), plate = scene.add_shape(Box{{0.001, 10, 10}});
  const auto shoot = [&](double x, double speed) {
    return scene.add_body({.shape = ball, .pose = Pose::at(x, 0, 0), .velocity = {speed, 0, 0}, .continuous = true});
  };
  const BodyId left = shoot(-100, 199.5), right = shoot(100, -199.5);
  std::vector<Pose> ends;
  ContinuousMotion motion;
  free_ends(scene, ends);
  auto stops = motion.limit(scene, ends);
  REQUIRE(stops.size() == 1);
  CHECK(stops[0].t == Approx(0.49874686716791977));
  CHECK(ends[left.index()].translation.x() == Approx(-0.5));
  CHECK(ends[right.index()].translation.x() == Approx(0.5));
  CHECK(stops[0].normal.x() == Approx(1));

  SECTION("a wall comes after them") {
    const BodyId wall =
        scene.add_body({.shape = plate, .pose = Pose::at(-201, 0, 0), .velocity = {300, 0, 0}, .is_static = true});
    free_ends(scene, ends);
    stops = motion.limit(scene, ends);
    // It carries the first body, and that one, which touches it, the other: their cores do not overlap.
    REQUIRE(stops.size() == 3);
    CHECK(stops[1].b == wall);
    CHECK(ends[left.index()].translation.x() == Approx(99 + 0.0005 + 0.5));
    CHECK(ends[right.index()].translation.x() == Approx(99 + 0.0005 + 1.25));
  }
  SECTION("a wall moves off: it is followed, and reached") {
    scene.remove_body(right);
    scene.add_body({.shape = plate, .pose = Pose::at(-50, 0, 0), .velocity = {100, 0, 0}, .is_static = true});
    free_ends(scene, ends);
    stops = motion.limit(scene, ends);
    REQUIRE(stops.size() == 1);
    CHECK(stops[0].t == Approx((50 - 0.5005) / 99.5));
    CHECK(ends[left.index()].translation.x() == Approx(50 - 0.5005));
  }
  SECTION("one that does not move is hit by a wall, though it is not fast") {
    scene.remove_body(right);
    scene.set_velocity(left, Vec3::Zero(), Vec3::Zero());
    scene.add_body({.shape = plate, .pose = Pose::at(-50, 0, 0), .velocity = {-300, 0, 0}, .is_static = true});
    free_ends(scene, ends);
    CHECK(motion.limit(scene, ends).size() == 1);
    CHECK(ends[left.index()].translation.x() == Approx(-350.5005));
  }
  SECTION("sensors, other groups and pairs that a predicate drops stop nothing") {
    scene.remove_body(right);
    const BodyId wall = scene.add_body({.shape = plate, .is_static = true});
    free_ends(scene, ends);
    CHECK(motion.limit(scene, ends).size() == 1);
    ContinuousMotion dropped([](std::span<Pair>) { return std::size_t{0}; });
    free_ends(scene, ends);
    CHECK(dropped.limit(scene, ends).empty());
    scene.set_filter(wall, 2, 2);
    CHECK(motion.limit(scene, ends).empty());
    scene.remove_body(wall);
    scene.add_body({.shape = plate, .is_static = true, .is_sensor = true});
    free_ends(scene, ends);
    CHECK(motion.limit(scene, ends).empty());
    CHECK(ends[left.index()].translation.x() == 99.5);
  }
}

TEST_CASE("continuous: what touches the floor at the start does not pass a wall of the same mesh") {
  Scene scene;
  scene.dt = 1;
  scene.add_body({.shape = scene.add_shape(floor_with_wall()), .is_static = true});
  const BodyId box = scene.add_body({.shape = scene.add_shape(Box{{1, 1, 1}}),
                                     .pose = Pose::at(-10, 0, 0.749),
                                     .velocity = {15, 0, 0},
                                     .continuous = true});
  std::vector<Pose> ends;
  ContinuousMotion motion;
  free_ends(scene, ends);
  REQUIRE(motion.limit(scene, ends).size() == 1);
  CHECK(ends[box.index()].translation.x() == Approx(3 - 0.25));  // its core is half of its inner radius
  // A motion parallel to the wall is not limited.
  scene.set_velocity(box, {0, 15, 0}, Vec3::Zero());
  free_ends(scene, ends);
  CHECK(motion.limit(scene, ends).empty());
  CHECK(ends[box.index()].translation.y() == 15);
}

TEST_CASE("continuous: what is stopped is seen by the next step, between meshes and without a margin, too") {
  Scene scene;
  scene.gravity.setZero();
  scene.add_body({.shape = scene.add_shape(Shape(box_mesh({0.01, 10, 10}, 3))), .is_static = true});
  const BodyId ring = scene.add_body({.shape = scene.add_shape(Shape(torus(0.5, 0.15, 12, 6))),
                                      .pose = Pose::at(-20, 0, 0),
                                      .velocity = {400, 0, 0},
                                      .continuous = true});
  Pipeline pipeline({.threads = 1});
  Response response({.threads = 1});
  for (int i = 0; i < 6; ++i) {
    pipeline.step(scene);
    response.step(scene, pipeline.contacts());
  }
  CHECK(scene.pose(ring).translation.x() < -0.1);
  CHECK(scene.velocities()[ring.index()].x() < 1e-6);
}

TEST_CASE("continuous: thin plates come to rest whatever the margin, however they fall") {
  const auto drop = [](const Shape& ground, double share_of_margin, double tilt) {
    Scene scene;
    scene.add_body({.shape = scene.add_shape(ground), .pose = Pose::at(0, 0, -0.5), .is_static = true});
    const Pose pose{Eigen::AngleAxisd(tilt, Vec3(1, 0.3, 0).normalized()).toRotationMatrix(), Vec3(0, 0, 0.5)};
    const ShapeId plate = scene.add_shape(Box{{1, 1, 0.01}});
    const BodyId body = scene.add_body({.shape = plate, .pose = pose, .continuous = true});
    Pipeline pipeline({.threads = 1, .answer = {.margin = share_of_margin * recommended_margin(scene)}});
    Response response({.threads = 1});
    double fastest = 0;  // of the last half second
    for (int i = 0; i < 300; ++i) {
      pipeline.step(scene);
      response.step(scene, pipeline.contacts());
      if (i >= 270) fastest = std::max(fastest, scene.velocities()[body.index()].norm());
    }
    CAPTURE(name(ground.kind()), share_of_margin, tilt);
    CHECK(fastest < 1e-3);
    const Bounds bounds = scene.shape_of(body.index()).bounds(scene.pose(body));
    CHECK(bounds.lo.z() > -0.001);
    CHECK(bounds.hi.z() < 0.0105);
  };
  for (const Shape& ground : {Shape(Box{{20, 20, 1}}), Shape(HalfSpace{Vec3::UnitZ(), 0.5})})
    for (const double share : {0.0, 0.01, 0.1, 0.5})
      for (const double tilt : {0.0, 0.05, 0.3, 0.7, 1.1, 1.5}) drop(ground, share, tilt);
}

TEST_CASE("continuous: contacts of stops join a list in its order") {
  Scene scene;
  scene.gravity.setZero();
  scene.add_body({.shape = scene.add_shape(Box{{20, 20, 1}}), .pose = Pose::at(0, 0, -0.5), .is_static = true});
  const ShapeId plate = scene.add_shape(Box{{1, 1, 0.01}});
  const Mat3 tilted = Eigen::AngleAxisd(0.1, Vec3(1, 0.3, 0).normalized()).toRotationMatrix();
  for (int i = 0; i < 3; ++i)  // the first is stopped above the ground, then pressed into it
    scene.add_body({.shape = plate,
                    .pose = {tilted, Vec3(3 * i, 0, i == 0 ? 0.1 : 0.005)},
                    .velocity = {0, 0, -10},
                    .continuous = i != 1});
  Pipeline pipeline({.threads = 1});
  ContinuousMotion motion;
  ContactMap<int> map(0.1);
  std::vector<Pose> ends;
  std::size_t added = 0, kept = 0;
  for (int i = 0; i < 5; ++i) {
    pipeline.step(scene);
    ContactList list = pipeline.contacts();
    motion.add_contacts(scene, list);
    added += list.contacts.size() - pipeline.contacts().contacts.size();
    std::uint32_t next = 0;
    for (const PairResult& pair : list.pairs) {
      CHECK(pair.first_contact == next);
      next += pair.contact_count;
      const auto its = list.of(pair);
      CHECK(std::is_sorted(its.begin(), its.end(), [](const auto& x, const auto& y) { return x.feature < y.feature; }));
    }
    CHECK(next == list.contacts.size());
    map.update(scene, list);
    for (std::size_t k = 0; k < map.size(); ++k) {
      kept += map[k] != 0 ? 1 : 0;
      map[k] = 1;
    }
    free_ends(scene, ends);
    motion.limit(scene, ends);
    for (const std::uint32_t body : {1u, 3u}) scene.set_pose(scene.id(body), ends[body]);
  }
  CHECK(added >= 5);
  CHECK(kept >= 5);
}

TEST_CASE("continuous: bodies thinner than contacts yield rest, on grounds without an inside, too") {
  Mesh sheet;
  for (const Vec3& corner : {Vec3(-9, -9, 0), Vec3(9, -9, 0), Vec3(9, 9, 0), Vec3(-9, 9, 0)})
    sheet.vertices.push_back(corner);
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto drop = [](const Shape& ground, const Shape& shape, double share_of_margin, double tilt) {
    Scene scene;
    const double depth = ground.bounds(Pose{}).hi.z();
    scene.add_body({.shape = scene.add_shape(ground), .pose = Pose::at(0, 0, -depth), .is_static = true});
    const Pose pose{Eigen::AngleAxisd(tilt, Vec3(1, 0.3, 0).normalized()).toRotationMatrix(), Vec3(0, 0, 0.8)};
    const BodyId body = scene.add_body({.shape = scene.add_shape(shape), .pose = pose, .continuous = true});
    Pipeline pipeline({.threads = 1, .answer = {.margin = share_of_margin * recommended_margin(scene)}});
    Response response({.threads = 1});
    for (int i = 0; i < 600; ++i) {
      pipeline.step(scene);
      response.step(scene, pipeline.contacts());
    }
    CAPTURE(name(ground.kind()), name(shape.kind()), share_of_margin, tilt);
    CHECK(scene.velocities()[body.index()].norm() < 0.1);
    const Bounds bounds = scene.shape_of(body.index()).bounds(scene.pose(body));
    CHECK(scene.pose(body).translation.z() > 0);
    CHECK(bounds.lo.z() > -0.004);
    CHECK(bounds.hi.z() < 0.008);
  };
  for (const Shape& ground : {Shape(Box{{18, 18, 1}}), Shape(Box{{18, 18, 0.01}}), Shape(sheet)})
    for (const Shape& shape :
         {Shape(Box{{1, 0.7, 5e-4}}), Shape(Cylinder{0.4, 6e-4}), Shape(box_mesh({0.9, 0.6, 4e-4}, 2))})
      for (const double share : {0.0, 1.0})
        for (const double tilt : {0.2, 0.9}) drop(ground, shape, share, tilt);
}

TEST_CASE("continuous: a core that is pressed into a floor slides and turns on, but not through a wall of its mesh") {
  Scene scene;
  scene.dt = 1;
  scene.gravity.setZero();
  scene.add_body({.shape = scene.add_shape(floor_with_wall()), .is_static = true});
  // The centre 0.2 above the floor: its core has a radius of 0.25.
  const BodyId box = scene.add_body({.shape = scene.add_shape(Box{{1, 1, 1}}),
                                     .pose = Pose::at(-10, 0, 0.45),
                                     .velocity = {5, 0, -0.3},
                                     .angular_velocity = {0, 0.4, 0},
                                     .continuous = true});
  std::vector<Pose> ends;
  ContinuousMotion motion;
  free_ends(scene, ends);
  const Pose free = ends[box.index()];
  REQUIRE(motion.limit(scene, ends).size() == 1);
  CHECK(ends[box.index()].translation.x() == Approx(-5));
  CHECK(std::abs(ends[box.index()].translation.z() - 0.45) < 1e-8);
  CHECK((ends[box.index()].rotation - free.rotation).norm() < 1e-12);
  scene.set_velocity(box, {50, 0, -0.3}, {0, 0.4, 0});
  free_ends(scene, ends);
  CHECK(motion.limit(scene, ends).size() >= 2);
  CHECK(ends[box.index()].translation.x() == Approx(3 - 0.2));
  CHECK(std::abs(ends[box.index()].translation.z() - 0.45) < 1e-9 * 50);
}

TEST_CASE("continuous: slow bodies move as they do without the flag") {
  const auto drop = [](bool continuous) {
    Scene scene;
    scene.add_body({.shape = scene.add_shape(HalfSpace{}), .is_static = true});
    const ShapeId box = scene.add_shape(Box{{1, 0.8, 0.6}});
    for (int i = 0; i < 6; ++i)
      scene.add_body({.shape = box, .pose = Pose::at(0.1 * i, 0, 0.4 + 0.7 * i), .continuous = continuous});
    Pipeline pipeline({.threads = 1, .answer = {.margin = recommended_margin(scene)}});
    Response response({.threads = 1});
    for (int i = 0; i < 60; ++i) {
      pipeline.step(scene);
      CHECK(response.step(scene, pipeline.contacts()).stops == 0);
    }
    return bits_of(scene);
  };
  CHECK(drop(true) == drop(false));
}

TEST_CASE("continuous: ends that are no poses are refused") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  scene.add_body({.shape = ball, .continuous = true});
  ContinuousMotion motion;
  std::vector<Pose> ends;
  CHECK_THAT(message_of([&] { motion.limit(scene, ends); }), Contains("ends: 0, allowed: 1"));
  ends.resize(1);
  ends[0].translation.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(message_of([&] { motion.limit(scene, ends); }), Contains("ends: body 0"));
}

TEST_CASE("scene: how many bodies are continuous is known through all changes") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  const BodyId a = scene.add_body({.shape = ball, .continuous = true}), b = scene.add_body({.shape = ball});
  CHECK(scene.has_continuous());
  scene.set_continuous(a, false);
  scene.set_continuous(a, false);
  CHECK_FALSE(scene.has_continuous());
  scene.set_continuous(b, true);
  scene.set_continuous(b, true);
  CHECK(scene.continuous()[b.index()] == 1);
  scene.remove_body(b);
  CHECK_FALSE(scene.has_continuous());
  CHECK_THROWS_AS(scene.set_continuous(b, true), std::invalid_argument);
  const BodyId c = scene.add_body({.shape = ball});
  CHECK(c.index() == b.index());
  CHECK_FALSE(scene.has_continuous());
}

TEST_CASE("continuous: free ends that no pose may have are refused, by body") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{0.5});
  std::vector<Pose> ends;
  SECTION("it flies too far") {
    scene.add_body({.shape = ball});
    scene.add_body({.shape = ball, .velocity = {0, 1e300, 0}});
    CHECK_THROWS_WITH(free_ends(scene, ends),
                      Catch::Contains("body 1 after dt") && Catch::Contains("translation[1] is"));
  }
  SECTION("it spins too fast") {
    scene.add_body({.shape = ball, .angular_velocity = {0, 0, 1e300}});
    CHECK_THROWS_AS(free_ends(scene, ends), std::invalid_argument);
  }
  SECTION("at the largest coordinates it is let be") {
    scene.dt = 1;
    scene.add_body({.shape = ball, .velocity = {1e29, 0, 0}});
    free_ends(scene, ends);
    CHECK(ends[0].translation.x() == 1e29);
    ContinuousMotion().limit(scene, ends);
  }
}
