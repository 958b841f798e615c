// Queries of a scene, compared with a plain loop over its bodies.
#include "tandem/engine/scene_queries.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "catch.h"
#include "message_of.h"
#include "narrowphase/mesh_samples.h"
#include "narrowphase/random_pairs.h"
#include "scene/swept_boxes.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/prepare.h"
#include "tandem/narrowphase/work_limit.h"

using namespace tandem;
using namespace tandem::test;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// All kinds of bodies in a cube, a floor, some in other groups.
struct World {
  Scene scene;
  std::vector<BodyId> bodies;
  Random random;

  explicit World(unsigned seed, int count) : random(seed) {
    for (int i = 0; i < count; ++i) add();
    bodies.push_back(scene.add_body({.shape = scene.add_shape(HalfSpace{{0, 0, 1}, -6}), .is_static = true}));
    bodies.push_back(scene.add_body({.shape = scene.add_shape(Plane{{0.1, 0.2, 1}, 5.5}), .is_static = true}));
  }
  void add() {
    auto kind = static_cast<ShapeKind>(bodies.size() % shape_kinds);
    if (kind == ShapeKind::halfspace || kind == ShapeKind::plane) kind = ShapeKind::box;
    const ShapeId shape = scene.add_shape(random_shape(kind, random));
    bodies.push_back(scene.add_body({.shape = shape,
                                     .pose = random_pose(random, 5),
                                     .group = bodies.size() % 7 == 0 ? 2u : 1u,
                                     .mask = bodies.size() % 11 == 0 ? 2u : ~0u}));
  }
  bool admits(BodyId body, const QueryFilter& f) const {
    const std::uint32_t i = body.index();
    return (f.group & scene.masks()[i]) != 0 && (f.mask & scene.groups()[i]) != 0 &&
           std::find(f.ignore.begin(), f.ignore.end(), body) == f.ignore.end() && (!f.admits || f.admits(body));
  }
  /// The answer for each admitted body, by index.
  std::vector<Hit> all(const Shape& shape, const Pose& pose, const QueryFilter& filter, Request request) const {
    const NarrowPhase narrow;
    std::vector<Hit> hits;
    for (const BodyId body : bodies)
      if (admits(body, filter))
        hits.push_back({body, narrow.solve(shape, pose, scene.shape_of(body.index()), scene.pose(body), request)});
    std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.body.index() < b.body.index(); });
    return hits;
  }
};

Shape asking(Random& random) {
  const auto kind = static_cast<ShapeKind>(static_cast<int>(random.in(0, shape_kinds)));
  const bool bounded = kind != ShapeKind::halfspace && kind != ShapeKind::plane;
  return random_shape(bounded ? kind : ShapeKind::sphere, random);
}

bool same(const PairAnswer& a, const PairAnswer& b) {
  return a.collide == b.collide && a.signed_distance == b.signed_distance && a.point_a == b.point_a &&
         a.point_b == b.point_b && a.normal == b.normal && a.error_bound == b.error_bound;
}

void compare(const World& world, const SceneQueries& queries, Random& random, int times) {
  const std::vector<BodyId> ignored{world.bodies[1], world.bodies[2], BodyId{}};
  for (int i = 0; i < times; ++i) {
    const Shape shape = asking(random);
    const Pose pose = random_pose(random, 6);
    QueryFilter filter;
    if (i % 4 == 1) filter.group = 2;
    if (i % 4 == 2) filter.ignore = ignored;
    if (i % 4 == 3) filter.admits = [](BodyId body) { return body.index() % 3 != 0; };
    CAPTURE(i, name(shape.kind()));

    std::vector<BodyId> touched;
    queries.hits(shape, pose, touched, filter);
    std::vector<BodyId> expected;
    for (const Hit& hit : world.all(shape, pose, filter, Request::collide))
      if (hit.answer.collide) expected.push_back(hit.body);
    REQUIRE(touched == expected);
    CHECK(queries.collides(shape, pose, 0, filter) == !expected.empty());

    const std::vector<Hit> distances = world.all(shape, pose, filter, Request::distance);
    const double margin = random.in(0, 2);
    std::vector<Hit> near, plain;
    queries.within(shape, pose, margin, near, filter);
    for (const Hit& hit : distances)
      if (hit.answer.signed_distance <= margin) plain.push_back(hit);
    REQUIRE(near.size() == plain.size());
    for (std::size_t k = 0; k < near.size(); ++k) {
      CHECK(near[k].body == plain[k].body);
      CHECK(same(near[k].answer, plain[k].answer));
    }
    CHECK(queries.collides(shape, pose, margin, filter) == !plain.empty());

    const auto least = std::min_element(distances.begin(), distances.end(), [](const Hit& a, const Hit& b) {
      return a.answer.signed_distance < b.answer.signed_distance;
    });
    const auto nearest = queries.nearest(shape, pose, infinity, filter);
    REQUIRE(nearest.has_value() == (least != distances.end()));
    if (!nearest) continue;
    CHECK(nearest->body == least->body);
    CHECK(same(nearest->answer, least->answer));
    const double d = least->answer.signed_distance;
    if (d > 0) {
      CHECK(queries.nearest(shape, pose, d, filter)->body == least->body);
      CHECK_FALSE(queries.nearest(shape, pose, std::nextafter(d, 0.0), filter));
    }

    std::vector<ContactHit> contact_hits;
    std::vector<Contact> contacts;
    queries.contacts(shape, pose, 0, contact_hits, contacts, filter);
    for (const ContactHit& hit : contact_hits) {
      std::vector<Contact> alone;
      NarrowPhase().solve(shape, pose, world.scene.shape_of(hit.body.index()), world.scene.pose(hit.body),
                          Request::contacts, &alone);
      REQUIRE(hit.count == alone.size());
      for (std::size_t k = 0; k < alone.size(); ++k) {
        CHECK(contacts[hit.first + k].point == alone[k].point);
        CHECK(contacts[hit.first + k].depth == alone[k].depth);
      }
    }
  }
}

}  // namespace

TEST_CASE("queries of a scene: those of a loop over its bodies, whatever moves, comes and goes") {
  World world(3, 120);
  SceneQueries queries(world.scene);
  Random random(5);
  for (int round = 0; round < 6; ++round) {
    compare(world, queries, random, 40);
    for (std::size_t i = 0; i + 1 < world.bodies.size(); ++i)
      if (random.in(0, 1) < (round % 2 == 0 ? 0.1 : 0.5)) world.scene.set_pose(world.bodies[i], random_pose(random, 5));
    if (round >= 2) {
      world.scene.remove_body(world.bodies[10]);
      world.bodies.erase(world.bodies.begin() + 10);
    }
    if (round >= 3) world.add();
    if (round == 5) world.add();
    const UpdateReport report = queries.update(world.scene);
    CHECK(report.changed > 0);
  }
  CHECK(queries.update(world.scene).changed == 0);
  const Scene other;
  queries.update(other);
  CHECK_FALSE(queries.nearest(Sphere{1}, Pose{}));
}

