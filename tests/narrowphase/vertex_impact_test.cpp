// First impacts of vertices on straight lines.
#include "tandem/narrowphase/vertex_impact.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "catch.h"
#include "impact_queries.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::reference;

namespace {

ImpactQuery query(bool edges, const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& to) {
  return {edges, from, to};
}

std::string named(const ImpactQuery& q) {
  std::ostringstream out;
  out.precision(17);
  out << (q.edges ? "edges" : "point and triangle");
  for (const auto* x : {&q.from, &q.to})
    for (const Vec3& v : *x) out << " {" << v.x() << ", " << v.y() << ", " << v.z() << "}";
  return out.str();
}

// The properties of every answer.
void judge(const ImpactQuery& q, const VertexImpact& answer, const ExactImpact& exact) {
  if (!exact.hit()) return;
  INFO(named(q));
  CHECK(answer.hit);                        // no impact is missed
  CHECK_FALSE(exact.hit_before(answer.t));  // none is reported late
}

bool beyond(const ImpactQuery& q, const VertexImpact& answer) {
  double reach = 0;
  for (std::size_t i = 1; i < 4; ++i)
    reach = std::max({reach, (q.from[i] - q.from[0]).norm(), (q.to[i] - q.to[0]).norm()});
  return answer.gap > 1e-6 * longest_motion(q) + 1e-12 * reach;
}

// The distance of the features at a time, as degenerate triangles.
double distance(const ImpactQuery& q, double t) {
  std::array<Vec3, 4> x;
  for (std::size_t v = 0; v < 4; ++v) x[v] = (1 - t) * q.from[v] + t * q.to[v];
  const Shape a = q.edges ? Triangle{{x[0], x[1], x[1]}} : Triangle{{x[0], x[0], x[0]}};
  const Shape b = q.edges ? Triangle{{x[2], x[3], x[3]}} : Triangle{{x[1], x[2], x[3]}};
  return NarrowPhase().solve(a, Pose{}, b, Pose{}, Request::distance).signed_distance;
}

// A mesh of so many vertices with random positions and motions, and all kinds of candidates.
struct Meshes {
  std::array<std::vector<Vec3>, 2> from, to;
  std::vector<PointTriangle> points_of_a, points_of_b;
  std::vector<EdgeEdge> edges;

  explicit Meshes(std::size_t pairs) {
    Random random(17);
    constexpr int vertices = 200;
    for (std::size_t mesh = 0; mesh < 2; ++mesh)
      for (int i = 0; i < vertices; ++i) {
        from[mesh].push_back(random.vec(-1, 1));
        to[mesh].push_back(from[mesh].back() + random.vec(-0.3, 0.3));
      }
    const auto any = [&] { return static_cast<std::uint32_t>(random.below(vertices)); };
    for (std::size_t i = 0; i < pairs; ++i) {
      points_of_a.push_back({any(), {any(), any(), any()}});
      points_of_b.push_back({any(), {any(), any(), any()}});
      edges.push_back({{any(), any()}, {any(), any()}});
    }
  }
  MovingVertices a() const { return {from[0], to[0]}; }
  MovingVertices b() const { return {from[1], to[1]}; }
};

void on_four_threads(std::size_t parts, const std::function<void(std::size_t)>& part) {
  std::atomic<std::size_t> next{0};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (std::size_t k = next++; k < parts; k = next++) part(k);
    });
}

bool same(const VertexImpact& x, const VertexImpact& y) { return x.hit == y.hit && x.t == y.t && x.gap == y.gap; }

}  // namespace

