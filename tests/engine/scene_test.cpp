// Scenes: bodies, shapes, changes, memory.
#include "tandem/engine/scene.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "catch.h"
#include "message_of.h"
#include "narrowphase/mesh_samples.h"
#include "scene/scene_changes.h"

using namespace tandem;
using Catch::Matchers::Contains;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

struct Fixture {
  Scene scene;
  ShapeId ball = scene.add_shape(Shape(Sphere{1}), "ball");
  ShapeId ground = scene.add_shape(Shape(HalfSpace{}), "ground");

  BodyOptions body() const {
    BodyOptions options;
    options.shape = ball;
    return options;
  }
  std::string refusal(const BodyOptions& options) {
    const std::size_t before = scene.bodies();
    CHECK_THROWS_AS(scene.add_body(options), std::invalid_argument);
    const std::string message = message_of([&] { scene.add_body(options); });
    CHECK(scene.bodies() == before);
    CHECK(scene.indices() == before);
    return message;
  }
};

}  // namespace

TEST_CASE("scene: a body that cannot be is refused with its number, field and value") {
  Fixture f;
  f.scene.add_body(f.body());
  BodyOptions bad = f.body();
  SECTION("no shape") {
    bad.shape = {};
    CHECK_THAT(f.refusal(bad), Contains("body 1") && Contains("shape"));
  }
  SECTION("a shape of nobody") {
    bad.shape = {3};
    CHECK_THAT(f.refusal(bad), Contains("body 1") && Contains("shape") && Contains("3"));
  }
  SECTION("a position that is no number") {
    bad.pose.translation.y() = not_a_number;
    CHECK_THAT(f.refusal(bad), Contains("body 1") && Contains("nan"));
  }
  SECTION("a rotation that mirrors") {
    bad.pose.rotation = Vec3(1, 1, -1).asDiagonal();
    CHECK_THAT(f.refusal(bad), Contains("body 1") && Contains("rotation"));
  }
  SECTION("a rotation that stretches") {
    bad.pose.rotation *= 1.00001;
    CHECK_THAT(f.refusal(bad), Contains("body 1") && Contains("rotation"));
  }
  SECTION("velocity") {
    bad.velocity.x() = infinite;
    CHECK_THAT(f.refusal(bad), Contains("body 1: velocity") && Contains("inf"));
  }
  SECTION("angular velocity") {
    bad.angular_velocity.z() = not_a_number;
    CHECK_THAT(f.refusal(bad), Contains("body 1: angular_velocity") && Contains("nan"));
  }
  SECTION("density") {
    for (const double density : {0.0, -1.0, not_a_number, infinite}) {
      bad.density = density;
      CHECK_THAT(f.refusal(bad), Contains("body 1: density") && Contains("> 0"));
    }
  }
  SECTION("a half-space that moves") {
    bad.shape = f.ground;
    CHECK_THAT(f.refusal(bad), Contains("body 1: is_static") && Contains("half-space"));
  }
}

TEST_CASE("scene: a static body's density is not looked at, and a half-space may be one") {
  Fixture f;
  BodyOptions fixed = f.body();
  fixed.is_static = true;
  fixed.density = not_a_number;
  CHECK_NOTHROW(f.scene.add_body(fixed));
  fixed.shape = f.ground;
  CHECK_NOTHROW(f.scene.add_body(fixed));
  CHECK_NOTHROW(f.scene.add_body(fixed));
  CHECK_NOTHROW(f.scene.add_body(f.body()));
  CHECK(f.scene.bodies() == 4);
}