TEST_CASE("queries of a scene: a few that move are refitted, and a copy is asked") {
  World world(9, 200);
  SceneQueries queries(world.scene);
  Pose moved = world.scene.pose(world.bodies[5]);
  moved.translation += Vec3(0.1, 0, 0);
  world.scene.set_pose(world.bodies[5], moved);
  const Shape point = Sphere{0};
  const auto before = queries.nearest(point, Pose::at(0, 0, 0));
  const UpdateReport report = queries.update(world.scene);
  CHECK(report.changed == 1);
  CHECK_FALSE(report.rebuilt);
  REQUIRE(before);
  CHECK(queries.memory() > 200 * sizeof(Pose));
}

TEST_CASE("queries of a scene: a body that asks stands where the last update saw it, whatever it did since") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{0.5});
  const BodyId asks = scene.add_body({.shape = ball}),
               other = scene.add_body({.shape = ball, .pose = Pose::at(3, 0, 0)});
  SceneQueries queries(scene);
  const auto distance = [&] { return queries.nearest(asks)->answer.signed_distance; };
  CHECK(distance() == 2);
  scene.set_pose(asks, Pose::at(1, 0, 0));
  CHECK(distance() == 2);
  queries.update(scene);
  CHECK(distance() == 1);
  scene.set_pose(asks, Pose::at(2.5, 0, 0));
  std::vector<BodyId> touched;
  queries.hits(asks, touched);
  CHECK_FALSE(queries.collides(asks));
  CHECK(touched.empty());
  queries.update(scene);
  queries.hits(asks, touched);
  CHECK(queries.collides(asks));
  CHECK(touched == std::vector{other});
  // A removed body can query while the copy has it.
  scene.remove_body(asks);
  CHECK(queries.collides(asks));
  queries.update(scene);
  CHECK_THROWS_AS(queries.collides(asks), std::invalid_argument);
  CHECK_THROWS_AS(queries.nearest(asks), std::invalid_argument);
}

TEST_CASE("queries of a scene: memory that batches leave for the next ones is counted, and stays") {
  World world(11, 40);
  const SceneQueries queries(world.scene);
  const std::size_t before = queries.memory();
  const std::vector<Shape> links{Sphere{0.2}, Sphere{0.3}};
  const std::vector<Pose> poses(2 * 256);
  std::vector<Verdict> verdicts(256);
  queries.check(links, poses, PairTable(2, 2, true), verdicts);
  const std::size_t after = queries.memory();
  CHECK(after > before + 256 * links.size() * sizeof(float));
  queries.check(links, poses, PairTable(2, 2, true), verdicts);
  CHECK(queries.memory() < 2 * after);
}

TEST_CASE("queries of a scene: asked by its own bodies, and from many threads at once") {
  World world(13, 150);
  const SceneQueries queries(world.scene);
  const NarrowPhase narrow;
  const auto meets = [&](BodyId a, BodyId b) {
    const std::uint32_t i = a.index(), j = b.index();
    const Scene& s = world.scene;
    return i != j && (s.groups()[i] & s.masks()[j]) != 0 && (s.groups()[j] & s.masks()[i]) != 0 &&
           (s.is_static()[i] == 0 || s.is_static()[j] == 0);
  };
  std::vector<std::uint8_t> wrong(world.bodies.size());
  tbb::task_arena(4).execute([&] {
    tbb::parallel_for(std::size_t{0}, world.bodies.size(), [&](std::size_t i) {
      const BodyId body = world.bodies[i];
      const Shape& shape = world.scene.shape_of(body.index());
      const Pose& pose = world.scene.pose(body);
      std::vector<BodyId> expected, touched;
      std::optional<Hit> least;
      for (const BodyId other : world.bodies) {
        if (!meets(body, other)) continue;
        const Pose& at = world.scene.pose(other);
        const Shape& theirs = world.scene.shape_of(other.index());
        if (narrow.solve(shape, pose, theirs, at, Request::collide).collide) expected.push_back(other);
        const PairAnswer answer = narrow.solve(shape, pose, theirs, at, Request::distance);
        if (!least || answer.signed_distance < least->answer.signed_distance) least = Hit{other, answer};
      }
      std::sort(expected.begin(), expected.end(), [](BodyId a, BodyId b) { return a.index() < b.index(); });
      queries.hits(body, touched);
      const auto nearest = queries.nearest(body);
      std::vector<Hit> near;
      queries.within(body, 0.5, near);
      wrong[i] = touched != expected || queries.collides(body) == expected.empty() || !nearest || !least ||
                 nearest->body != least->body || !same(nearest->answer, least->answer) ||
                 queries.collides(body, 0.5) == near.empty();
    });
  });
  CHECK(std::count(wrong.begin(), wrong.end(), 0) == static_cast<std::ptrdiff_t>(wrong.size()));
}

TEST_CASE("queries of a scene: bad input is refused by name") {
  World world(1, 5);
  SceneQueries queries(world.scene);
  const Shape ball = Sphere{1};
  Pose bad;
  bad.translation.x() = std::numeric_limits<double>::quiet_NaN();
  std::vector<Hit> hits;
  CHECK(message_of([&] { queries.collides(ball, bad); }).find("translation[0]") != std::string::npos);
  CHECK(message_of([&] { queries.collides(ball, Pose{}, -1); }).find("margin") != std::string::npos);
  CHECK(message_of([&] { queries.within(ball, Pose{}, infinity, hits); }).find("margin") != std::string::npos);
  CHECK(message_of([&] { queries.nearest(ball, Pose{}, -1); }).find("cutoff") != std::string::npos);
  CHECK(message_of([&] { queries.collides(ball, Pose{}, -1e-9); }) == "margin: -1e-09 is not finite and >= 0");
  CHECK(message_of([&] { queries.cast(ball, {Pose{}, bad}); }).find("motion: to") != std::string::npos);
  const BodyId gone = world.bodies[0];
  queries.collides(gone);
  world.scene.remove_body(gone);
  queries.update(world.scene);
  CHECK(message_of([&] { queries.collides(gone); }).find("no body") != std::string::npos);

  const std::vector<Shape> links{ball, ball};
  std::vector<Pose> poses(4);
  std::vector<Verdict> verdicts(2);
  const PairTable all(2, 2, true);
  queries.check(links, poses, all, verdicts);
  CHECK(message_of([&] { queries.check(links, std::span(poses).first(3), all, verdicts); }).find("poses") !=
        std::string::npos);
  CHECK(message_of([&] { queries.check(links, poses, PairTable(3, 3, true), verdicts); }).find("table") !=
        std::string::npos);
  CHECK(message_of([&] { queries.check(links, poses, all, std::span(verdicts).first(1)); }).find("verdicts") !=
        std::string::npos);
  CHECK(message_of([&] { queries.check({}, poses, all, verdicts); }).find("links") != std::string::npos);
  BatchOptions three;
  three.configurations_a_motion = 3;
  CHECK(message_of([&] { queries.check(links, poses, all, verdicts, three); }).find("configurations_a_motion") !=
        std::string::npos);
  poses[3] = bad;
  CHECK(message_of([&] { queries.check(links, poses, all, verdicts); }).find("configuration 1, link 1") !=
        std::string::npos);
  for (const Shape& open : {Shape(HalfSpace{}), Shape(Plane{})})
    CHECK(message_of([&] {
            queries.check(std::span(&open, 1), std::span(poses).first(2), {}, verdicts);
          }).find("link 0 is a " + std::string(name(open.kind()))) != std::string::npos);
}

