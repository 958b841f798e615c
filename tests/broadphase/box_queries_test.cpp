// Queries of boxes.
#include "tandem/broadphase/box_queries.h"

#include "box_worlds.h"
#include "catch.h"

using namespace tandem;

namespace {

/// Four threads that take blocks in any order.
void on_threads(std::size_t blocks, const std::function<void(std::size_t)>& block) {
  std::atomic<std::size_t> next{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (std::size_t i = next++; i < blocks; i = next++) block(i);
    });
  for (std::thread& thread : threads) thread.join();
}

bool is_empty(const Aabb& box) { return box.lo[0] > box.hi[0]; }

std::vector<std::uint32_t> overlapping_plainly(const BoxArray& boxes, const Aabb& box) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t i = 0; i < boxes.size(); ++i)
    if (overlap(boxes[i], box)) found.push_back(i);
  return found;
}

std::vector<Neighbour> nearest_plainly(const BoxArray& boxes, const std::array<double, 3>& point, std::size_t k) {
  std::vector<Neighbour> all;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const Aabb box = boxes[i];
    if (is_empty(box)) continue;
    double sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double inside = std::clamp<double>(point[axis], box.lo[axis], box.hi[axis]);
      sum += (point[axis] - inside) * (point[axis] - inside);
    }
    all.push_back({i, sum});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Neighbour& a, const Neighbour& b) { return a.squared_distance < b.squared_distance; });
  all.resize(std::min(all.size(), k));
  return all;
}

/// By clipping the segment to each pair of planes in turn, in long double; `near`: too close to call in double.
bool meets(const Ray& ray, const Aabb& box, long double& t, bool& near) {
  long double from = 0, to = ray.t_max;
  for (std::size_t k = 0; k < 3; ++k) {
    const long double lo = static_cast<long double>(box.lo[k]) - ray.origin[k];
    const long double hi = static_cast<long double>(box.hi[k]) - ray.origin[k];
    if (ray.direction[k] == 0) {
      if (lo > 0 || hi < 0) return false;
      continue;
    }
    const long double a = lo / ray.direction[k], b = hi / ray.direction[k];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  t = from;
  near = std::abs(to - from) <= 1e-14L * (std::abs(from) + std::abs(to));
  return from <= to;
}

Ray random_ray(Random& random, const BoxArray& boxes) {
  const auto point_in = [&](const Aabb& box) {
    std::array<double, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = box.lo[k] + uniform(random, 0, 1) * (double{box.hi[k]} - double{box.lo[k]});
    return p;
  };
  const auto some_box = [&] {
    Aabb box = boxes[random() % boxes.size()];
    return is_empty(box) ? Aabb{{0, 0, 0}, {1, 1, 1}} : box;
  };
  Ray ray;
  ray.origin = point_in(some_box());
  const auto to = point_in(some_box());
  for (std::size_t k = 0; k < 3; ++k) ray.direction[k] = to[k] - ray.origin[k];
  if (random() % 4 == 0) ray.direction[random() % 3] = 0;
  if (ray.direction == std::array<double, 3>{0, 0, 0}) ray.direction = {0, 1, 0};
  ray.t_max = random() % 3 == 0 ? std::numeric_limits<double>::infinity() : uniform(random, 0, 2);
  return ray;
}

}  // namespace

