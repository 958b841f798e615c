// The limit of the work on a pair: where it is reached the pair ends, reports it, and leaves nothing behind.
#include "tandem/narrowphase/work_limit.h"

#include <semaphore>
#include <thread>

#include "catch.h"
#include "manifold/patch_collector.h"
#include "mesh_samples.h"
#include "meshes/traversal/point_queries.h"
#include "random.h"
#include "shapes/lazily.h"
#include "shapes/metered_sort.h"
#include "shapes/shape_insides.h"
#include "shapes/support_map.h"
#include "shapes/work_meter.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::test;

namespace {

/// Two placed shapes for which every request checks the limit many times.
struct Pair {
  Shape a, b;
  Pose at_a, at_b;
};

Pose turned(double x, double y, double z) {
  Pose pose = Pose::from(Quat(0.9, 0.1, 0.3, 0.2), {x, y, z});
  return pose;
}

std::vector<Pair> pairs() {
  const Shape ring{torus(1, 0.4, 120, 60)}, small{torus(0.8, 0.3, 80, 60)};
  return {{ring, small, {}, turned(0.4, 0.3, 0.2)},
          {ring, small, {}, turned(2.6, 0.1, 0.2)},
          {ring, Ellipsoid{{0.8, 0.5, 1.2}}, {}, turned(0.8, 0.2, 0.1)}};
}

/// The result of a query, in numbers.
using Told = std::vector<double>;

Told told(const PairAnswer& answer, const std::vector<Contact>& contacts) {
  Told out{answer.collide ? 1.0 : 0.0, answer.signed_distance, answer.error_bound, answer.normal.x(),
           answer.point_a.x()};
  for (const Contact& c : contacts) out.insert(out.end(), {c.point.x(), c.point.y(), c.normal.z(), c.depth});
  return out;
}

/// A query; empty if it was stopped.
using Ask = std::function<Told(const NarrowPhase&, const Pair&)>;

Ask ask(Request request) {
  return [=](const NarrowPhase& narrow, const Pair& p) {
    std::vector<Contact> contacts(1);
    const PairAnswer answer = narrow.solve(p.a, p.at_a, p.b, p.at_b, request, &contacts);
    if (answer.status != Status::stopped) return told(answer, contacts);
    CHECK(contacts.size() == 1);
    CHECK(!answer.collide);
    CHECK(std::isinf(answer.error_bound));
    return Told{};
  };
}

template <class Body>
Ask unless_thrown(Body body) {
  return [=](const NarrowPhase& narrow, const Pair& p) {
    try {
      return body(narrow, p);
    } catch (const WorkStopped&) {
      return Told{};
    }
  };
}

std::vector<std::pair<const char*, Ask>> questions() {
  const auto far = [](const Pair& p) {
    Pose pose = p.at_b;
    pose.translation += Vec3(5, 1, 0.3);
    return pose;
  };
  return {{"collide", ask(Request::collide)},
          {"distance", ask(Request::distance)},
          {"contacts", ask(Request::contacts)},
          {"distance within", unless_thrown([](const NarrowPhase& narrow, const Pair& p) {
             return told(unless_stopped(narrow.distance_within(p.a, p.at_a, p.b, p.at_b, 0.9)), {});
           })},
          {"triangles", unless_thrown([](const NarrowPhase& narrow, const Pair& p) {
             Told out{-1};
             if (p.b.kind() != ShapeKind::mesh) return out;
             for (const auto& [i, j] : narrow.intersecting_triangles(p.a, p.at_a, p.b, p.at_b))
               out.push_back(i * 1e6 + j);
             return out;
           })},
          {"time of impact", unless_thrown([=](const NarrowPhase& narrow, const Pair& p) {
             const auto t = narrow.time_of_impact(p.a, p.at_a, Vec3::Zero(), p.b, far(p), Vec3(-5, -1, -0.3), 1);
             return Told{t.value_or(-1)};
           })},
          {"time of impact of what turns", unless_thrown([=](const NarrowPhase& narrow, const Pair& p) {
             Pose from = far(p);
             from.rotation = from.rotation * Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
             const auto touch = narrow.time_of_impact(p.a, {p.at_a, p.at_a}, p.b, Motion{from, p.at_b});
             return touch ? Told{touch->t, touch->point.x()} : Told{-1};
           })}};
}

}  // namespace

