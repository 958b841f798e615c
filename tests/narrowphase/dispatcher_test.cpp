// The dispatcher: kinds, requests, solvers, options.
#include <stdexcept>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"

using namespace tandem;
using namespace tandem::test;

namespace {

std::vector<Shape> one_of_each() {
  Random r(1);
  std::vector<Shape> list;
  for (std::size_t k = 0; k < shape_kinds; ++k) list.push_back(random_shape(static_cast<ShapeKind>(k), r));
  return list;
}

}  // namespace

TEST_CASE("dispatcher: every pair of kinds answers every request, or refuses by name") {
  const auto shapes = one_of_each();
  const NarrowPhase n;
  for (const Shape& a : shapes)
    for (const Shape& b : shapes)
      for (const Request q : {Request::collide, Request::distance, Request::contacts}) {
        CAPTURE(name(a.kind()), name(b.kind()), name(q));
        const std::string why = n.refuses(a, b, q);
        CHECK(why.empty() == (a.is_bounded() || b.is_bounded() || q == Request::collide));
        std::vector<Contact> contacts;
        if (!why.empty()) {
          CHECK(why.find(name(a.kind())) == 0);
          CHECK_THROWS_AS(n.solve(a, Pose{}, b, Pose{}, q), std::invalid_argument);
          continue;
        }
        const PairAnswer answer = n.solve(a, Pose{}, b, Pose::at(0.1, 0.2, 0.1), q, &contacts);
        CHECK(answer.collide == n.solve(a, Pose{}, b, Pose::at(0.1, 0.2, 0.1), Request::collide).collide);
        // A triangle is off the centre and may miss; solids overlap here.
        const auto is_thin = [](const Shape& s) { return s.is_convex() && !s.is_solid(); };
        if (!is_thin(a) && !is_thin(b)) CHECK(answer.collide);
        CHECK(contacts.empty() == !(q == Request::contacts && answer.collide));
        if (q == Request::distance) CHECK(answer.collide == (answer.signed_distance <= 0));
        const PairAnswer without_list = n.solve(a, Pose{}, b, Pose::at(0.1, 0.2, 0.1), q);
        CHECK((without_list.collide == answer.collide && without_list.signed_distance == answer.signed_distance));
      }
}

TEST_CASE("dispatcher: opposite half-spaces meet or miss by their offsets") {
  const NarrowPhase n;
  const Shape below(HalfSpace{{0, 0, 1}, 1}), above(HalfSpace{{0, 0, -1}, -2});
  CHECK_FALSE(n.solve(below, Pose{}, above, Pose{}, Request::collide).collide);
  CHECK(n.solve(below, Pose::at(0, 0, 1), above, Pose{}, Request::collide).collide);
  CHECK(n.solve(below, Pose{}, Shape(HalfSpace{{0, 1e-9, -1}, -2}), Pose{}, Request::collide).collide);
}

TEST_CASE("dispatcher: named solvers agree on plain pairs, unknown names are answered with the list") {
  const auto shapes = one_of_each();
  const NarrowPhase table;
  int covered = 0;
  for (const SolverInfo& info : NarrowPhase::solvers()) {
    const NarrowPhase forced({.tolerance = 0, .margin = 0, .solver = std::string(info.name)});
    for (const Shape& a : shapes)
      for (const Shape& b : shapes) {
        if (!table.refuses(a, b, Request::distance).empty()) continue;
        CAPTURE(info.name, name(a.kind()), name(b.kind()));
        const Pose far = Pose::at(9, 7, 8);
        const auto expected = table.solve(a, Pose{}, b, far, Request::distance);
        const auto got = forced.solve(a, Pose{}, b, far, Request::distance);
        if (got.status == Status::ok) {
          CHECK(std::abs(got.signed_distance - expected.signed_distance) < 2e-3);
          ++covered;
        }
        CHECK(forced.solve(a, Pose{}, b, far, Request::collide).collide == expected.collide);
      }
  }
  CHECK(covered > 300);
  CHECK_THROWS_WITH(NarrowPhase({.tolerance = 0, .margin = 0, .solver = "magic"}),
                    Catch::Matchers::Contains("magic") && Catch::Matchers::Contains("libccd"));
  CHECK_THROWS_AS(NarrowPhase({.tolerance = 0.2, .margin = 0, .solver = {}}), std::invalid_argument);
  CHECK_THROWS_AS(NarrowPhase({.tolerance = 0, .margin = -1, .solver = {}}), std::invalid_argument);
}

TEST_CASE("dispatcher: a margin reports gaps as negative depths") {
  const Shape box(Box{{1, 1, 1}});
  std::vector<Contact> contacts;
  const NarrowPhase wide({.tolerance = 0, .margin = 0.1, .solver = {}});
  const auto answer = wide.solve(box, Pose{}, box, Pose::at(0, 0, 1.05), Request::contacts, &contacts);
  CHECK_FALSE(answer.collide);
  REQUIRE(contacts.size() == 4);
  for (const Contact& c : contacts) CHECK(std::abs(c.depth + 0.05) < 1e-12);
  contacts.clear();
  NarrowPhase().solve(box, Pose{}, box, Pose::at(0, 0, 1.05), Request::contacts, &contacts);
  CHECK(contacts.empty());
}