TEST_CASE("queries of a scene: a rotation of six digits is made one, as a body's is") {
  World world(3, 60);
  const SceneQueries queries(world.scene);
  Random r(3);
  std::size_t found = 0;
  for (int i = 0; i < 40; ++i) {
    const Shape shape = random_shape(ShapeKind::box, r);
    Pose exact = random_pose(r, 5);
    Pose six = exact;
    for (double& x : six.rotation.reshaped()) x = std::round(x * 1e6) / 1e6;
    exact = orthonormalized(six);
    CHECK(queries.collides(shape, six, 0.1) == queries.collides(shape, exact, 0.1));
    std::vector<Hit> hits, same;
    queries.within(shape, six, 1, hits);
    queries.within(shape, exact, 1, same);
    REQUIRE(hits.size() == same.size());
    for (std::size_t k = 0; k < hits.size(); ++k) {
      CHECK(hits[k].answer.signed_distance == same[k].answer.signed_distance);
      CHECK(std::abs(hits[k].answer.normal.norm() - 1) < 1e-14);
    }
    found += hits.size();
  }
  CHECK(found > 20);
}

TEST_CASE("configurations: verdicts and clearances are those of single queries, on any number of threads") {
  World world(21, 60);
  SceneQueries queries(world.scene);
  Random random(4);
  const std::vector<Shape> links{Capsule{0.2, 1}, Box{{0.4, 0.3, 0.8}}, random_shape(ShapeKind::convex, random),
                                 random_shape(ShapeKind::mesh, random)};
  PairTable self(4, 4, true), bodies(4, 30, true);
  self.set(0, 1, false);
  bodies.set(2, 7, false);
  const std::size_t configurations = 600;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < configurations * links.size(); ++i)
    poses.push_back(random_pose(random, i % 5 == 0 ? 9 : 6));
  const NarrowPhase narrow;
  for (const double margin : {0.0, 0.3}) {
    BatchOptions options;
    options.margin = margin;
    options.world = &bodies;
    options.filter.ignore = std::span(world.bodies).first(2);
    std::vector<Verdict> verdicts(configurations), again(configurations), motions(configurations / 20);
    std::vector<double> clearances(configurations), capped(configurations);
    queries.check(links, poses, self, verdicts, options);
    queries.clearance(links, poses, self, clearances, infinity, options);
    queries.clearance(links, poses, self, capped, 0.5, options);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < configurations; ++i) {
      const Pose* at = &poses[i * links.size()];
      double least = infinity;
      for (std::size_t a = 0; a < links.size(); ++a) {
        for (std::size_t b = a + 1; b < links.size(); ++b)
          if (self.checked(a, b))
            least = std::min(least, narrow.solve(links[a], at[a], links[b], at[b], Request::distance).signed_distance);
        for (const BodyId body : world.bodies) {
          if (body.index() < bodies.columns() && !bodies.checked(a, body.index())) continue;
          if (!world.admits(body, options.filter)) continue;
          least = std::min(least, narrow
                                      .solve(links[a], at[a], world.scene.shape_of(body.index()),
                                             world.scene.pose(body), Request::distance)
                                      .signed_distance);
        }
      }
      CAPTURE(i, least);
      REQUIRE((verdicts[i] == Verdict::hit) == (least <= margin));
      REQUIRE(clearances[i] == least);
      REQUIRE(capped[i] == std::min(least, 0.5));
      hits += verdicts[i] == Verdict::hit;
    }
    CHECK(hits > 20);
    CHECK(hits < configurations - 20);
    for (const int threads : {1, 2, 4}) {
      tbb::task_arena(threads).execute([&] { queries.check(links, poses, self, again, options); });
      CHECK(again == verdicts);
    }
    std::vector<FirstHit> first(configurations), first_of_motions(motions.size());
    queries.first_hits(links, poses, self, first, options);
    for (std::size_t i = 0; i < configurations; ++i) {
      REQUIRE(first[i].verdict == verdicts[i]);
      if (verdicts[i] != Verdict::hit) continue;
      const Pose* at = &poses[i * links.size()];
      const FirstHit& hit = first[i];
      const auto gap = [&](std::size_t link, const Shape& other, const Pose& pose) {
        return narrow.solve(links[link], at[link], other, pose, Request::distance).signed_distance;
      };
      const bool of_links = hit.body == BodyId{};
      const Shape& other = of_links ? links[hit.other_link] : world.scene.shape_of(hit.body.index());
      CHECK(gap(hit.link, other, of_links ? at[hit.other_link] : world.scene.pose(hit.body)) <= margin);
      // Nothing before it hits.
      for (std::size_t a = 0; a < links.size() && (!of_links || a < hit.link); ++a)
        for (std::size_t b = a + 1; b < links.size(); ++b)
          if (self.checked(a, b)) CHECK(gap(a, links[b], at[b]) > margin);
      for (std::size_t a = 0; !of_links && a <= hit.link; ++a)
        for (const BodyId body : world.bodies) {
          if (a == hit.link && body.index() >= hit.body.index()) continue;
          if (body.index() < bodies.columns() && !bodies.checked(a, body.index())) continue;
          if (world.admits(body, options.filter))
            CHECK(gap(a, world.scene.shape_of(body.index()), world.scene.pose(body)) > margin);
        }
    }
    options.configurations_a_motion = 20;
    queries.first_hits(links, poses, self, first_of_motions, options);
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const auto of = std::find_if(&first[20 * i], &first[20 * i] + 20,
                                   [](const FirstHit& h) { return h.verdict == Verdict::hit; });
      const auto place = static_cast<std::uint32_t>(of - &first[20 * i]);
      CHECK((first_of_motions[i].verdict == Verdict::hit) == (place < 20));
      if (place < 20) {
        CHECK(first_of_motions[i].configuration == place);
        CHECK(first_of_motions[i].body == of->body);
        CHECK(first_of_motions[i].link == of->link);
      }
    }
    queries.check(links, poses, self, motions, options);
    for (std::size_t i = 0; i < motions.size(); ++i) {
      const auto of = verdicts.begin() + static_cast<std::ptrdiff_t>(20 * i);
      CHECK((motions[i] == Verdict::hit) == (std::find(of, of + 20, Verdict::hit) != of + 20));
    }
  }
}