TEST_CASE("box queries: the answers of a loop over all boxes, in the worlds that break broad phases") {
  BoxQueries queries;
  for (const std::size_t n : {1u, 2u, 8u, 9u, 65u, 1500u})
    for (const BoxWorld& world : hard_worlds(n)) {
      CAPTURE(world.name, n);
      queries.build(world.boxes, n == 1500 ? BlockRunner(on_threads) : BlockRunner{});
      Random random(static_cast<unsigned>(n));
      for (int turn = 0; turn < 20; ++turn) {
        const Aabb box = world.boxes[random() % n];
        std::vector<std::uint32_t> found;
        queries.overlapping(box, found);
        CHECK(found == overlapping_plainly(world.boxes, box));

        std::array<double, 3> point;
        for (std::size_t k = 0; k < 3; ++k) point[k] = is_empty(box) ? 1 : 0.9 * box.lo[k] + 0.3 * box.hi[k];
        for (const std::size_t k : {0u, 1u, 7u, 2000u}) {
          if (k == 2000 && turn != 0) continue;
          std::vector<Neighbour> near;
          queries.nearest(point, k, near);
          CHECK((near == nearest_plainly(world.boxes, point, k)));
        }

        const Ray ray = random_ray(random, world.boxes);
        std::vector<RayHit> hits;
        queries.along(ray, hits);
        CHECK(std::is_sorted(hits.begin(), hits.end(), [](const RayHit& a, const RayHit& b) {
          return a.t != b.t ? a.t < b.t : a.index < b.index;
        }));
        std::vector<double> entered(n, -1);
        for (const RayHit& hit : hits) {
          CHECK(entered[hit.index] == -1);
          entered[hit.index] = hit.t;
        }
        for (std::uint32_t i = 0; i < n; ++i) {
          long double t = 0;
          bool near = false;
          const bool hit = !is_empty(world.boxes[i]) && meets(ray, world.boxes[i], t, near);
          if (near) continue;
          if ((entered[i] >= 0) != hit) FAIL_CHECK("box " << i << " is on the ray: " << hit);
          if (hit && entered[i] >= 0 && std::abs(entered[i] - t) > 1e-14L * t) FAIL_CHECK("box " << i << " at " << t);
        }
      }
    }
}

TEST_CASE("box queries: a batch on threads is the single queries one after the other") {
  const BoxArray boxes = hard_worlds(33'000)[0].boxes;
  BoxQueries queries;
  queries.build(boxes, on_threads);
  Random random(2);
  std::vector<Aabb> asked;
  std::vector<Ray> rays;
  std::vector<std::array<double, 3>> points;
  for (int q = 0; q < 1000; ++q) {
    asked.push_back(boxes[random() % boxes.size()]);
    rays.push_back(random_ray(random, boxes));
    points.push_back({uniform(random, -5, 70), uniform(random, -5, 70), uniform(random, -5, 70)});
  }
  const auto overlaps = queries.overlapping(asked, on_threads);
  const auto on_rays = queries.along(rays, on_threads);
  const auto neighbours = queries.nearest(points, 5, on_threads);
  REQUIRE(overlaps.size() == 1000);
  CHECK(on_rays.items.size() > 1000);
  for (std::size_t q = 0; q < 1000; ++q) {
    std::vector<std::uint32_t> found;
    queries.overlapping(asked[q], found);
    CHECK(std::equal(found.begin(), found.end(), overlaps.of(q).begin(), overlaps.of(q).end()));
    std::vector<RayHit> hits;
    queries.along(rays[q], hits);
    CHECK(std::equal(hits.begin(), hits.end(), on_rays.of(q).begin(), on_rays.of(q).end()));
    std::vector<Neighbour> near;
    queries.nearest(points[q], 5, near);
    CHECK(std::equal(near.begin(), near.end(), neighbours.of(q).begin(), neighbours.of(q).end()));
  }
  CHECK(queries.overlapping(std::span<const Aabb>{}, on_threads).size() == 0);
}

TEST_CASE("box queries: nothing there, and what is refused") {
  BoxQueries queries;
  const Ray ray{{0, 0, 0}, {1, 0, 0}, 10};
  std::vector<RayHit> hits;
  queries.along(ray, hits);
  CHECK(hits.empty());
  BoxArray boxes;
  boxes.resize(1);
  boxes.set(0, {{2, -1, -1}, {3, 1, 1}});
  queries.build(boxes);
  queries.along(ray, hits);
  CHECK((hits == std::vector<RayHit>{{0, 2}}));
  std::vector<std::uint32_t> found;
  queries.overlapping({{3, 1, 1}, {2, 5, 5}}, found);  // empty
  CHECK(found.empty());
  queries.overlapping({{3, 1, 1}, {4, 5, 5}}, found);  // touches a corner
  CHECK(found == std::vector<std::uint32_t>{0});

  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Neighbour> near;
  CHECK_THROWS_WITH(queries.along({{0, 0, 0}, {0, 0, 0}, 1}, hits), Catch::Contains("direction"));
  CHECK_THROWS_WITH(queries.along({{nan, 0, 0}, {1, 0, 0}, 1}, hits), Catch::Contains("origin"));
  CHECK_THROWS_WITH(queries.along({{0, 0, 0}, {1, 0, 0}, nan}, hits), Catch::Contains("t_max"));
  CHECK_THROWS_WITH(queries.nearest({0, nan, 0}, 1, near), Catch::Contains("point"));
  CHECK_THROWS_AS(queries.overlapping({{0, 0, 0}, {1, std::nanf(""), 1}}, found), std::invalid_argument);
}

namespace {

struct NearestBoxes final : NearVisitor {
  std::vector<std::uint32_t> visited;
  double best = std::numeric_limits<double>::infinity();
  double visit(std::uint32_t index, double distance) override {
    visited.push_back(index);
    return best = std::min(best, distance);
  }
};

double distance_plainly(const Aabb& a, const Aabb& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double off = std::max({double{b.lo[k]} - a.hi[k], double{a.lo[k]} - b.hi[k], 0.0});
    sum += off * off;
  }
  return std::sqrt(sum);
}

}  // namespace