TEST_CASE("work limit: every request of meshes ends where it is reached, and the next one is right") {
  long most = 0;
  for (const Pair& pair : pairs())
    for (const auto& [what, question] : questions()) {
      CAPTURE(what, pair.b.kind());
      const Told whole = question(NarrowPhase(), pair);
      REQUIRE(!whole.empty());
      long looks = 0, last = std::numeric_limits<long>::max();
      WorkLimit limit;
      limit.ended = [&] { return ++looks >= last; };
      const NarrowPhase narrow({.limit = &limit});
      CHECK(question(narrow, pair) == whole);
      const long all = looks;
      most = std::max(most, all);
      for (const long at : {1L, 2L, all / 4, all / 2, all - 1}) {
        if (at < 1 || at > all) continue;
        looks = 0, last = at;
        CHECK(question(narrow, pair).empty());
        CHECK(looks == at);  // no further work that checks
      }
      last = std::numeric_limits<long>::max();
      CHECK(question(narrow, pair) == whole);
    }
  CHECK(most > 200);
}

TEST_CASE("work limit: a look comes after no more than some hundred nodes or triangles") {
  long looks = 0;
  WorkLimit limit;
  limit.ended = [&] { return ++looks, false; };
  const NarrowPhase narrow({.limit = &limit});
  const Pair pair = pairs()[0];
  const std::size_t found = narrow.intersecting_triangles(pair.a, pair.at_a, pair.b, pair.at_b).size();
  REQUIRE(found > 500);
  CHECK(looks > static_cast<long>(found / 256));
}

TEST_CASE("work limit: long sorts, wide patches and searches by a point look at it") {
  constexpr int most_between = 65 * 16;  // comparisons
  int looks = 0, since = 0, most = 0;
  WorkLimit limit;
  limit.deadline = std::chrono::steady_clock::now() + std::chrono::hours(24);
  limit.ended = [&] {
    most = std::max(most, since);
    return since = 0, ++looks, false;
  };
  reference::Random random(8);
  std::vector<double> numbers(20'000);
  for (double& x : numbers) x = random.in(0, 1);
  WorkMeter meter(&limit);
  sort_metered(meter, numbers.begin(), numbers.end(), [&](double x, double y) { return ++since, x < y; });
  CHECK(std::is_sorted(numbers.begin(), numbers.end()));
  CHECK(looks > 100);
  CHECK(most <= most_between);

  std::vector<Contact> contacts, plain;
  for (int i = 0; i < 5000; ++i)
    contacts.push_back({Vec3{random.in(0, 1), random.in(0, 1), 0}, Vec3::UnitZ(), random.in(0, 1), 0});
  plain = contacts;
  looks = 0;
  keep_widest(contacts, 0, 1, &meter);
  CHECK(looks > 20);
  keep_widest(plain, 0, 1);
  REQUIRE(contacts.size() == plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) CHECK(contacts[i].point == plain[i].point);

  const Shape ring{torus(1, 0.4, 120, 60)};
  looks = 0;
  nearest_point(mesh_of(ring), Vec3(0.01, 0.02, 0.03), &limit);  // all of its inner side is about equally near
  CHECK(looks > 10);
  looks = 0;
  first_crossing(mesh_of(ring), Vec3(1, 0, 0), Vec3::UnitX(), &limit);
  CHECK(looks > 0);
}

TEST_CASE("work limit: a stop that another thread requests within a pair ends it") {
  for (const Pair& pair : pairs()) {
    std::stop_source source;
    std::binary_semaphore within(0), requested(0);
    std::jthread other([&] {
      within.acquire();
      source.request_stop();
      requested.release();
    });
    int looks = 0;
    WorkLimit limit;
    limit.stop = source.get_token();
    limit.ended = [&] {
      if (++looks == 3) within.release(), requested.acquire();
      return false;
    };
    const NarrowPhase narrow({.limit = &limit});
    const PairAnswer answer = narrow.solve(pair.a, pair.at_a, pair.b, pair.at_b, Request::distance);
    CHECK(answer.status == Status::stopped);
    CHECK(looks == 3);
  }
}

TEST_CASE("work limit: parts of a pair that are shared end, too") {
  const Shape ring{torus(1, 0.4, 160, 80)};
  const Pose at = turned(0.4, 0.3, 0.2);
  int parts_run = 0, looks = 0;
  WorkLimit limit;
  const auto runner = [&](std::size_t parts, const std::function<void(std::size_t)>& part) {
    for (std::size_t i = 0; i < parts; ++i) ++parts_run, part(i);
  };
  const NarrowPhase narrow({.parts = runner, .limit = &limit});
  std::vector<Contact> contacts;
  narrow.solve(ring, {}, ring, at, Request::contacts, &contacts);
  const int all = parts_run;
  REQUIRE(all >= 64);
  contacts.clear();
  parts_run = 0;
  limit.ended = [&] { return ++looks > 20; };
  CHECK(narrow.solve(ring, {}, ring, at, Request::contacts, &contacts).status == Status::stopped);
  CHECK(contacts.empty());
  CHECK((parts_run > 0 && parts_run < all / 2));
}

TEST_CASE("work limit: a deadline that has passed stops meshes, two convex shapes are solved") {
  WorkLimit limit;
  limit.deadline = std::chrono::steady_clock::now();
  const NarrowPhase narrow({.limit = &limit});
  for (const Pair& pair : pairs())
    CHECK(narrow.solve(pair.a, pair.at_a, pair.b, pair.at_b, Request::collide).status == Status::stopped);
  CHECK(narrow.solve(Sphere{1}, {}, Sphere{1}, Pose::at(3, 0, 0), Request::distance).signed_distance == 1);
  limit.deadline = std::chrono::steady_clock::time_point::max();
  CHECK(narrow.solve(pairs()[0].a, {}, pairs()[0].b, pairs()[0].at_b, Request::collide).collide);
}

TEST_CASE("work limit: a ray through a corner of many triangles looks at it while they are decided exactly") {
  // A double cone of 200 sides: the ray from its centre along z meets the apex, where no filter decides.
  constexpr std::uint32_t sides = 200;
  Mesh mesh{.vertices = {{0, 0, 1}, {0, 0, -1}}, .triangles = {}, .solid = true};
  for (std::uint32_t k = 0; k < sides; ++k) {
    const double angle = 2 * std::acos(-1.0) * k / sides;
    mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), 0);
    const std::uint32_t here = 2 + k, next = 2 + (k + 1) % sides;
    mesh.triangles.push_back({0, here, next});
    mesh.triangles.push_back({1, next, here});
  }
  const Shape cones{mesh}, ball{Sphere{0.5}};
  NarrowPhase().solve(cones, {}, ball, {}, Request::distance);  // data computed once are then there
  int looks = 0, most = 1'000'000;
  WorkLimit limit;
  limit.ended = [&] { return ++looks > most; };
  const NarrowPhase narrow({.limit = &limit});
  const PairAnswer whole = narrow.solve(cones, {}, ball, {}, Request::distance);
  CHECK(whole.status != Status::stopped);
  const int all = looks;
  CHECK(all > static_cast<int>(sides) / 2);
  for (most = 1; most < all; most += all / 7) {
    looks = 0;
    CHECK(narrow.solve(cones, {}, ball, {}, Request::distance).status == Status::stopped);
  }
}