TEST_CASE("queries of a scene: a map of voxels answers as its cells do as bodies") {
  Random random(31);
  Voxels map{{}, 0.25, Vec3(-4, -4, 0)};
  Scene one, many;
  for (int i = 0; i < 600; ++i) {
    const auto place = [&](int most) { return static_cast<std::int32_t>(random.in(0, most)); };
    map.cells.push_back({{place(32), place(32), place(12)}, 0});
  }
  const Shape voxels(map);
  one.add_body({.shape = one.add_shape(voxels), .is_static = true});
  for (const auto& [corner, level] : voxels.cells()) {
    const double edge = 0.25 * (1 << level);
    const Vec3 centre = Vec3(-4, -4, 0) + 0.25 * Vec3(corner[0], corner[1], corner[2]) + Vec3::Constant(edge / 2);
    const ShapeId box = many.add_shape(Box{Vec3::Constant(edge)});
    many.add_body({.shape = box, .pose = {Mat3::Identity(), centre}, .is_static = true});
  }
  const SceneQueries map_queries(one), cell_queries(many);
  int hits = 0, met = 0;
  for (int i = 0; i < 400; ++i) {
    const Shape shape = i % 4 == 0 ? Shape(Sphere{0}) : random_shape(static_cast<ShapeKind>(i % 6), random);
    const Pose pose = random_pose(random, 5);
    const bool hit = map_queries.collides(shape, pose);
    CHECK(hit == cell_queries.collides(shape, pose));
    CHECK(map_queries.collides(shape, pose, 0.3) == cell_queries.collides(shape, pose, 0.3));
    hits += hit;
    const auto near = map_queries.nearest(shape, pose, 2), expected = cell_queries.nearest(shape, pose, 2);
    REQUIRE(near.has_value() == expected.has_value());
    if (near && !hit) CHECK(near->answer.signed_distance == Approx(expected->answer.signed_distance).margin(1e-11));
    // A ray where the shape is a point.
    const Motion motion{pose, random_pose(random, 5)};
    const auto touch = map_queries.cast(shape, motion), first = cell_queries.cast(shape, motion);
    REQUIRE(touch.has_value() == first.has_value());
    if (touch) CHECK(touch->t == Approx(first->t).margin(1e-7));
    met += touch && touch->t > 0;
  }
  CHECK(hits > 40);
  CHECK(met > 40);
  const std::vector<Shape> links{Capsule{0.1, 1}, Box{{0.2, 0.3, 0.8}}};
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < 2 * 300; ++i) poses.push_back(random_pose(random, 4));
  std::vector<Verdict> verdicts(300), expected(300), again(300);
  const PairTable self(2, 2, false);
  map_queries.check(links, poses, self, verdicts);
  cell_queries.check(links, poses, self, expected);
  CHECK(verdicts == expected);
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 8);
  tbb::task_arena arena(8);
  arena.execute([&] { map_queries.check(links, poses, self, again); });
  CHECK(again == expected);
  std::vector<double> clear(300), clear_expected(300);
  map_queries.clearance(links, poses, self, clear, 1.0);
  cell_queries.clearance(links, poses, self, clear_expected, 1.0);
  for (std::size_t i = 0; i < clear.size(); ++i)
    if (clear_expected[i] > 0) CHECK(clear[i] == Approx(clear_expected[i]).margin(1e-11));
}

TEST_CASE("configurations: poses that are made when they are looked at give the same answers") {
  World world(8, 60);
  const SceneQueries queries(world.scene);
  Random random(7);
  const std::vector<Shape> links{Capsule{0.2, 1}, Box{{0.4, 0.3, 0.8}}, random_shape(ShapeKind::mesh, random)};
  const PairTable self(3, 3, true);
  constexpr std::size_t a_motion = 5, motions = 120;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < links.size() * a_motion * motions; ++i) poses.push_back(random_pose(random, 7));
  std::vector<std::atomic<int>> made(poses.size());
  const BatchPoses when_needed(poses.size(), [&](std::size_t first, std::span<Pose> out) {
    for (std::size_t i = 0; i < out.size(); ++i, ++first) {
      out[i] = poses[first];
      ++made[first];
    }
  });
  for (const bool continuous : {false, true}) {
    BatchOptions options;
    options.configurations_a_motion = a_motion;
    options.continuous = continuous;
    std::vector<Verdict> lying(motions), meanwhile(motions);
    queries.check(links, poses, self, lying, options);
    queries.check(links, when_needed, self, meanwhile, options);
    CHECK(lying == meanwhile);
    CHECK(std::count(lying.begin(), lying.end(), Verdict::hit) > 0);
    CHECK(std::all_of(made.begin(), made.end(), [](const auto& times) { return times == 1; }));
    for (auto& times : made) times = 0;
  }
  std::vector<FirstHit> first(a_motion * motions), first_meanwhile(a_motion * motions);
  queries.first_hits(links, poses, self, first);
  queries.first_hits(links, when_needed, self, first_meanwhile);
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(first[i].verdict == first_meanwhile[i].verdict);
    CHECK(first[i].body == first_meanwhile[i].body);
  }
  std::vector<double> clearances(a_motion * motions), clearances_meanwhile(a_motion * motions);
  queries.clearance(links, poses, self, clearances);
  queries.clearance(links, when_needed, self, clearances_meanwhile);
  CHECK(clearances == clearances_meanwhile);
  const SceneQueries of_lying(world.scene), of_made(world.scene);
  tbb::task_arena one_thread(1);  // since memory belongs to threads
  one_thread.execute([&] {
    of_lying.clearance(links, poses, self, clearances);
    of_made.clearance(links, when_needed, self, clearances);
  });
  CHECK(of_made.memory() > of_lying.memory());

  CHECK(message_of([&] { BatchPoses(6, BatchPoses::Maker()); }).find("make is empty") != std::string::npos);
  const BatchPoses failing(poses.size(), [](std::size_t, std::span<Pose>) { throw std::domain_error("out of reach"); });
  std::vector<Verdict> verdicts(a_motion * motions);
  CHECK_THROWS_AS(queries.check(links, failing, self, verdicts), std::domain_error);
  const BatchPoses bad(poses.size(), [](std::size_t, std::span<Pose> out) {
    for (Pose& pose : out) pose.translation.x() = infinity;
  });
  CHECK(message_of([&] { queries.check(links, bad, self, verdicts); }).find("configuration ") != std::string::npos);
}

