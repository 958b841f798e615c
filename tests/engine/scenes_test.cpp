// The built-in scenes.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

#include "catch.h"
#include "message_of.h"
#include "scene/mesh_generators.h"
#include "scene/random.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using Catch::Matchers::Contains;

namespace {

std::size_t count_moving(const Scene& scene) {
  std::size_t moving = 0;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) moving += scene.is_static()[i] == 0;
  return moving;
}

double volume(const Mesh& mesh) {
  double six_volumes = 0;
  for (const auto& t : mesh.triangles)
    six_volumes += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return six_volumes / 6;
}

/// Every directed edge occurs once, and so does its reverse; no triangle is degenerate; all vertices are used.
void check_watertight(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::vector<bool> used(mesh.vertices.size());
  double smallest = 1e300;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      ++edges[{t[k], t[(k + 1) % 3]}];
      used[t[k]] = true;
    }
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    smallest = std::min(smallest, (b - a).cross(c - a).norm());
  }
  std::size_t wrong = 0;
  for (const auto& [edge, times] : edges) {
    const auto reverse = edges.find({edge.second, edge.first});
    wrong += times != 1 || reverse == edges.end() || reverse->second != 1;
  }
  CHECK(wrong == 0);
  CHECK(std::count(used.begin(), used.end(), false) == 0);
  CHECK(smallest > 1e-4);
  CHECK(mesh.solid);
}

long euler_characteristic(const Mesh& mesh) {
  return static_cast<long>(mesh.vertices.size()) - static_cast<long>(mesh.triangles.size()) / 2;
}

bool equal_scenes(const Scene& a, const Scene& b) {
  bool same = a.indices() == b.indices() && a.shapes().size() == b.shapes().size();
  for (std::size_t i = 0; same && i < a.indices(); ++i)
    same = a.poses()[i].rotation == b.poses()[i].rotation && a.poses()[i].translation == b.poses()[i].translation &&
           a.velocities()[i] == b.velocities()[i] && a.angular_velocities()[i] == b.angular_velocities()[i] &&
           a.shape_indices()[i] == b.shape_indices()[i] && a.is_static()[i] == b.is_static()[i];
  return same;
}

constexpr double pi = 3.14159265358979323846;

const Thread bolt_thread{.root_radius = 0.25, .crest_radius = 0.30, .pitch = 0.2, .turns = 4};
const Thread nut_thread{.root_radius = 0.37, .crest_radius = 0.32, .pitch = 0.2, .turns = 3};

}  // namespace

TEST_CASE("generators: cosines and sines are the library's to 1e-15 and exact at quarters") {
  double worst = 0;
  for (int n = 1; n < 200; ++n)
    for (int k = 0; k < n; ++k) {
      const CosSin ours = cos_sin_of_turn(k, n);
      worst = std::max(
          {worst, std::abs(ours.cos - std::cos(2 * pi * k / n)), std::abs(ours.sin - std::sin(2 * pi * k / n))});
      const CosSin again = cos_sin_of_turn(k - n, n);
      REQUIRE((again.cos == ours.cos && again.sin == ours.sin));
    }
  CHECK(worst < 2e-15);
  CHECK(cos_sin_of_turn(1, 4).cos == 0);
  CHECK(cos_sin_of_turn(2, 4).cos == -1);
  CHECK(cos_sin_of_turn(3, 4).sin == -1);
  CHECK(cos_sin_of_turn(1, 12).sin == Approx(0.5).epsilon(1e-15));
}