TEST_CASE("work limit: a mesh's hull is built as far as the limit lets, and the next query builds it whole") {
  const Mesh rough = [] {
    Mesh mesh = torus(1, 0.4, 160, 80);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
      mesh.vertices[i] *= 1 + 1e-3 * std::sin(static_cast<double>(7 * i));
    return mesh;
  }();
  const Shape whole(rough);
  const Hull& expected = mesh_of(whole).hull();
  const auto same = [&](const Hull& hull) {
    return hull.vertices == expected.vertices && hull.loop == expected.loop && hull.neighbours == expected.neighbours;
  };
  long looks = 0, last = std::numeric_limits<long>::max();
  WorkLimit limit;
  limit.ended = [&] { return ++looks >= last; };
  CHECK(same(mesh_of(Shape(rough)).hull(&limit)));
  const long all = looks;
  // A check every few new faces, so that no stop waits for the hull.
  CHECK(all > static_cast<long>(expected.faces.size() / 64));
  for (const long at : {1L, 2L, all / 10, all / 2, all - 5}) {
    const Shape shape(rough);
    looks = 0, last = at;
    CHECK_THROWS_AS(mesh_of(shape).hull(&limit), WorkStopped);
    CHECK(looks <= at + 1);  // Qhull checks, and does not come to the next check
    CHECK(shape.memory_by_part().hull == 0);
    CHECK(same(mesh_of(shape).hull()));
  }
  // By a query that needs it, and by a box.
  const Shape shape(rough);
  looks = 0, last = 3;
  const NarrowPhase narrow({.limit = &limit});
  CHECK(narrow.solve(shape, {}, HalfSpace{}, {}, Request::distance).status == Status::stopped);
  CHECK(shape.memory_by_part().hull == 0);
  CHECK_THROWS_AS(shape.bounds({}, &limit), WorkStopped);
  CHECK(shape.bounds({}).hi == whole.bounds({}).hi);
}