TEST_CASE("boxes that have moved are found where they are") {
  for (const std::size_t n : {1u, 2u, 9u, 500u, 20000u}) {
    BoxArray boxes = make_boxes(
        n, 5,
        [](Random& r) {
          return Point{uniform(r, 0, 30), uniform(r, 0, 30), uniform(r, 0, 30)};
        },
        [](Random& r) {
          return Point{uniform(r, 0, 2), uniform(r, 0, 2), uniform(r, 0, 2)};
        });
    BoxQueries queries;
    queries.build(boxes);
    CHECK(queries.worn() == 1);
    Random random(7);
    for (int round = 0; round < 5; ++round) {
      std::vector<std::uint32_t> changed;
      for (std::uint32_t i = 0; i < n; ++i) {
        if (random() % (round % 2 == 0 ? 3 : 20) != 0) continue;  // many, so that all nodes are updated, or few
        changed.push_back(i);
        if (random() % 5 == 0) {
          boxes.set_empty(i);
          continue;
        }
        Aabb box;
        for (std::size_t k = 0; k < 3; ++k) {
          box.lo[k] = uniform(random, -5, 40);
          box.hi[k] = box.lo[k] + uniform(random, 0, 2);
        }
        boxes.set(i, box);
      }
      queries.refit(boxes, changed);
      for (int q = 0; q < 20; ++q) {
        Aabb asked;
        for (std::size_t k = 0; k < 3; ++k) {
          asked.lo[k] = uniform(random, -5, 40);
          asked.hi[k] = asked.lo[k] + uniform(random, 0, 4);
        }
        std::vector<std::uint32_t> found;
        queries.overlapping(asked, found);
        REQUIRE(found == overlapping_plainly(boxes, asked));
        double least = std::numeric_limits<double>::infinity();
        for (std::uint32_t i = 0; i < n; ++i)
          if (!is_empty(boxes[i])) least = std::min(least, distance_plainly(asked, boxes[i]));
        NearestBoxes nearest;
        queries.visit_near(asked, std::numeric_limits<double>::infinity(), nearest);
        REQUIRE(nearest.best == least);
        if (n == 20000) CHECK(nearest.visited.size() < 200);
        NearestBoxes none;
        if (least > 0 && std::isfinite(least)) {
          queries.visit_near(asked, std::nextafter(least, 0.0), none);
          CHECK(none.visited.empty());
        }
      }
    }
    if (n == 20000) CHECK(queries.worn() > 2);
  }
}

