// Building meshes: the same on any number of threads, with progress, ended by limits, and only what was asked for.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <exception>
#include <mutex>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "part_runners.h"
#include "shapes/mesh_builder.h"
#include "shapes/mesh_frame.h"
#include "shapes/shape_insides.h"
#include "shapes/vertex_weld.h"
#include "shapes/without_hull.h"
#include "tandem/narrowphase/build_options.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/shape_memory.h"

using namespace tandem;
using namespace tandem::test;
using Catch::Matchers::Contains;

namespace {

// Every third part on another thread; rethrows exceptions.
const PartRunner on_throwing_threads = [](std::size_t parts, const std::function<void(std::size_t)>& part) {
  std::mutex lock;
  std::exception_ptr thrown;
  std::vector<std::thread> threads;
  for (std::size_t first = 0; first < 3; ++first)
    threads.emplace_back([&, first] {
      try {
        for (std::size_t k = first; k < parts; k += 3) part(k);
      } catch (...) {
        const std::scoped_lock held(lock);
        thrown = std::current_exception();
      }
    });
  for (std::thread& thread : threads) thread.join();
  if (thrown) std::rethrow_exception(thrown);
};

// More triangles than one thread takes.
Mesh large(bool solid) {
  Mesh mesh = torus(1, 0.4, 200, 160);
  mesh.solid = solid;
  return mesh;
}

// Each triangle with its own corners, moved by up to so many units in the last place; every third reversed.
Mesh soup(const Mesh& mesh, int ulps, bool turned) {
  Mesh out;
  std::mt19937 random(7);
  for (const auto& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(out.vertices.size());
    for (const std::uint32_t v : t) {
      Vec3 p = mesh.vertices[v];
      for (double& x : p) x += (static_cast<double>(random() % (2 * static_cast<unsigned>(ulps) + 1)) - ulps) * 1e-16;
      out.vertices.push_back(p);
    }
    out.triangles.push_back({first, first + 1, first + 2});
    if (turned && random() % 3 == 0) std::swap(out.triangles.back()[1], out.triangles.back()[2]);
  }
  return out;
}

// Every triangle twice: four at each edge.
Mesh doubled(Mesh mesh) {
  mesh.triangles.insert(mesh.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
  return mesh;
}

template <class List>
bool same_bytes(const List& a, const List& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

std::string refusal(const Mesh& mesh, const PartRunner& parts) {
  try {
    const Shape shape(mesh, parts);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("building: which triangles lie side by side is the same on any number of threads") {
  const Mesh ring = large(false);
  for (const Mesh& input :
       {large(true), soup(ring, 0, false), soup(ring, 2, false), soup(ring, 2, true), doubled(ring)}) {
    const MeshModel alone = build_mesh(input);
    CHECK(alone.closed);
    for (const PartRunner& runner : {backwards, on_throwing_threads}) {
      const MeshModel shared = build_mesh(input, {.parts = runner});
      CHECK(same_bytes(shared.neighbours(), alone.neighbours()));
      CHECK(same_bytes(shared.triangles, alone.triangles));
      CHECK(same_bytes(shared.representatives, alone.representatives));
      CHECK(same_bytes(shared.order, alone.order));
      CHECK(same_bytes(shared.blocks, alone.blocks));
      CHECK(same_bytes(shared.components(), alone.components()));
      CHECK(shared.components().size() == 1);
      CHECK(shared.closed);
    }
  }
}

TEST_CASE("mesh building: of large meshes what needs no hull makes none, and answers as with one") {
  const Mesh large = test::torus(1, 0.3, 768, 192), small = test::torus(1, 0.3, 384, 96);
  REQUIRE(large.triangles.size() >= triangles_without_hull);
  REQUIRE(small.triangles.size() < triangles_without_hull);
  const Shape of_large(large), of_small(small);
  const Pose home{};
  const NarrowPhase narrow_phase;
  for (const bool meet : {false, true}) {
    const Pose pose = meet ? Pose::at(1.2, 0.3, 0.1) : Pose::at(2.7, 0, 0);
    CHECK(narrow_phase.solve(of_large, home, of_small, pose, Request::collide).collide == meet);
    CHECK(narrow_phase.intersecting_triangles(of_large, home, of_small, pose).empty() != meet);
    CHECK(narrow_phase.solve(of_large, home, Sphere{0.31}, pose, Request::collide).collide == meet);
  }
  const Bounds box = of_large.bounds(home), same = of_small.bounds(home);
  CHECK((box.lo - same.lo).norm() < 1e-3);
  CHECK((box.hi - same.hi).norm() < 1e-3);
  CHECK(!mesh_of(of_large).is_hull_made());
  CHECK(mesh_of(of_small).is_hull_made());
}

TEST_CASE("building: of vertices with equal coordinates the first stands for all") {
  std::mt19937 random(5);
  std::vector<Vec3> vertices;
  for (int i = 0; i < 60'000; ++i) {
    const auto some = [&] {
      return static_cast<double>(static_cast<int>(random() % 41) - 20) * (random() % 2 == 0 ? 0.25 : -0.25);
    };
    const double x = some(), y = some();
    vertices.emplace_back(x, y, some());
  }
  const std::vector<std::uint32_t> first = weld(vertices);
  std::vector<std::uint32_t> order(vertices.size());
  for (std::uint32_t v = 0; v < order.size(); ++v) order[v] = v;
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return std::lexicographical_compare(vertices[i].begin(), vertices[i].end(), vertices[j].begin(), vertices[j].end());
  });
  std::size_t wrong = 0;
  for (std::size_t k = 0, begin = 0; k < order.size(); ++k) {
    if (vertices[order[k]] != vertices[order[begin]]) begin = k;
    wrong += first[order[k]] != order[begin];
  }
  CHECK(wrong == 0);
  CHECK(std::count(vertices.begin(), vertices.end(), Vec3(0, 0, 0)) > 0);  // of any signs
  CHECK(weld(vertices, backwards) == first);
  CHECK(weld(vertices, on_throwing_threads) == first);
}

TEST_CASE("building: the first fault is told, on any number of threads") {
  Mesh beyond = large(true);
  beyond.triangles[20'000][1] = 1'000'000;
  beyond.triangles[50'000][0] = 2'000'000;
  Mesh open = large(true);
  open.triangles.erase(open.triangles.begin() + 40'000);
  open.triangles.erase(open.triangles.begin() + 100);
  Mesh inward = large(true);
  for (auto& t : inward.triangles) std::swap(t[0], t[1]);
  CHECK_THAT(refusal(beyond, {}), Contains("triangles[20000][1] is 1000000"));
  CHECK_THAT(refusal(open, {}), Contains("the edge ("));
  CHECK_THAT(refusal(inward, {}), Contains("volume"));
  for (const Mesh& mesh : {beyond, open, inward})
    for (const PartRunner& runner : {backwards, on_throwing_threads}) CHECK(refusal(mesh, runner) == refusal(mesh, {}));
}

TEST_CASE("building: ended at any moment it throws, and the next is whole") {
  const Mesh input = large(true);
  for (const PartRunner& runner : {PartRunner(), on_throwing_threads}) {
    std::atomic<int> looks{0};
    WorkLimit limit;
    int last = 0;
    limit.ended = [&] { return ++looks > last; };
    BuildOptions options{runner, &limit, {}};
    for (last = 0; last < 32; last = 2 * last + 1) {
      looks = 0;
      CHECK_THROWS_AS(Shape(input, options), WorkStopped);
    }
    last = 1'000'000, looks = 0;
    const Shape whole(input, options);
    CHECK(looks > 32);  // in every pass, every some thousand triangles
    CHECK(whole.triangles().size() == input.triangles.size());
  }
  WorkLimit late;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  CHECK_THROWS_AS(Shape(torus(1, 0.4, 8, 8), BuildOptions{{}, &late, {}}), WorkStopped);
}

TEST_CASE("building: progress rises to 1, one call at a time, and may end it") {
  const Mesh input = large(true);
  for (const PartRunner& runner : {PartRunner(), backwards, on_throwing_threads}) {
    std::vector<double> told;
    std::atomic<bool> inside{false};
    std::atomic<int> together{0};
    BuildOptions options{runner, nullptr, [&](double part) {
                           together += inside.exchange(true) ? 1 : 0;
                           told.push_back(part);
                           std::this_thread::sleep_for(std::chrono::milliseconds(1));  // other threads come meanwhile
                           inside = false;
                         }};
    const Shape shape(input, options);
    CHECK(together == 0);
    CHECK(told.size() >= 5);
    CHECK(told.size() <= 101);
    CHECK(told.front() > 0);
    CHECK(std::adjacent_find(told.begin(), told.end(), std::greater_equal<>()) == told.end());
    CHECK(told.back() == 1);
    CHECK(std::count(told.begin(), told.end(), 1.0) == 1);
    options.progress = [](double part) {
      if (part > 0.5) throw std::runtime_error("enough");
    };
    CHECK_THROWS_WITH(Shape(input, options), "enough");
  }
  std::vector<double> told;
  const Shape small(torus(1, 0.4, 3, 3), BuildOptions{{}, nullptr, [&](double part) { told.push_back(part); }});
  CHECK(told.back() == 1);
}

TEST_CASE("building: adjacency, hull and mass are made when they are asked for, once, by whichever thread asks") {
  const Mesh input = large(true);
  const Shape shape(input), other(input);
  const ShapeMemory before = shape.memory_by_part();
  CHECK(before.hull == 0);
  CHECK(before.total() == shape.memory());
  CHECK(before.surface >= input.vertices.size() * sizeof(Vec3) + input.triangles.size() * 12);
  CHECK(before.adjacency == 0);
  CHECK(before.hierarchy > 60 * input.triangles.size());

  std::array<MassProperties, 8> mass{};
  std::array<const Hull*, 8> hull{};
  std::array<const std::vector<MeshModel::Component>*, 8> components{};
  std::array<Bounds, 8> bounds{};
  std::array<const MeshModel::Neighbours*, 8> neighbours{};
  on_throwing_threads(8, [&](std::size_t k) {
    const Shape copy = shape;
    mass[k] = copy.mass();
    hull[k] = &mesh_of(copy).hull();
    components[k] = &mesh_of(copy).components();
    bounds[k] = copy.bounds(Pose::at(1, 2, 3));
    neighbours[k] = &mesh_of(copy).neighbours();
  });
  for (std::size_t k = 1; k < 8; ++k) {
    CHECK(mass[k].volume == mass[0].volume);
    CHECK(mass[k].inertia == mass[0].inertia);
    CHECK(hull[k] == hull[0]);
    CHECK(components[k] == components[0]);
    CHECK(bounds[k].lo == bounds[0].lo);
    CHECK(neighbours[k] == neighbours[0]);
  }
  CHECK(mass[0].volume == other.mass().volume);
  CHECK(mass[0].inertia == other.mass().inertia);
  CHECK(shape.memory_by_part().hull > 0);
  CHECK(shape.memory_by_part().adjacency >= input.triangles.size() * 12);
  CHECK(shape.memory_by_part().hierarchy == before.hierarchy);
  CHECK(shape.memory() > before.total());
}

TEST_CASE("building: a limit ends the making of adjacency, and who asks next makes it") {
  const Shape shape(large(true));
  int looks = 0;
  const WorkLimit limit{.ended = [&] { return ++looks == 3; }};
  CHECK_THROWS_AS(mesh_of(shape).neighbours(&limit), WorkStopped);
  CHECK(looks == 3);
  CHECK(shape.memory_by_part().adjacency == 0);
  const MeshModel& mesh = mesh_of(shape);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& back = mesh.triangles[mesh.neighbours()[t][k]];
      CHECK(std::find(back.begin(), back.end(), mesh.triangles[t][k]) != back.end());
    }
}

TEST_CASE("building: a shape's identity is its copies', and no other's") {
  const Mesh input = torus(1, 0.4, 12, 8);
  const Shape shape(input), other(input);
  const Shape copy = shape, round = shape.rounded(0.1);
  CHECK(copy.identity() == shape.identity());
  CHECK(other.identity() != shape.identity());
  CHECK(round.identity() != shape.identity());
  CHECK(round.mass().volume == shape.mass().volume);
  const Shape ball = Sphere{1};
  CHECK(ball.identity() == Shape(Sphere{1}).identity());
  CHECK(ball.identity() != ball.rounded(1).identity());
  CHECK(Shape(Sphere{0}).identity() != 0);
  CHECK(Shape(Sphere{0}).identity() != ball.identity());
  CHECK(Shape(Box{Vec3(1, 1, 1)}).identity() != Shape(Box{Vec3(1, 1, 1)}).identity());
}

TEST_CASE("building: a sphere holds nothing beside itself, its mass told or not") {
  const Shape ball = Sphere{2};
  CHECK(ball.mass().volume == Shape(Ellipsoid{Vec3(2, 2, 2)}).mass().volume);
  CHECK(ball.memory() == 0);
  CHECK(memory_of(std::vector<Shape>{ball, Sphere{1}, ball}) == 0);
  CHECK(memory_of(std::vector<Shape>{ball, Box{Vec3(1, 1, 1)}}) > 0);
}

TEST_CASE("building: a mesh's unit scales with it, also where its size is a last digit from a power of two") {
  for (const double half : {std::nextafter(1.0, 0.0), 1.0, std::nextafter(1.0, 2.0), 1.3}) {
    const auto unit_at = [&](int exponent) {
      Extent box;
      for (const double x : {-half, half}) box.add(std::ldexp(x, exponent) * Vec3(1, 0.25, 0.5));
      return MeshFrame(box).unit;
    };
    CHECK(unit_at(0) == (half > 1 ? 4 : 2));
    for (int exponent = -90; exponent <= 90; ++exponent) CHECK(unit_at(exponent) == std::ldexp(unit_at(0), exponent));
  }
}