TEST_CASE("configurations: matrices row by row are read where they lie") {
  World world(8, 60);
  const SceneQueries queries(world.scene);
  Random random(8);
  const std::vector<Shape> links{Capsule{0.2, 1}, Box{{0.4, 0.3, 0.8}}, random_shape(ShapeKind::mesh, random)};
  const PairTable self(3, 3, true);
  constexpr std::size_t a_motion = 7, motions = 90;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < links.size() * a_motion * motions; ++i) poses.push_back(random_pose(random, 7));
  std::vector<double> numbers;
  for (const Pose& pose : poses) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) numbers.push_back(pose.rotation(row, column));
      numbers.push_back(pose.translation[row]);
    }
    numbers.insert(numbers.end(), {0, 0, 0, 1});
  }
  const BatchPoses matrices = BatchPoses::of_matrices(numbers);
  REQUIRE(matrices.size() == poses.size());
  for (const bool continuous : {false, true}) {
    BatchOptions options;
    options.configurations_a_motion = a_motion;
    options.continuous = continuous;
    std::vector<Verdict> lying(motions), rows(motions);
    queries.check(links, poses, self, lying, options);
    queries.check(links, matrices, self, rows, options);
    CHECK(lying == rows);
    CHECK(std::count(lying.begin(), lying.end(), Verdict::hit) > 0);
  }
  const std::size_t all = a_motion * motions;
  std::vector<Verdict> lying(all), rows(all);
  queries.check(links, poses, self, lying);
  queries.check(links, matrices, self, rows);
  CHECK(lying == rows);
  std::vector<FirstHit> first(all), first_rows(all);
  queries.first_hits(links, poses, self, first);
  queries.first_hits(links, matrices, self, first_rows);
  std::vector<double> clearances(all), clearances_rows(all);
  queries.clearance(links, poses, self, clearances);
  queries.clearance(links, matrices, self, clearances_rows);
  CHECK(clearances == clearances_rows);
  for (std::size_t i = 0; i < all; ++i) {
    CHECK(first[i].verdict == first_rows[i].verdict);
    CHECK(first[i].body == first_rows[i].body);
    CHECK(first[i].link == first_rows[i].link);
  }

  CHECK(message_of([&] { BatchPoses::of_matrices(std::span(numbers).first(17)); }).find("17 numbers") !=
        std::string::npos);
  const std::size_t bad = 3 * 401 + 2;
  const auto refusal = [&](std::size_t number, double value) {
    const double good = std::exchange(numbers[16 * bad + number], value);
    const std::string message = message_of([&] { queries.check(links, matrices, self, rows); });
    numbers[16 * bad + number] = good;
    return message;
  };
  for (const std::size_t number : {12u, 13u, 14u, 15u})
    CHECK(refusal(number, 0.5) == "poses: configuration 401, link 2: the last row of its matrix is not 0, 0, 0, 1");
  CHECK(refusal(12, std::nan("")).find("poses: configuration 401, link 2: the last row") == 0);
  CHECK(refusal(3, infinity).find("poses: configuration 401, link 2: translation[0]") == 0);
  CHECK(refusal(6, 2).find("poses: configuration 401, link 2: rotation") == 0);
}

TEST_CASE("configurations: a filter may wait for tasks of its own") {
  World world(8, 60);
  const SceneQueries queries(world.scene);
  Random random(6);
  const std::vector<Shape> links{Capsule{0.2, 1}, Box{{0.4, 0.3, 0.8}}};
  const PairTable self(2, 2, true);
  constexpr std::size_t a_motion = 5, motions = 200;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < 2 * a_motion * motions; ++i) poses.push_back(random_pose(random, 7));
  std::vector<Verdict> plain(motions), waiting(motions);
  std::vector<FirstHit> first(motions), first_waiting(motions);
  BatchOptions options;
  options.configurations_a_motion = a_motion;
  queries.check(links, poses, self, plain, options);
  queries.first_hits(links, poses, self, first, options);
  options.filter.admits = [](BodyId) {
    std::atomic<int> done{0};
    const auto spin = [&](int) {
      const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(30);
      while (std::chrono::steady_clock::now() < end) continue;
      ++done;
    };
    tbb::parallel_for(0, 4, spin, tbb::simple_partitioner());
    return done == 4;
  };
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  tbb::task_arena(4).execute([&] {
    queries.check(links, poses, self, waiting, options);
    queries.first_hits(links, poses, self, first_waiting, options);
  });
  CHECK(plain == waiting);
  for (std::size_t i = 0; i < motions; ++i)
    CHECK((first[i].body == first_waiting[i].body && first[i].link == first_waiting[i].link));
}

TEST_CASE("configurations: what the deadline or a stop leaves out is unknown, never free") {
  World world(2, 30);
  SceneQueries queries(world.scene);
  const std::vector<Shape> links{Sphere{0.1}};
  std::vector<Pose> poses(1000, Pose::at(0, 0, 100));
  std::vector<Verdict> verdicts(poses.size());
  std::vector<double> distances(poses.size());
  BatchOptions options;
  std::atomic<std::size_t> last{0};
  options.progress = [&](std::size_t done, std::size_t all) {
    CHECK(all == 1000);
    last = std::max<std::size_t>(last, done);
  };
  queries.check(links, poses, {}, verdicts, options);
  CHECK(last == 1000);
  CHECK(std::count(verdicts.begin(), verdicts.end(), Verdict::free) == 1000);
  options.progress = {};
  options.deadline = std::chrono::steady_clock::now();
  queries.check(links, poses, {}, verdicts, options);
  CHECK(std::count(verdicts.begin(), verdicts.end(), Verdict::unknown) == 1000);
  queries.clearance(links, poses, {}, distances, infinity, options);
  CHECK(std::count(distances.begin(), distances.end(), -infinity) == 1000);
  std::stop_source stop;
  stop.request_stop();
  options.deadline = std::chrono::steady_clock::time_point::max();
  options.stop = stop.get_token();
  queries.check(links, poses, {}, verdicts, options);
  CHECK(std::count(verdicts.begin(), verdicts.end(), Verdict::unknown) == 1000);
}