TEST_CASE(
    "scene: bodies of all kinds, fixed and moving, with a shape each, come and go; only half-spaces and planes may not "
    "move") {
  const auto point = [](double x, double y, double z) { return Vec3(x, y, z); };
  const std::vector<Vec3> corners = {point(0, 0, 0), point(1, 0, 0), point(0, 1, 0), point(0, 0, 1)};
  const std::vector<Shape> kinds = {Sphere{1},
                                    Box{{1, 1, 1}},
                                    Capsule{1, 1},
                                    Cylinder{1, 1},
                                    Cone{1, 1},
                                    Ellipsoid{{1, 2, 3}},
                                    HalfSpace{},
                                    Shape(Convex{corners}),
                                    Triangle{{corners[0], corners[1], corners[2]}},
                                    Shape(Mesh{corners, {{0, 1, 2}, {0, 1, 3}}}),
                                    Plane{},
                                    Shape(Voxels{{{{0, 0, 0}, 0}, {{1, 1, 0}, 0}}, 0.5})};
  REQUIRE(kinds.size() == shape_kinds);
  Scene scene;
  std::size_t bodies = 0;
  for (int round = 0; round < 3; ++round) {
    for (const bool is_static : {round != 1, round == 1})
      for (const Shape& shape : kinds) {
        const BodyOptions body{.shape = scene.add_shape(shape), .is_static = is_static};
        CAPTURE(round, is_static, name(shape.kind()));
        if (shape.is_bounded() || is_static) {
          CHECK_NOTHROW(scene.add_body(body));
          ++bodies;
        } else {
          CHECK_THAT(message_of([&] { scene.add_body(body); }),
                     Contains("is_static") && (Contains("half-space") || Contains("is a plane")));
        }
        CHECK(scene.bodies() == bodies);
      }
    for (std::uint32_t i = 0; i < scene.indices(); ++i)
      if (scene.alive(i) && i % 3 != 0) {
        scene.remove_body(scene.id(i));
        --bodies;
      }
    CHECK(scene.bodies() == bodies);
  }
}

TEST_CASE("scene: a copy has another history, what is moved keeps its own") {
  Fixture f;
  const BodyId id = f.scene.add_body(f.body());
  const SceneChanges::HistoryName name(f.scene);
  CHECK(name == SceneChanges::HistoryName(f.scene));
  CHECK_FALSE(SceneChanges::HistoryName() == SceneChanges::HistoryName());
  Scene copy = f.scene;
  CHECK_FALSE(name == SceneChanges::HistoryName(copy));
  const SceneChanges::HistoryName of_copy(copy);
  copy = f.scene;
  CHECK_FALSE(of_copy == SceneChanges::HistoryName(copy));
  CHECK_FALSE(name == SceneChanges::HistoryName(copy));
  const Scene moved = std::move(f.scene);
  CHECK(name == SceneChanges::HistoryName(moved));

  CHECK(SceneChanges::comings_and_goings(moved) == 1);
  CHECK(SceneChanges::versions(moved)[id.index()] == 1);
  copy.set_pose(id, Pose::at(1, 0, 0));
  CHECK(SceneChanges::versions(copy)[id.index()] == 2);
  copy.remove_body(id);
  CHECK(SceneChanges::versions(copy)[id.index()] == 3);
  CHECK(SceneChanges::comings_and_goings(copy) == 2);
}

TEST_CASE("scene: changes are checked as bodies are, and a refused one changes nothing") {
  Fixture f;
  const BodyId id = f.scene.add_body(f.body());
  Pose bad = Pose::at(1, 2, 3);
  bad.rotation(0, 0) = 2;
  CHECK_THROWS_AS(f.scene.set_pose(id, bad), std::invalid_argument);
  CHECK(f.scene.pose(id).translation == Vec3::Zero());
  CHECK_THROWS_AS(f.scene.set_velocity(id, {0, 0, not_a_number}, Vec3::Zero()), std::invalid_argument);
  CHECK_THROWS_AS(f.scene.set_velocity(id, {1, 0, 0}, {infinite, 0, 0}), std::invalid_argument);
  CHECK(f.scene.velocities()[0] == Vec3::Zero());
  f.scene.set_pose(id, Pose::at(1, 2, 3));
  f.scene.set_velocity(id, {4, 5, 6}, {7, 8, 9});
  CHECK(f.scene.pose(id).translation == Vec3(1, 2, 3));
  CHECK(f.scene.velocities()[0] == Vec3(4, 5, 6));
  CHECK(f.scene.angular_velocities()[0] == Vec3(7, 8, 9));
}