TEST_CASE("work limit: who waits for what another thread makes goes by its own limit") {
  const Lazily<int> value;
  std::binary_semaphore begun(0), waited(0);
  std::jthread maker([&] {
    value.get(nullptr, [&](const WorkLimit*) {
      begun.release();
      CHECK(waited.try_acquire_for(std::chrono::seconds(60)));
      return 7;
    });
  });
  begun.acquire();
  WorkLimit limit;
  int looks = 0;
  limit.ended = [&] { return ++looks == 3; };
  const auto other = [](const WorkLimit*) { return 8; };
  CHECK_THROWS_AS(value.get(&limit, other), WorkStopped);
  CHECK(looks == 3);
  CHECK(value.made() == nullptr);
  waited.release();
  CHECK(value.get(nullptr, other) == 7);
}

TEST_CASE("work limit: what ends while it is made leaves nothing, and the next who asks makes it") {
  const Lazily<int> value;
  CHECK_THROWS_AS(value.get(nullptr, [](const WorkLimit*) -> int { throw WorkStopped(); }), WorkStopped);
  CHECK(value.made() == nullptr);
  CHECK(value.get(nullptr, [](const WorkLimit*) { return 7; }) == 7);
}

TEST_CASE("work limit: its function may ask the mesh whose hull is being made") {
  const Mesh ring = torus(1, 0.4, 60, 30);
  const Shape expected(ring);
  const Shape shape(ring);
  int looks = 0;
  WorkLimit limit;
  limit.ended = [&] {
    if (++looks == 5) CHECK(shape.bounds({}).hi == expected.bounds({}).hi);
    return false;
  };
  CHECK(mesh_of(shape).hull(&limit).vertices == mesh_of(expected).hull().vertices);
  CHECK(looks >= 5);
}

TEST_CASE("work limit: a search table of thousands of vertices is made with looks at it") {
  std::vector<Vec3> points;
  for (int i = 0; i < 4000; ++i) {
    const double z = 1 - (2 * i + 1) / 4000.0, turn = 2.399963 * i, r = std::sqrt(1 - z * z);
    points.emplace_back(r * std::cos(turn), r * std::sin(turn), z);
  }
  long looks = 0, last = std::numeric_limits<long>::max();
  WorkLimit limit;
  limit.ended = [&] { return ++looks >= last; };
  WorkMeter meter(&limit);
  const SupportMap whole(points, Vec3::Zero(), meter);
  CHECK(whole.chambers().size() == 64);
  CHECK(looks > 8);  // eight octants, all vertices each
  looks = 0, last = 5;
  CHECK_THROWS_AS(SupportMap(points, Vec3::Zero(), meter), WorkStopped);
}

TEST_CASE("work limit: two large hulls deep in each other look at it while their polytope grows") {
  std::vector<Vec3> points;
  for (int i = 0; i < 4000; ++i) {
    const double z = 1 - (2 * i + 1) / 4000.0, turn = 2.399963 * i, r = std::sqrt(1 - z * z);
    points.push_back({1.1 * r * std::cos(turn), 1.05 * r * std::sin(turn), z});
  }
  const Shape a{Convex{points}}, b = a;
  const Pose at = turned(1e-3, 2e-3, 1e-3);
  long looks = 0, last = std::numeric_limits<long>::max();
  WorkLimit limit;
  limit.ended = [&] { return ++looks >= last; };
  const NarrowPhase narrow({.limit = &limit}), free;
  const PairAnswer expected = free.solve(a, {}, b, at, Request::distance);
  const PairAnswer whole = narrow.solve(a, {}, b, at, Request::distance);
  CHECK(whole.signed_distance == expected.signed_distance);
  CHECK(whole.normal == expected.normal);
  const long all = looks;
  CAPTURE(all);
  REQUIRE(all > 2);
  for (const long end : {1L, all / 2, all}) {
    looks = 0, last = end;
    CHECK(narrow.solve(a, {}, b, at, Request::distance).status == Status::stopped);
    CHECK(looks == end);
  }
}