namespace {

/// A limit that ends at a given check, and counts the work between two checks and after the last.
struct CountedLimit {
  WorkLimit limit;
  QueryFilter filter;
  std::size_t end = std::numeric_limits<std::size_t>::max(), looks = 0, since = 0, most = 0, after = 0;

  CountedLimit() {
    limit.ended = [this] {
      most = std::max(most, since);
      since = 0;
      return ++looks >= end;
    };
    filter.admits = [this](BodyId) {
      ++since;
      after += looks >= end;
      return true;
    };
  }
  CountedLimit(const CountedLimit&) = delete;
  CountedLimit& operator=(const CountedLimit&) = delete;
  void begin(std::size_t at) { end = at, looks = since = most = after = 0; }
};

}  // namespace

TEST_CASE("queries: the limit is looked at every few bodies, and nothing is begun once it is reached") {
  Scene scene;
  Random random(55);
  const std::vector<Shape> kinds{Box{{1, 1, 1}}, Capsule{0.3, 1}, Cylinder{0.4, 1}, Sphere{0.5}};
  for (std::size_t i = 0; i < 3000; ++i)
    scene.add_body({.shape = scene.add_shape(kinds[i % 4]), .pose = random_pose(random, 1)});
  CountedLimit counted;
  const SceneQueries queries(scene, {.limit = &counted.limit});
  const Shape probe = Capsule{0.1, 0.5};
  const Pose pose = Pose::at(0.1, 0.2, 0.3);
  std::vector<BodyId> bodies;
  std::vector<Hit> hits;
  std::vector<ContactHit> contact_hits;
  std::vector<Contact> contacts;
  const std::vector<std::function<void()>> singles{
      [&] { queries.hits(probe, pose, bodies, counted.filter); },
      [&] { queries.within(probe, pose, 0.5, hits, counted.filter); },
      [&] { queries.nearest(probe, pose, infinity, counted.filter); },
      [&] { queries.contacts(probe, pose, 0.1, contact_hits, contacts, counted.filter); },
      [&] {
        queries.cast(probe, {Pose::at(-9, 0, 0), pose}, counted.filter);
      }};
  for (std::size_t i = 0; i < singles.size(); ++i) {
    CAPTURE(i);
    counted.begin(std::numeric_limits<std::size_t>::max());
    singles[i]();
    CHECK(counted.looks > 5);
    CHECK(counted.most <= 64);
    for (const std::size_t at : {1u, 4u}) {
      counted.begin(at);
      CHECK_THROWS_AS(singles[i](), WorkStopped);
      CHECK(counted.after == 0);
    }
  }

  const std::vector<Shape> links{probe, Box{{0.3, 0.3, 0.3}}};
  constexpr std::size_t configurations = 4000;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < 2 * configurations; ++i)
    poses.push_back(i % 40 < 38 ? Pose::at(50, 0, static_cast<double>(i % 2)) : random_pose(random, 1));
  std::vector<Verdict> verdicts(configurations), whole(configurations), motions(configurations / 20);
  std::vector<FirstHit> first(configurations);
  std::vector<double> distances(configurations);
  BatchOptions options, in_motions;
  options.filter = in_motions.filter = counted.filter;
  in_motions.configurations_a_motion = 20;
  counted.begin(std::numeric_limits<std::size_t>::max());
  tbb::task_arena(1).execute([&] { queries.check(links, poses, {}, whole, options); });  // each thread counts its own
  const auto unknown = [](const auto& all) { return std::count(all.begin(), all.end(), Verdict::unknown); };
  CHECK(unknown(whole) == 0);
  CHECK(counted.most <= 64);
  tbb::task_arena(1).execute([&] {
    for (const std::size_t at : {1u, 20u}) {
      // After the check that ends it: one check for each block under way, no work on a body.
      const auto ended = [&] { return counted.after == 0 && counted.looks <= at + 2; };
      counted.begin(at);
      queries.check(links, poses, {}, verdicts, options);
      CHECK(ended());
      CHECK(unknown(verdicts) > 100);
      for (std::size_t i = 0; i < configurations; ++i)
        if (verdicts[i] != Verdict::unknown) REQUIRE(verdicts[i] == whole[i]);
      counted.begin(at);
      queries.check(links, poses, {}, motions, in_motions);
      CHECK(ended());
      CHECK(unknown(motions) > 10);
      counted.begin(at);
      queries.first_hits(links, poses, {}, first, options);
      CHECK(ended());
      CHECK(std::any_of(first.begin(), first.end(), [](const FirstHit& h) { return h.verdict == Verdict::unknown; }));
      counted.begin(at);
      queries.clearance(links, poses, {}, distances, infinity, options);
      CHECK(ended());
      CHECK(std::count(distances.begin(), distances.end(), -infinity) > 100);
    }
  });
}

TEST_CASE("queries: a filter may ask the same scene of its own") {
  World world(12, 60);
  const SceneQueries queries(world.scene);
  Random random(3);
  const std::vector<Shape> links{Capsule{0.2, 1}, Box{{0.4, 0.3, 0.8}}}, others{Sphere{0.3}};
  const PairTable self(2, 2, true);
  std::vector<Pose> poses;
  for (int i = 0; i < 400; ++i) poses.push_back(random_pose(random, 6));
  std::vector<Verdict> plain(200), nested(200);
  queries.check(links, poses, self, plain);
  BatchOptions options;
  options.filter.admits = [&](BodyId) {
    Verdict inner = Verdict::unknown;
    queries.check(others, std::span(poses).first(1), {}, std::span(&inner, 1));
    return inner != Verdict::unknown;
  };
  queries.check(links, poses, self, nested, options);
  CHECK(plain == nested);
}