TEST_CASE("scene: an id of a removed body never names a newer one") {
  Fixture f;
  const BodyId first = f.scene.add_body(f.body()), second = f.scene.add_body(f.body());
  f.scene.remove_body(first);
  CHECK(f.scene.bodies() == 1);
  CHECK_FALSE(f.scene.alive(0));
  CHECK(f.scene.alive(1));
  CHECK_THROWS_AS(f.scene.pose(first), std::invalid_argument);
  CHECK_THROWS_AS(f.scene.id(0), std::invalid_argument);

  BodyOptions newer = f.body();
  newer.pose = Pose::at(5, 0, 0);
  newer.group = 2;
  newer.mask = 4;
  newer.density = 7;
  const BodyId third = f.scene.add_body(newer);
  CHECK(third.index() == 0);
  CHECK(f.scene.indices() == 2);
  CHECK(third != first);
  CHECK(f.scene.id(0) == third);
  CHECK(f.scene.groups()[0] == 2);
  CHECK(f.scene.masks()[0] == 4);
  CHECK(f.scene.densities()[0] == 7);
  CHECK_THROWS_AS(f.scene.set_pose(first, {}), std::invalid_argument);
  CHECK_THROWS_AS(f.scene.set_velocity(first, Vec3::Zero(), Vec3::Zero()), std::invalid_argument);
  CHECK_THROWS_AS(f.scene.remove_body(first), std::invalid_argument);
  CHECK(f.scene.pose(third).translation == Vec3(5, 0, 0));
  CHECK(f.scene.pose(second).translation == Vec3::Zero());
  CHECK_THAT(message_of([&] { f.scene.pose(first); }), Contains("body 0") && Contains("removed"));
}

TEST_CASE("scene: no body has the id that nobody gave") {
  Fixture f;
  CHECK_THROWS_AS(f.scene.pose(BodyId{}), std::invalid_argument);
  const BodyId id = f.scene.add_body(f.body());
  CHECK_FALSE(id == BodyId{});
  CHECK_THROWS_AS(f.scene.pose(BodyId{}), std::invalid_argument);
  CHECK_THROWS_AS(f.scene.pose(BodyId{2, id.generation}), std::invalid_argument);
  CHECK_THROWS_AS(f.scene.id(1), std::invalid_argument);
}

TEST_CASE("scene: freed indices are all used before new ones, again and again") {
  Fixture f;
  std::vector<BodyId> ids;
  for (int i = 0; i < 10; ++i) ids.push_back(f.scene.add_body(f.body()));
  std::vector<BodyId> all = ids;
  for (int round = 0; round < 20; ++round) {
    for (const int i : {2, 7, 3}) f.scene.remove_body(ids[static_cast<std::size_t>(i)]);
    CHECK(f.scene.bodies() == 7);
    for (int i = 0; i < 3; ++i) {
      const BodyId id = f.scene.add_body(f.body());
      for (const BodyId old : all) REQUIRE_FALSE(id == old);
      all.push_back(id);
      ids[id.index()] = id;
    }
    CHECK(f.scene.bodies() == 10);
    CHECK(f.scene.indices() == 10);
  }
}

TEST_CASE("scene: shapes come and go, bodies change what they are, and what cannot be changes nothing") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1}, "ball"), box = scene.add_shape(Box{{1, 1, 1}});
  const ShapeId ground = scene.add_shape(HalfSpace{});
  const BodyId body = scene.add_body({.shape = ball}), other = scene.add_body({.shape = box, .is_static = true});
  CHECK(scene.has_kind(ShapeKind::sphere));
  CHECK_THROWS_AS(scene.remove_shape(ball), std::invalid_argument);
  CHECK_THROWS_AS(scene.set_shape(body, ground), std::invalid_argument);  // it moves
  scene.set_shape(body, box);
  CHECK(scene.shape_id(body) == box);
  scene.remove_shape(ball);
  CHECK_FALSE(scene.has_kind(ShapeKind::sphere));
  CHECK_FALSE(scene.has_shape(0));
  CHECK_THROWS_AS(scene.remove_shape(ball), std::invalid_argument);
  CHECK_THROWS_AS(scene.add_body({.shape = ball}), std::invalid_argument);
  const ShapeId newer = scene.add_shape(Capsule{1, 1});
  CHECK(newer.index_plus_one == ball.index_plus_one);
  CHECK_FALSE(newer == ball);
  CHECK_THROWS_AS(scene.set_shape(body, ball), std::invalid_argument);
  scene.set_static(body, true);
  scene.set_shape(body, ground);
  CHECK_THROWS_AS(scene.set_static(body, false), std::invalid_argument);
  scene.set_filter(other, 4, 8);
  CHECK(scene.groups()[other.index()] == 4);
  CHECK(scene.masks()[other.index()] == 8);
  scene.reserve(1000);
  std::vector<BodyId> ids{other, body, other};
  std::vector<Pose> poses{Pose::at(1, 0, 0), Pose::at(2, 0, 0), Pose::at(3, 0, 0)};
  scene.set_poses(ids, poses);
  CHECK(scene.pose(other).translation.x() == 3);
  CHECK(scene.pose(body).translation.x() == 2);
  poses[2].translation.x() = std::numeric_limits<double>::quiet_NaN();
  poses[0] = Pose::at(9, 0, 0);
  CHECK_THROWS_AS(scene.set_poses(ids, poses), std::invalid_argument);
  CHECK(scene.pose(other).translation.x() == 3);
  CHECK_THROWS_AS(scene.set_poses(ids, std::span(poses).first(2)), std::invalid_argument);
}