TEST_CASE("rays whose t no double can hold hit nothing, and points are refused whose distances none can") {
  BoxArray boxes;
  boxes.resize(2);
  boxes.set(0, {{1e30f, 1e32f, 0}, {1e31f, 1e33f, 1}});  // beside the diagonal
  boxes.set(1, {{1e30f, 1e30f, 0}, {1e31f, 1e31f, 1}});  // on it
  BoxQueries queries;
  queries.build(boxes);
  std::vector<RayHit> hits;
  queries.along({{0, 0, 0}, {1e-300, 1e-300, 0}, std::numeric_limits<double>::infinity()}, hits);
  CHECK(hits.empty());
  queries.along({{0, 0, 0}, {1e-200, 1e-200, 0}, std::numeric_limits<double>::infinity()}, hits);
  REQUIRE(hits.size() == 1);
  CHECK(hits[0].index == 1);
  CHECK(std::isfinite(hits[0].t));
  std::vector<Neighbour> near;
  queries.nearest({1e150, 0, 0}, 1, near);
  REQUIRE(near.size() == 1);
  CHECK(std::isfinite(near[0].squared_distance));
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(queries.nearest({1e200, 0, 0}, 1, near), Contains("1e+200, allowed: numbers of at most 1e150"));
  CHECK_THROWS_WITH(queries.along({{0, 0, 0}, {0, 1e-320, 0}, 1}, hits), Contains("direction is 1e-320, allowed: "));
}

TEST_CASE("a visit of boxes ends when the visitor says so, and a refit knows its boxes") {
  BoxArray boxes = make_boxes(
      100, 5,
      [](Random& r) {
        return Point{uniform(r, 0, 1), 0, 0};
      },
      [](Random&) {
        return Point{1, 1, 1};
      });
  boxes.set_empty(7);
  BoxQueries queries;
  queries.build(boxes);
  struct Three final : BoxVisitor {
    int seen = 0;
    bool visit(std::uint32_t) override { return ++seen < 3; }
  } three;
  CHECK_FALSE(queries.visit_overlapping({{0, 0, 0}, {1, 1, 1}}, three));
  CHECK(three.seen == 3);
  const std::uint32_t was_empty[] = {7}, beyond[] = {100};
  CHECK_THROWS_AS(queries.refit(boxes, was_empty), std::invalid_argument);
  CHECK_THROWS_AS(queries.refit(boxes, beyond), std::invalid_argument);
  boxes.resize(101);
  CHECK_THROWS_AS(queries.refit(boxes, {}), std::invalid_argument);
}

TEST_CASE("a visit of near boxes that is never content sees each box once, and nearer ones first") {
  struct All final : NearVisitor {
    std::vector<std::uint32_t> visited;
    std::size_t turned_back = 0;
    double last = 0;
    double visit(std::uint32_t index, double distance) override {
      visited.push_back(index);
      turned_back += distance < last ? 1 : 0;
      last = distance;
      return std::numeric_limits<double>::infinity();
    }
  };
  for (const std::size_t n : {1u, 7u, 60u, 20000u}) {
    const BoxArray boxes = hard_worlds(n)[0].boxes;
    BoxQueries queries;
    queries.build(boxes);
    All all;
    queries.visit_near(boxes[0], std::numeric_limits<double>::infinity(), all);
    CHECK(all.turned_back <= (n < 200 ? 1u : n / 2));  // the first is a guess, and there is room for some hundreds
    std::sort(all.visited.begin(), all.visited.end());
    REQUIRE(all.visited.size() == n);
    CHECK(std::adjacent_find(all.visited.begin(), all.visited.end()) == all.visited.end());
  }
}

TEST_CASE("near boxes are found where the nearest node has none of them") {
  // A limit barely above the least distance: most nodes around the point contain nothing so near.
  BoxArray boxes = make_boxes(
      4000, 9,
      [](Random& r) {
        return Point{uniform(r, 0, 30), uniform(r, 0, 30), uniform(r, 0, 30)};
      },
      [](Random&) {
        return Point{0.1f, 0.1f, 0.1f};
      });
  BoxQueries queries;
  queries.build(boxes);
  Random random(3);
  std::size_t shown = 0;
  for (int q = 0; q < 300; ++q) {
    const Point at{uniform(random, 0, 30), uniform(random, 0, 30), uniform(random, 0, 30)};
    const Aabb asked{at, at};
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < boxes.size(); ++i) least = std::min(least, distance_plainly(asked, boxes[i]));
    NearestBoxes nearest;
    queries.visit_near(asked, 1.01 * least, nearest);
    REQUIRE(nearest.best == least);
    shown += nearest.visited.size();
  }
  CHECK(shown < 400);
}