TEST_CASE("dispatcher: what the last step learnt changes no answer beyond rounding") {
  Random r(12);
  const NarrowPhase n;
  for (const Shape& a : one_of_each())
    for (const Shape& b : one_of_each()) {
      if (!n.refuses(a, b, Request::distance).empty()) continue;
      WarmStart warm;
      for (int i = 0; i < 8; ++i) {
        const Pose pa = random_pose(r, 0.5), pb = random_pose(r, 1);
        CAPTURE(name(a.kind()), name(b.kind()), i);
        // The first starts without data, the next from the answer to another pose.
        const auto plain = n.solve(a, pa, b, pb, Request::distance);
        const auto warmed = n.solve(a, pa, b, pb, Request::distance, nullptr, &warm);
        CHECK(std::abs(plain.signed_distance - warmed.signed_distance) < 1e-9);
        CHECK(n.solve(a, pa, b, pb, Request::collide, nullptr, &warm).collide == plain.collide);
        CHECK(warm.direction.allFinite());
      }
    }
}

TEST_CASE("dispatcher: a tolerance takes the cheapest row that meets it, and its error holds") {
  CHECK(!NarrowPhase::table().empty());
  const NarrowPhase exact;
  Random r(13);
  for (const SolverRow& row : NarrowPhase::table()) {
    CAPTURE(name(row.a), name(row.b), name(row.request), row.solver);
    REQUIRE(row.request == Request::distance);
    const double accepted = row.error;
    const NarrowPhase loose({.tolerance = accepted, .margin = 0, .solver = {}});
    const SolverRow taken = loose.solver_for(row.b, row.a, row.request);
    CHECK(taken.error <= accepted);
    CHECK(taken.nanoseconds <= row.nanoseconds);
    CHECK(exact.solver_for(row.a, row.b, row.request).error == 0);
    for (int i = 0; i < 60; ++i) {
      const Shape a = random_shape(row.a, r), b = random_shape(row.b, r);
      const Pose pa = random_pose(r, 0.5), pb = random_pose(r, 1);
      const double size = a.size() + b.size();
      const double truth = exact.solve(a, pa, b, pb, Request::distance).signed_distance;
      const auto answer = loose.solve(a, pa, b, pb, row.request);
      CHECK(std::abs(answer.signed_distance - truth) <= accepted * size);
      if (answer.status == Status::ok) CHECK(answer.error_bound <= accepted * size);
    }
  }
}

TEST_CASE("dispatcher: the table tells what is refused, which solver answers and how sure it is") {
  const auto shapes = one_of_each();
  const NarrowPhase n, by_gjk({.solver = "gjk"});
  for (const Shape& a : shapes)
    for (const Shape& b : shapes)
      for (const Request q : {Request::collide, Request::distance, Request::contacts}) {
        CAPTURE(name(a.kind()), name(b.kind()), name(q));
        const SolverRow row = n.solver_for(a.kind(), b.kind(), q), exchanged = n.solver_for(b.kind(), a.kind(), q);
        CHECK((row.exactness == Exactness::refused) == !n.refuses(a, b, q).empty());
        CHECK(row.solver == exchanged.solver);
        CHECK(row.exactness == exchanged.exactness);
        const bool by_cells = a.kind() == ShapeKind::voxels || b.kind() == ShapeKind::voxels;
        CHECK((row.solver == "cells") == by_cells);
        CHECK((row.solver == "bvh") == (!by_cells && !(a.is_convex() && b.is_convex())));
        if (row.exactness == Exactness::exact) CHECK(q == Request::collide);
        const bool bounded = a.is_convex() && b.is_convex() && a.is_bounded() && b.is_bounded();
        CHECK(by_gjk.solver_for(a.kind(), b.kind(), q).solver == (bounded ? "gjk" : row.solver));
      }
  CHECK(n.solver_for(ShapeKind::cone, ShapeKind::convex, Request::distance).exactness == Exactness::least_found);
  CHECK(n.solver_for(ShapeKind::box, ShapeKind::convex, Request::distance).exactness == Exactness::rounding);
  CHECK(name(Exactness::least_found) == "least found");
}

TEST_CASE("dispatcher: a half-space is answered alike whichever solver is named") {
  Random r(14);
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::box, ShapeKind::cylinder})
    for (int i = 0; i < 20; ++i) {
      const Shape halfspace = random_shape(ShapeKind::halfspace, r), body = random_shape(kind, r);
      const Pose pa = random_pose(r, 0.5), pb = random_pose(r, 1);
      CAPTURE(name(kind), i);
      const PairAnswer plain = NarrowPhase().solve(halfspace, pa, body, pb, Request::distance);
      for (const char* solver : {"closed", "gjk"}) {
        const PairAnswer named = NarrowPhase({.solver = solver}).solve(halfspace, pa, body, pb, Request::distance);
        CHECK(named.signed_distance == plain.signed_distance);
        CHECK(named.point_b == plain.point_b);
      }
    }
}