TEST_CASE("generators: the sequence of SplitMix64 is the published one, and rotations are spread evenly") {
  Random random(1234567);
  CHECK(random.bits() == 6457827717110365317u);
  CHECK(random.bits() == 3203168211198807973u);
  CHECK(random.bits() == 9817491932198370423u);
  Mat3 mean = Mat3::Zero();
  Vec3 diagonal = Vec3::Zero();
  double worst = 0;
  const int samples = 20000;
  for (int i = 0; i < samples; ++i) {
    const Mat3 r = random.rotation();
    worst = std::max(worst, (r * r.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff());
    REQUIRE(r.determinant() > 0.999);
    mean += r / samples;
    diagonal += r.diagonal().cwiseAbs2() / samples;
  }
  CHECK(worst < 1e-14);
  CHECK(mean.cwiseAbs().maxCoeff() < 0.02);
  for (int axis = 0; axis < 3; ++axis) CHECK(diagonal[axis] == Approx(1.0 / 3).margin(0.01));
}

TEST_CASE("generators: meshes are watertight, oriented outwards, and of the volume that geometry says") {
  const Mesh torus = make_torus(0.6, 0.25, 24, 24);
  check_watertight(torus);
  CHECK(torus.triangles.size() == 1152);
  CHECK(euler_characteristic(torus) == 0);
  const double ideal_torus = 2 * pi * pi * 0.6 * 0.25 * 0.25;
  CHECK(volume(torus) < ideal_torus);
  CHECK(volume(torus) > 0.97 * ideal_torus);

  const Mesh cone = make_cone(0.8, 1.2, 24, 4);
  check_watertight(cone);
  CHECK(euler_characteristic(cone) == 2);
  CHECK(volume(cone) == Approx(24 * 0.5 * 0.64 * std::sin(2 * pi / 24) * 1.2 / 3).epsilon(1e-12));

  const Mesh bolt = make_bolt({.thread = bolt_thread, .head_radius = 0.5, .head_height = 0.35, .segments = 12});
  check_watertight(bolt);
  CHECK(bolt.triangles.size() >= 400);
  CHECK(euler_characteristic(bolt) == 2);
  CHECK(volume(bolt) > 0.9 * (pi * 0.25 * 0.25 * 0.9 + 1.5 * std::sqrt(3.0) * 0.25 * 0.35) * 0.95);
  CHECK(volume(bolt) < pi * 0.30 * 0.30 * 0.9 + 1.5 * std::sqrt(3.0) * 0.25 * 0.35);

  const Mesh nut = make_nut({.thread = nut_thread, .corner_radius = 0.6, .segments = 12});
  check_watertight(nut);
  CHECK(nut.triangles.size() >= 400);
  CHECK(euler_characteristic(nut) == 0);
  CHECK(volume(nut) > 0);

  const BowlSize size{.sphere_radius = 20, .rim_radius = 13, .thickness = 2, .segments = 48, .bands = 12};
  const Mesh bowl = make_bowl(size);
  check_watertight(bowl);
  CHECK(euler_characteristic(bowl) == 2);
  CHECK(volume(bowl) > 0);
}

TEST_CASE("generators: threads are helices: a quarter turn lifts the crest by a quarter of the pitch") {
  const Mesh bolt = make_bolt({.thread = bolt_thread, .head_radius = 0.5, .head_height = 0.35, .segments = 12});
  const auto crest_heights = [&](double angle) {
    std::vector<double> heights;
    for (const Vec3& v : bolt.vertices) {
      const double radius = std::hypot(v.x(), v.y());
      const bool there = std::abs(std::remainder(std::atan2(v.y(), v.x()) - angle, 2 * pi)) < 1e-9;
      if (there && std::abs(radius - 0.30) < 1e-12) heights.push_back(v.z());
    }
    std::sort(heights.begin(), heights.end());
    return heights;
  };
  const std::vector<double> at_0 = crest_heights(0), at_90 = crest_heights(pi / 2);
  REQUIRE(at_0.size() == 4);
  REQUIRE(at_90.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(at_90[i] - at_0[i] == Approx(0.05).margin(1e-12));
  for (std::size_t i = 1; i < 4; ++i) CHECK(at_0[i] - at_0[i - 1] == Approx(0.2).epsilon(1e-12));
}

TEST_CASE("generators: a bolt passes through a nut's hole") {
  const Mesh nut = make_nut({.thread = nut_thread, .corner_radius = 0.6, .segments = 12});
  double hole = 1e300;
  for (const Vec3& v : nut.vertices) hole = std::min(hole, std::hypot(v.x(), v.y()));
  CHECK(hole == Approx(0.32).epsilon(1e-12));
  CHECK(hole * std::cos(pi / 12) > 0.30);
}

TEST_CASE("generators: the bowl's facets lie over its ideal surface by no more than is said") {
  const BowlSize size{.sphere_radius = 20, .rim_radius = 13, .thickness = 2, .segments = 48, .bands = 12};
  const Mesh bowl = make_bowl(size);
  double highest = 0;
  std::size_t inner = 0;
  for (const auto& t : bowl.triangles) {
    const Vec3 &a = bowl.vertices[t[0]], &b = bowl.vertices[t[1]], &c = bowl.vertices[t[2]];
    const Vec3 middle = (a + b + c) / 3;
    if ((b - a).cross(c - a).z() <= 1e-9 || middle.head<2>().norm() > size.rim_radius * 0.99) continue;
    ++inner;
    for (const Vec3& p : {middle, Vec3((a + b) / 2), Vec3((b + c) / 2), Vec3((c + a) / 2)}) {
      const double above = p.z() - bowl_height(size, p.head<2>().norm());
      CHECK(above > -1e-12);
      highest = std::max(highest, above);
    }
  }
  CHECK(inner > 1000);
  CHECK(highest > 0);
  CHECK(highest < bowl_sagitta(size));
}

TEST_CASE("scenes: the paper's four come first and all have the bodies they say") {
  const auto scenes = builtin_scenes();
  REQUIRE(scenes.size() >= 4);
  CHECK((scenes[0].name == "screws-in-bowl" && scenes[0].bodies == 500));
  CHECK((scenes[1].name == "tori-on-cones" && scenes[1].bodies == 2000));
  CHECK((scenes[2].name == "cubes-on-plane" && scenes[2].bodies == 3000));
  CHECK((scenes[3].name == "spheres-on-plane" && scenes[3].bodies == 2500));
  for (const BuiltinScene& known : scenes) {
    CAPTURE(known.name);
    CHECK_FALSE(known.description.empty());
    CHECK(count_moving(make_builtin_scene(known.name)) == known.bodies);
    for (const std::size_t bodies : {1u, 2u, 7u, 64u, 1001u}) {
      const Scene scene = make_builtin_scene(known.name, bodies);
      CHECK(scene.name == known.name);
      CHECK(count_moving(scene) == bodies);
      CHECK(scene.gravity == Vec3(0, 0, -9.81));
      CHECK(scene.dt == 1.0 / 60);
      for (std::uint32_t i = 0; i < scene.indices(); ++i)
        if (!scene.is_static()[i]) {
          REQUIRE(scene.shape_of(i).size() > 0.5);
          REQUIRE(scene.shape_of(i).size() < 3);
          REQUIRE(scene.densities()[i] == 1000);
        }
    }
  }
}

TEST_CASE("scenes: what is asked in vain is answered with what there is") {
  CHECK_THROWS_AS(make_builtin_scene("cubes"), std::invalid_argument);
  CHECK_THAT(message_of([] { make_builtin_scene("cubes"); }), Contains("cubes-on-plane") && Contains("'cubes'"));
  CHECK_THROWS_AS(make_builtin_scene("cubes-on-plane", 1'000'001), std::invalid_argument);
  CHECK_THAT(message_of([] { make_builtin_scene("cubes-on-plane", 1'000'001); }),
             Contains("1000001") && Contains("1000000"));
}

TEST_CASE("scenes: a million bodies are made") {
  CHECK(count_moving(make_builtin_scene("spheres-on-plane", 1'000'000)) == 1'000'000);
}

TEST_CASE("scenes: name, size and seed make the scene; another seed another one") {
  for (const BuiltinScene& known : builtin_scenes()) {
    CAPTURE(known.name);
    CHECK(equal_scenes(make_builtin_scene(known.name, 100, 5), make_builtin_scene(known.name, 100, 5)));
    CHECK_FALSE(equal_scenes(make_builtin_scene(known.name, 100, 5), make_builtin_scene(known.name, 100, 6)));
  }
}

// A known number: the same on every machine, compiler and level of optimisation.
TEST_CASE("scenes: the same bits everywhere") {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](double x) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &x, sizeof bits);
    hash = (hash ^ bits) * 0x100000001b3u;
  };
  for (const BuiltinScene& known : builtin_scenes()) {
    const Scene scene = make_builtin_scene(known.name, 50, 3);
    for (const Pose& pose : scene.poses()) {
      for (int i = 0; i < 9; ++i) add(pose.rotation(i / 3, i % 3));
      for (int i = 0; i < 3; ++i) add(pose.translation[i]);
    }
  }
  for (const Mesh& mesh : {make_torus(0.6, 0.25, 24, 24), make_nut({nut_thread, 0.6, 12})})
    for (const Vec3& v : mesh.vertices)
      for (int i = 0; i < 3; ++i) add(v[i]);
  CHECK(hash == 0x1c0f9948f613ff5au);
}