TEST_CASE("vertex impact: the exact judge knows what is known") {
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  const auto falls = [&](const Vec3& from, const Vec3& to) {
    return ExactImpact(query(false, {from, a, b, c}, {to, a, b, c}));
  };
  CHECK(falls({1, 1, 1}, {1, 1, -1}).hit());
  CHECK(falls({1, 1, 1}, {1, 1, -1}).hit_before(0.5 + 1e-15));
  CHECK_FALSE(falls({1, 1, 1}, {1, 1, -1}).hit_before(0.5));
  CHECK(falls({2, 2, 1}, {2, 2, -1}).hit());  // on the long edge
  CHECK_FALSE(falls({2, 2 + 1e-15, 1}, {2, 2 + 1e-15, -1}).hit());
  CHECK(falls({1, 1, 1}, {1, 1, 0}).hit());  // at t = 1
  CHECK_FALSE(falls({1, 1, 1}, {1, 1, 1e-300}).hit());
  CHECK(falls({1, 1, 0}, {1, 1, 1}).hit_before(1e-300));
  CHECK(falls({-1, 1, 0}, {1, 1, 0}).hit());  // in the plane
  CHECK_FALSE(falls({-1, 1, 0}, {1, 1, 0}).hit_before(0.5));
  CHECK_FALSE(falls({-1, -1, 0}, {5, -1, 0}).hit());
  // A double root: it touches from above and leaves.
  const ImpactQuery graze = query(true, {Vec3(-1, 0, 1), {1, 0, 1}, {0, -1, 0}, {0, 1, 0}},
                                  {Vec3(-1, 0, -1), {1, 0, 3}, {0, -1, 2}, {0, 1, 2}});
  CHECK_FALSE(ExactImpact(graze).hit_before(0.5));
  CHECK(ExactImpact(graze).hit());
  // Parallel edges on one line, and side by side.
  const auto slides = [&](double y) {
    return ExactImpact(query(true, {Vec3(0, 0, 0), {1, 0, 0}, {3, y, 0}, {4, y, 0}},
                             {Vec3(2, 0, 0), {3, 0, 0}, {3, y, 0}, {4, y, 0}}));
  };
  CHECK(slides(0).hit());
  CHECK_FALSE(slides(0).hit_before(1));
  CHECK_FALSE(slides(1e-300).hit());
}

TEST_CASE("vertex impact: never a miss and never late, hardly told in vain, on queries made to be hard") {
  int queries = 0, hits = 0, in_vain = 0;
  std::uint64_t seed = 1;
  for (const ImpactFamily& family : impact_families()) {
    INFO(family.name);
    Random random(seed++);
    for (int i = 0; i < 400; ++i, ++queries) {
      const ImpactQuery q = family.make(random);
      const VertexImpact answer = solve(q);
      const ExactImpact exact(q);
      judge(q, answer, exact);
      judge(q, solve(q, {i % 2 == 0 ? 0 : 0.1, 0}), exact);
      hits += exact.hit();
      in_vain += answer.hit && !exact.hit() && beyond(q, answer);
      CHECK((answer.t >= 0 && answer.t <= 1 && answer.gap >= 0));
    }
  }
  CHECK((hits > 1000 && hits < 4000));
  CHECK(in_vain * 1000 < queries);
}

TEST_CASE("vertex impact: the time of a plain impact is right to rounding, and without tolerance as well") {
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  for (const double tolerance : {1e-6, 0.0, 0.1}) {
    const ImpactOptions options{tolerance, 0};
    const VertexImpact face = point_triangle_impact({1, 1, 1}, {a, b, c}, {1, 1, -2}, {a, b, c}, options);
    CHECK(face.hit);
    CHECK(face.t == Approx(1.0 / 3).epsilon(1e-12));
    CHECK(face.t <= 1.0 / 3);
    CHECK(face.gap < 1e-12);
    const VertexImpact crossing = edge_edge_impact({Vec3(-1, 0, 1), Vec3(1, 0, 1)}, {Vec3(0, -1, 0), Vec3(0, 1, 0)},
                                                   {Vec3(-1, 0, -1), Vec3(1, 0, -1)}, {Vec3(0, -1, 0), Vec3(0, 1, 0)}, options);
    CHECK(crossing.hit);
    CHECK(crossing.t == Approx(0.5).epsilon(1e-12));
    CHECK(crossing.t <= 0.5);
  }
  const VertexImpact beside = point_triangle_impact({3, 3, 1}, {a, b, c}, {3, 3, -2}, {a, b, c});
  CHECK_FALSE(beside.hit);
  CHECK(beside.t == 1);
  CHECK(beside.gap == 0);
}

TEST_CASE("vertex impact: features that come within the separation meet") {
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  const VertexImpact face = point_triangle_impact({1, 1, 1}, {a, b, c}, {1, 1, -1}, {a, b, c}, {1e-6, 0.25});
  CHECK(face.hit);
  CHECK(face.t == Approx(0.375).epsilon(1e-12));
  CHECK(face.t <= 0.375);
  CHECK(face.gap == Approx(0.25));
  // Past a corner, at a distance of 3/4.
  const auto past = [&](double separation) {
    return point_triangle_impact({-0.75, -2, 0}, {a, b, c}, {-0.75, 2, 0}, {a, b, c}, {1e-6, separation});
  };
  CHECK_FALSE(past(0.7499).hit);
  CHECK(past(0.7501).hit);
  Random random(5);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    ImpactQuery q = impact_families()[0].make(random);
    const double separation = random.power_of_two(-8, -2);
    const VertexImpact answer = solve(q, {1e-6, separation});
    hits += answer.hit;
    INFO(named(q) << " separation " << separation);
    const double end = answer.hit ? answer.t : 1;
    if (end == 0) {
      CHECK(distance(q, 0) <= separation * (1 + 1e-3));
      continue;
    }
    for (int k = 0; k < 8; ++k) CHECK(distance(q, end * k / 8) > separation * (1 - 1e-9));
    if (answer.hit) CHECK(distance(q, end) == Approx(separation).epsilon(1e-3));
  }
  CHECK((hits > 200 && hits < 1800));
}