TEST_CASE("scene: the mesh of a shape and of its rounded one is counted once") {
  const Shape mesh(test::torus(1, 0.4, 40, 20));
  Scene one, two;
  one.add_shape(mesh);
  two.add_shape(mesh);
  two.add_shape(mesh.rounded(0.1));  // creates data that the two share
  CHECK(one.memory().shapes > mesh.memory());
  CHECK(two.memory().shapes > one.memory().shapes);
  CHECK(two.memory().shapes < one.memory().shapes + mesh.memory() / 2);
}

TEST_CASE("scene: bodies and shapes that come one by one take little more room than they fill") {
  Scene scene;
  for (int i = 0; i < 4200; ++i) {  // shortly after doubling lists have grown
    BodyOptions body;
    body.shape = scene.add_shape(Sphere{1 + 0.001 * i});
    body.pose.translation.x() = 3.0 * i;
    scene.add_body(body);
  }
  const Scene copy = scene;  // its lists have no spare capacity
  CHECK(static_cast<double>(scene.memory().bodies) < 1.3 * static_cast<double>(copy.memory().bodies));
  CHECK(static_cast<double>(scene.memory().shapes) < 1.3 * static_cast<double>(copy.memory().shapes));
}

TEST_CASE("scene: room that was asked for is all that bodies and shapes take") {
  Scene scene;
  scene.reserve(1000, 900);
  const SceneMemory before = scene.memory();
  for (int i = 0; i < 1000; ++i) {
    BodyOptions body;
    body.shape = i < 900 ? scene.add_shape(Sphere{1 + 0.001 * i}) : ShapeId{1, 1};
    scene.add_body(body);
  }
  CHECK(scene.memory().bodies == before.bodies);
  CHECK(scene.memory().shapes == before.shapes);  // a sphere holds nothing beside itself
  CHECK(before.shapes == 900 * (sizeof(Shape) + 9));
  scene.reserve(10);  // never less
  CHECK(scene.memory().total() == before.total());
}

TEST_CASE("a body's density and whether it is a sensor may change") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  const BodyId moving = scene.add_body({.shape = ball}), still = scene.add_body({.shape = ball, .is_static = true});
  scene.set_density(moving, 7);
  scene.set_sensor(moving, true);
  CHECK(scene.densities()[moving.index()] == 7);
  CHECK(scene.is_sensor()[moving.index()] == 1);
  scene.set_sensor(moving, false);
  CHECK(scene.is_sensor()[moving.index()] == 0);
  CHECK_THAT(message_of([&] { scene.set_density(moving, 0); }), Contains("body 0: density is 0"));
  CHECK(scene.densities()[moving.index()] == 7);
  scene.set_density(still, 0);  // not used
  CHECK_THROWS_AS(scene.set_static(still, false), std::invalid_argument);
  scene.remove_body(moving);
  CHECK_THROWS_AS(scene.set_density(moving, 1), std::invalid_argument);
  CHECK_THROWS_AS(scene.set_sensor(moving, true), std::invalid_argument);
}