TEST_CASE("scenes: bodies start apart") {
  for (const BuiltinScene& known : builtin_scenes()) {
    if (known.name == "complex-in-contact") continue;
    CAPTURE(known.name);
    const Scene scene = make_builtin_scene(known.name, 600);
    const NarrowPhase narrow_phase;
    std::size_t near = 0, colliding = 0;
    std::vector<Bounds> bounds;
    for (std::uint32_t i = 0; i < scene.indices(); ++i) bounds.push_back(scene.shape_of(i).bounds(scene.poses()[i]));
    for (std::uint32_t i = 0; i < scene.indices(); ++i)
      for (std::uint32_t j = i + 1; j < scene.indices(); ++j) {
        if (scene.is_static()[i] && scene.is_static()[j]) continue;
        if ((bounds[i].lo.array() > bounds[j].hi.array()).any() || (bounds[j].lo.array() > bounds[i].hi.array()).any())
          continue;
        ++near;
        colliding +=
            narrow_phase
                .solve(scene.shape_of(i), scene.poses()[i], scene.shape_of(j), scene.poses()[j], Request::collide)
                .collide;
      }
    CHECK(colliding == 0);
    if (known.name == "screws-in-bowl") CHECK(near > 0);  // the bowl's box contains the bodies: some pairs were tested
  }
}