TEST_CASE("queries: a stop and the limit reach into pairs of meshes, and nothing of them is told") {
  Scene scene;
  Mesh grid;  // a grid of many triangles
  constexpr std::uint32_t n = 120;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) grid.vertices.emplace_back(i, j, std::sin(0.3 * i) * std::cos(0.2 * j));
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t at = i * (n + 1) + j;
      grid.triangles.push_back({at, at + n + 1, at + 1});
      grid.triangles.push_back({at + 1, at + n + 1, at + n + 2});
    }
  const Shape sheet(grid);
  scene.add_body({.shape = scene.add_shape(sheet)});
  const Pose above = Pose::at(0.3, 0.2, 2.5), through = Pose::at(0.3, 0.2, 0);
  const std::vector<Shape> links{sheet};
  const std::vector<Pose> poses{above};
  std::vector<Verdict> verdicts(1);
  std::vector<double> distances(1);
  SceneQueries queries(scene);
  std::stop_source stop;
  BatchOptions options;
  options.stop = stop.get_token();
  // The filter is the last callback before the pair is begun.
  options.filter.admits = [&](BodyId) { return stop.request_stop(), true; };
  queries.check(links, std::vector<Pose>{through}, {}, verdicts);
  CHECK(verdicts[0] == Verdict::hit);
  queries.check(links, std::vector<Pose>{through}, {}, verdicts, options);
  CHECK(verdicts[0] == Verdict::unknown);
  stop = std::stop_source();
  options.stop = stop.get_token();
  queries.clearance(links, poses, {}, distances, infinity, options);
  CHECK(distances[0] == -infinity);
  std::vector<FirstHit> hits(1);
  stop = std::stop_source();
  options.stop = stop.get_token();
  queries.first_hits(links, std::vector<Pose>{through}, {}, hits, options);
  CHECK(hits[0].verdict == Verdict::unknown);

  bool reached = false;
  WorkLimit limit;
  limit.ended = [&] { return reached; };
  const SceneQueries limited(scene, {.limit = &limit});
  const std::optional<Hit> whole = limited.nearest(sheet, above);
  REQUIRE(whole);
  reached = true;
  std::vector<Hit> within;
  std::vector<BodyId> bodies;
  std::vector<ContactHit> contact_hits;
  std::vector<Contact> contacts;
  CHECK_THROWS_AS(limited.nearest(sheet, above), WorkStopped);
  CHECK_THROWS_AS(limited.collides(sheet, through), WorkStopped);
  CHECK_THROWS_AS(limited.collides(sheet, above, 3.0), WorkStopped);
  CHECK_THROWS_AS(limited.hits(sheet, through, bodies), WorkStopped);
  CHECK_THROWS_AS(limited.within(sheet, above, 3.0, within), WorkStopped);
  CHECK_THROWS_AS(limited.contacts(sheet, through, 0, contact_hits, contacts), WorkStopped);
  CHECK_THROWS_AS(limited.cast(sheet, {above, through}), WorkStopped);
  limited.check(links, std::vector<Pose>{through}, {}, verdicts);
  CHECK(verdicts[0] == Verdict::unknown);
  reached = false;
  CHECK(limited.nearest(sheet, above)->answer.signed_distance == whole->answer.signed_distance);
}

TEST_CASE("queries: the limit ends the making of a mesh's hull, too") {
  Scene scene;
  scene.add_body({.shape = scene.add_shape(Box{{1, 1, 1}})});
  const Mesh ring = torus(1, 0.4, 60, 30);
  std::vector<Hit> hits;
  std::vector<BodyId> bodies;
  std::vector<ContactHit> contact_hits;
  std::vector<Contact> contacts;
  const std::vector<Pose> poses{Pose::at(9, 0, 0), Pose::at(8, 0, 0)};
  std::vector<Verdict> verdicts(2), motion(1);
  std::vector<FirstHit> first(2);
  std::vector<double> distances(2);
  BatchOptions continuous;
  continuous.configurations_a_motion = 2;
  continuous.continuous = true;
  using Ask = std::function<void(const SceneQueries&, const Shape&)>;
  const std::vector<Ask> singles{
      [&](const SceneQueries& q, const Shape& s) { q.collides(s, poses[0]); },
      [&](const SceneQueries& q, const Shape& s) { q.hits(s, poses[0], bodies); },
      [&](const SceneQueries& q, const Shape& s) { q.nearest(s, poses[0]); },
      [&](const SceneQueries& q, const Shape& s) { q.within(s, poses[0], 1, hits); },
      [&](const SceneQueries& q, const Shape& s) { q.contacts(s, poses[0], 1, contact_hits, contacts); },
      [&](const SceneQueries& q, const Shape& s) {
        q.cast(s, {poses[0], poses[1]});
      }};
  const std::vector<Ask> batches{
      [&](const SceneQueries& q, const Shape& s) { q.check(std::span(&s, 1), poses, {}, verdicts); },
      [&](const SceneQueries& q, const Shape& s) { q.check(std::span(&s, 1), poses, {}, motion, continuous); },
      [&](const SceneQueries& q, const Shape& s) { q.first_hits(std::span(&s, 1), poses, {}, first); },
      [&](const SceneQueries& q, const Shape& s) { q.clearance(std::span(&s, 1), poses, {}, distances); }};
  const auto unknown = [](Verdict v) { return v == Verdict::unknown; };
  constexpr int within_hull = 4;  // checks: a hull of 1,800 points takes more
  int looks = 0;
  WorkLimit limit;
  limit.ended = [&] { return ++looks >= within_hull; };
  const SceneQueries queries(scene, {.limit = &limit});
  for (const Ask& ask : singles) {
    const Shape fresh(ring);
    looks = 0;
    CHECK_THROWS_AS(ask(queries, fresh), WorkStopped);
    CHECK(looks == within_hull);
    CHECK(fresh.memory_by_part().hull == 0);
  }
  for (const Ask& ask : batches) {
    const Shape fresh(ring);
    looks = 0;
    ask(queries, fresh);
    CHECK(looks == within_hull);
    CHECK(fresh.memory_by_part().hull == 0);
  }
  CHECK(std::all_of(verdicts.begin(), verdicts.end(), unknown));
  CHECK(unknown(motion[0]));
  CHECK(unknown(first[0].verdict));
  CHECK(distances[0] == -infinity);
}

TEST_CASE("queries: an update makes meshes ready, so that no query makes anything of them") {
  Scene scene;
  const Shape ring(torus(1, 0.4, 40, 20)), tool(torus(0.5, 0.2, 30, 16));
  const BodyId body = scene.add_body({.shape = scene.add_shape(ring)});
  const SceneQueries queries(scene);
  const std::size_t hull = ring.memory_by_part().hull, all = ring.memory();
  CHECK(hull > 0);
  prepare(tool);
  const std::size_t of_tool = tool.memory();
  std::vector<ContactHit> hits;
  std::vector<Contact> contacts;
  const auto ask = [&](const Pose& pose) {
    queries.collides(tool, pose);
    queries.nearest(tool, pose);
    queries.contacts(tool, pose, 0.1, hits, contacts);
    queries.cast(tool, {Pose::at(9, 1, 0), pose});
  };
  for (const double x : {1.0, 1.7, 1.75, 2.4}) ask(Pose::at(x, 0.1, 0.2));
  CHECK(contacts.size() > 4);
  CHECK(ring.memory() == all);
  CHECK(tool.memory() == of_tool);
  CHECK(queries.nearest(body, 1) == std::nullopt);

  bool reached = true;
  WorkLimit limit;
  limit.ended = [&] { return reached; };
  const Shape fresh(torus(1, 0.4, 40, 20));
  CHECK_THROWS_AS(prepare(fresh, &limit), WorkStopped);
  reached = false;
  prepare(fresh, &limit);
  CHECK(fresh.memory() == all);
}