TEST_CASE("a cut-off tells what is farther and changes nothing else") {
  Random r(29);
  const NarrowPhase plain;
  int farther = 0, nearer = 0;
  for (std::size_t ia = 0; ia < shape_kinds; ++ia)
    for (std::size_t ib = 0; ib < shape_kinds; ++ib)
      for (int i = 0; i < 12; ++i) {
        Shape a = random_shape(static_cast<ShapeKind>(ia), r), b = random_shape(static_cast<ShapeKind>(ib), r);
        if (i % 4 == 3) a = a.rounded(0.1);
        if (!plain.refuses(a, b, Request::distance).empty()) continue;
        const Pose pa = random_pose(r, 1), pb = random_pose(r, 2);
        CAPTURE(name(a.kind()), name(b.kind()), i);
        const PairAnswer all = plain.solve(a, pa, b, pb, Request::distance);
        CHECK_FALSE(all.farther);
        for (const double cutoff :
             {0.0, 0.5 * all.signed_distance, all.signed_distance, 1.5 * all.signed_distance + 1}) {
          if (!(cutoff >= 0)) continue;
          NarrowPhaseOptions options;
          options.cutoff = cutoff;
          const PairAnswer answer = NarrowPhase(options).solve(a, pa, b, pb, Request::distance);
          const PairAnswer same = plain.distance_within(a, pa, b, pb, cutoff);
          CHECK(answer.farther == (all.signed_distance > cutoff));
          CHECK(same.farther == answer.farther);
          CHECK(same.signed_distance == answer.signed_distance);
          if (answer.farther) {
            ++farther;
            CHECK(answer.signed_distance == cutoff);
            CHECK_FALSE(answer.collide);
            CHECK(answer.normal.isZero(0));
          } else {
            ++nearer;
            CHECK(answer.collide == all.collide);
            CHECK(answer.signed_distance == all.signed_distance);
            CHECK(answer.point_a == all.point_a);
            CHECK(answer.point_b == all.point_b);
            CHECK(answer.normal == all.normal);
          }
        }
      }
  CHECK(farther > 500);
  CHECK(nearer > 500);
  // Meshes with interiors and cavities, whose hierarchies the cut-off prunes.
  std::vector<Shape> shapes;
  for (const bool solid : {false, true}) {
    Mesh ring = torus(1, 0.4, 24, 12);
    ring.solid = solid;
    shapes.push_back(Shape(ring));
    shapes.push_back(shapes.back().rounded(0.05));
  }
  shapes.push_back(Sphere{0.2});
  shapes.push_back(Box{{0.2, 0.3, 0.1}});
  shapes.push_back(Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}});
  for (int i = 0; i < 400; ++i) {
    const Shape &a = shapes[static_cast<std::size_t>(i) % 4], &b = shapes[static_cast<std::size_t>(r.in(0, 7))];
    const Pose pa = random_pose(r, 0.2), pb = random_pose(r, i % 2 == 0 ? 3 : 1.2);
    const PairAnswer all = plain.solve(a, pa, b, pb, Request::distance);
    for (const double cutoff : {0.0, 0.3 * std::abs(all.signed_distance), std::max(all.signed_distance, 0.0), 1.0}) {
      const PairAnswer answer = plain.distance_within(a, pa, b, pb, cutoff);
      CAPTURE(i, cutoff, all.signed_distance, name(b.kind()), b.rounding(), b.size(), b.is_solid(),
              answer.signed_distance - all.signed_distance);
      REQUIRE(answer.farther == (all.signed_distance > cutoff));
      if (!answer.farther) {
        CHECK(answer.signed_distance == all.signed_distance);
        CHECK(answer.point_a == all.point_a);
        CHECK(answer.point_b == all.point_b);
        CHECK(answer.normal == all.normal);
        CHECK(answer.status == all.status);
      }
    }
  }
  NarrowPhaseOptions bad;
  bad.cutoff = -1;
  CHECK_THROWS_AS(NarrowPhase(bad), std::invalid_argument);
  CHECK_THROWS_AS(plain.distance_within(Sphere{1}, Pose{}, Sphere{1}, Pose{}, std::nan("")), std::invalid_argument);
}

TEST_CASE("options that are refused are told with all their digits, in a short line") {
  const auto refusal = [](NarrowPhaseOptions options) {
    try {
      const NarrowPhase solver(std::move(options));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refusal({.tolerance = 0.1 + 1e-9}) == "tolerance: 0.100000001 is not in [0, 0.1]");
  CHECK(refusal({.margin = -1e-9}) == "margin: -1e-9 is not finite and >= 0");
  CHECK(refusal({.cutoff = -1e308}) == "cutoff: -1e308 is not >= 0");
  CHECK(refusal({.solver = std::string(5000, 'x')}).size() < 300);
}