TEST_CASE("scenes: grains are of the kinds and sizes they say, within the walls of their box") {
  const Scene grains = make_builtin_scene("grains", 500), mixed = make_builtin_scene("mixed-grains", 500);
  std::set<double> radii;
  for (std::uint32_t i = 0; i < grains.indices(); ++i)
    if (!grains.is_static()[i]) {
      REQUIRE(grains.shape_of(i).kind() == ShapeKind::sphere);
      radii.insert(grains.shape_of(i).radius());
    }
  CHECK(radii.size() == 500);
  CHECK((*radii.begin() >= 0.3 && *radii.begin() < 0.31 && *radii.rbegin() > 0.59 && *radii.rbegin() < 0.6));
  std::map<ShapeKind, int> kinds;
  for (std::uint32_t i = 0; i < mixed.indices(); ++i) {
    if (mixed.is_static()[i]) continue;
    ++kinds[mixed.shape_of(i).kind()];
    if (mixed.shape_of(i).kind() == ShapeKind::box) CHECK(mixed.shape_of(i).rounding() > 0);
  }
  CHECK(kinds.size() == 4);
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::ellipsoid, ShapeKind::convex, ShapeKind::box})
    CHECK(kinds[kind] > 60);
  for (const Scene* scene : {&grains, &mixed}) {
    Bounds all = scene->shape_of(5).bounds(scene->poses()[5]);
    for (std::uint32_t i = 5; i < scene->indices(); ++i) {
      const Bounds own = scene->shape_of(i).bounds(scene->poses()[i]);
      all = {all.lo.cwiseMin(own.lo), all.hi.cwiseMax(own.hi)};
    }
    CHECK(all.lo.z() >= 0);
    // The floor, then the four walls, whose solid is beyond a plane that no grain reaches.
    for (std::uint32_t wall = 1; wall < 5; ++wall) {
      const Shape& shape = scene->shape_of(wall);
      REQUIRE(shape.kind() == ShapeKind::halfspace);
      const Vec3 nearest = (shape.normal().array() > 0).select(all.lo, all.hi);
      CHECK(shape.normal().dot(nearest) > shape.offset());
      CHECK(shape.normal().dot(nearest) < shape.offset() + 1.5);
    }
  }
}

TEST_CASE("scenes: in complex-in-contact every body touches another from the start") {
  const Scene scene = make_builtin_scene("complex-in-contact");
  const NarrowPhase narrow_phase;
  std::vector<int> touches(scene.indices());
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    for (std::uint32_t j = i + 1; j < scene.indices(); ++j)
      if (narrow_phase.solve(scene.shape_of(i), scene.poses()[i], scene.shape_of(j), scene.poses()[j], Request::collide)
              .collide) {
        ++touches[i];
        ++touches[j];
      }
  for (std::uint32_t i = 0; i < scene.indices(); ++i) CHECK(touches[i] > 0);
}