TEST_CASE("configurations: continuous motions see what lies between, and what they call free is free") {
  World world(77, 60);
  SceneQueries queries(world.scene);
  Random random(14);
  const std::vector<Shape> links{Capsule{0.1, 0.6}, Box{{0.2, 0.3, 0.4}}};
  PairTable self(2, 2, true);
  constexpr std::size_t a_motion = 4, motions = 300;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < motions; ++i) {
    Pose a = random_pose(random, 6), b = random_pose(random, 6);
    for (std::size_t k = 0; k < a_motion; ++k) {
      for (Pose* pose : {&a, &b}) {
        poses.push_back(*pose);
        pose->rotation = Eigen::AngleAxisd{random.in(0, 1), random.direction()}.toRotationMatrix() * pose->rotation;
        pose->translation += random.vec(-1, 1);
      }
    }
  }
  const NarrowPhase narrow;
  for (const double margin : {0.0, 0.1}) {
    BatchOptions options;
    options.configurations_a_motion = a_motion;
    options.margin = margin;
    std::vector<Verdict> sampled(motions), certified(motions), fine(20);
    queries.check(links, poses, self, sampled, options);
    options.continuous = true;
    queries.check(links, poses, self, certified, options);
    std::size_t between = 0, free = 0;
    for (std::size_t i = 0; i < motions; ++i) {
      CAPTURE(i, margin);
      if (sampled[i] == Verdict::hit) {
        CHECK(certified[i] == Verdict::hit);
        continue;
      }
      free += certified[i] == Verdict::free;
      bool hit = false;
      for (std::size_t k = 0; k + 1 < a_motion; ++k) {
        const Pose* at = &poses[(i * a_motion + k) * 2];
        for (int t = 0; t <= 400 && !hit; ++t) {
          const Pose a = pose_at({at[0], at[2]}, t / 400.0), b = pose_at({at[1], at[3]}, t / 400.0);
          hit = queries.collides(links[0], a, margin) || queries.collides(links[1], b, margin) ||
                narrow.solve(links[0], a, links[1], b, Request::distance).signed_distance <= margin;
        }
      }
      if (hit) CHECK(certified[i] == Verdict::hit);
      between += hit;
    }
    CHECK(between >= 3);
    CHECK(free > 20);
  }
  BatchOptions one;
  one.continuous = true;
  std::vector<Verdict> verdicts(motions * a_motion);
  CHECK(message_of([&] { queries.check(links, poses, self, verdicts, one); }).find("continuous") != std::string::npos);
}

TEST_CASE("a cast meets the body that sampling meets first") {
  World world(31, 80);
  SceneQueries queries(world.scene);
  Random random(8);
  const NarrowPhase narrow;
  int hits = 0, free = 0;
  for (int i = 0; i < 150; ++i) {
    const Shape shape = i % 3 == 0 ? Shape(Sphere{0}) : asking(random);
    Motion motion{random_pose(random, 7), random_pose(random, 7)};
    if (i % 2 == 0) motion.to.rotation = motion.from.rotation;
    const auto impact = queries.cast(shape, motion);
    CAPTURE(i, name(shape.kind()));
    const double end = impact ? impact->t : 1;
    for (int k = 0; k < 200; ++k) {
      const double t = end * k / 200;
      REQUIRE((t >= end || !queries.collides(shape, pose_at(motion, t))));
    }
    if (!impact) {
      ++free;
      continue;
    }
    ++hits;
    const auto there = narrow.solve(shape, pose_at(motion, impact->t), world.scene.shape_of(impact->body.index()),
                                    world.scene.pose(impact->body), Request::distance);
    CHECK(there.signed_distance < 1e-8);
    if (impact->t > 0) CHECK(there.signed_distance > -1e-8);
    if (impact->t > 0) CHECK(std::abs(impact->normal.norm() - 1) < 1e-12);
  }
  CHECK(hits > 40);
  CHECK(free > 5);
}

TEST_CASE("a cast finds what the pair's time of impact does where it begins at a touch") {
  Scene scene;
  const Shape sheet(Triangle{{Vec3{-1, -1, 0}, Vec3{2, -1, 0}, Vec3{-1, 2, 0}}}), point(Sphere{0});
  scene.add_body({.shape = scene.add_shape(sheet), .is_static = true});
  SceneQueries queries(scene);
  const NarrowPhase narrow;
  const auto turned = [](double angle, const Vec3& at) {
    return Pose::from(Quat(std::cos(angle / 2), 0, 0, std::sin(angle / 2)), at);
  };
  int touch = 0, free = 0;
  for (const double angle : {0.0, 1.0})
    for (const double gap : {1e-13, 8e-12, 1e-11, 1.2e-11, 2e-11, 5e-11, 1e-10, 1e-9}) {
      const Motion along{Pose::at(0, 0, gap), turned(angle, {.1, 0, gap})},
          up{Pose::at(0, 0, gap), turned(angle, {0, 0, .1 + gap})};
      for (const Motion& motion : {along, up}) {
        const auto pair = narrow.time_of_impact(point, motion, sheet, {Pose{}, Pose{}});
        const auto cast = queries.cast(point, motion);
        CAPTURE(angle, gap);
        CHECK(bool(pair) == bool(cast));
        if (pair && cast) CHECK(pair->t == cast->t);
        ++(pair ? touch : free);
      }
    }
  CHECK(touch > 5);
  CHECK(free > 5);
}

TEST_CASE("boxes about moving shapes contain what is within their share of a touch") {
  const Shape sheet(Triangle{{Vec3{-1, -1, 0}, Vec3{2, -1, 0}, Vec3{-1, 2, 0}}}), point(Sphere{0});
  const double gap = touch_share(sheet) + touch_share(point, .1);
  CHECK(gap > 1e-11);
  const Motion motion{Pose::at(0, 0, gap), Pose::at(.1, 0, gap)};
  const Aabb still = swept_box(sheet, {Pose{}, Pose{}}), moving = swept_box(point, motion);
  CHECK(moving.lo[2] <= still.hi[2]);
  const SweptBoxes swept(point, motion);
  for (std::size_t i = 0; i < swept.size(); ++i) CHECK(swept.box(i).lo[2] <= still.hi[2]);
}