TEST_CASE("vertex impact: lists of candidates have the answers of one by one, on any number of threads") {
  const Meshes meshes(3000);
  std::vector<VertexImpact> points(meshes.points_of_a.size()), edges(meshes.edges.size());
  point_triangle_impacts(meshes.a(), meshes.b(), meshes.points_of_a, points);
  edge_edge_impacts(meshes.a(), meshes.b(), meshes.edges, edges);
  double first = 2;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [p, t] = meshes.points_of_a[i];
    const auto& [fa, fb] = meshes.from;
    const auto& [ta, tb] = meshes.to;
    CHECK(same(points[i], point_triangle_impact(fa[p], {fb[t[0]], fb[t[1]], fb[t[2]]}, ta[p], {tb[t[0]], tb[t[1]], tb[t[2]]})));
    const auto& [x, y] = meshes.edges[i];
    CHECK(same(edges[i], edge_edge_impact({fa[x[0]], fa[x[1]]}, {fb[y[0]], fb[y[1]]}, {ta[x[0]], ta[x[1]]}, {tb[y[0]], tb[y[1]]})));
    if (points[i].hit) first = std::min(first, points[i].t);
    if (edges[i].hit) first = std::min(first, edges[i].t);
  }
  std::vector<VertexImpact> again(points.size());
  point_triangle_impacts(meshes.b(), meshes.a(), meshes.points_of_b, again);
  for (const VertexImpact& v : again)
    if (v.hit) first = std::min(first, v.t);
  CHECK(first < 1);

  const ImpactCandidates all{meshes.points_of_a, meshes.points_of_b, meshes.edges};
  const auto one = first_impact(meshes.a(), meshes.b(), all), shared = first_impact(meshes.a(), meshes.b(), all, {}, on_four_threads);
  REQUIRE((one && shared));
  CHECK(one->impact.t == Approx(first).margin(1e-6));
  CHECK(same(one->impact, shared->impact));
  CHECK((one->kind == shared->kind && one->index == shared->index));
  point_triangle_impacts(meshes.a(), meshes.b(), meshes.points_of_a, again, {}, on_four_threads);
  for (std::size_t i = 0; i < points.size(); ++i) CHECK(same(points[i], again[i]));
  CHECK_FALSE(first_impact(meshes.a(), meshes.b(), {}));
}

TEST_CASE("vertex impact: bad input is refused by name") {
  const Meshes meshes(1);
  const Vec3 o(0, 0, 0), bad(0, std::numeric_limits<double>::quiet_NaN(), 0);
  const TriangleCorners t{o, o, o};
  CHECK_THROWS_WITH(point_triangle_impact(o, t, o, {o, bad, o}), Catch::Contains("triangle after the step, vertex 1"));
  CHECK_THROWS_WITH(point_triangle_impact({2e30, 0, 0}, t, o, t), Catch::Contains("point, vertex 0"));
  CHECK_THROWS_WITH(point_triangle_impact(o, t, o, t, {0.2, 0}), Catch::Contains("tolerance 0.2"));
  CHECK_THROWS_WITH(point_triangle_impact(o, t, o, t, {0, -1}), Catch::Contains("separation -1"));
  CHECK_THROWS_WITH(edge_edge_impact({o, bad}, {o, o}, {o, o}, {o, o}), Catch::Contains("first edge before the step, vertex 1"));
  std::vector<VertexImpact> impacts(1);
  const std::vector<PointTriangle> no_vertex{{0, {1, 2, 200}}};
  CHECK_THROWS_WITH(point_triangle_impacts(meshes.a(), meshes.b(), no_vertex, impacts),
                    Catch::Contains("pair of point and triangle 0: vertex 200 does not exist; the mesh has 200"));
  CHECK_THROWS_WITH(edge_edge_impacts(meshes.a(), meshes.b(), meshes.edges, {}), Catch::Contains("room for 0, but 1"));
  const MovingVertices uneven{meshes.from[0], std::span(meshes.to[0]).first(3)};
  CHECK_THROWS_WITH(first_impact(uneven, meshes.b(), {}), Catch::Contains("200 vertices before and 3 after"));
}
