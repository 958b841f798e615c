// Contacts of two separated meshes within the margin.
#include <algorithm>
#include <random>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/several_pairs.h"
#include "tandem/narrowphase/shape_makers.h"

using namespace tandem;
using namespace tandem::test;

namespace {

struct Found {
  PairAnswer answer;
  std::vector<Contact> contacts;
};

Found gaps(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, double margin) {
  Found out;
  out.answer = NarrowPhase({.margin = margin}).solve(a, pa, b, pb, Request::contacts, &out.contacts);
  return out;
}

double distance(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb) {
  return NarrowPhase().solve(a, pa, b, pb, Request::distance).signed_distance;
}

// A square plate of n by n cells of edge 1 at height 0, with the heights of its vertices by a function.
template <class Height>
Mesh plate(std::uint32_t n, const Height& height) {
  Mesh mesh;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) mesh.vertices.emplace_back(i, j, height(i, j));
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t k = i * (n + 1) + j, l = k + n + 1;
      mesh.triangles.push_back({k, l, l + 1});
      mesh.triangles.push_back({k, l + 1, k + 1});
    }
  return mesh;
}

// Both surfaces are at most half the gap away; other parts of them may be nearer.
void check_contact(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, const Contact& c, double margin) {
  const double gap = -c.depth, size = a.size() + b.size();
  CHECK(gap > 0);
  CHECK(gap <= margin);
  CHECK(c.normal.norm() == Approx(1));
  const Shape point = Sphere{0};
  const Pose at{Mat3::Identity(), c.point};
  CHECK(distance(point, at, a, pa) < gap / 2 + 1e-9 * size);
  CHECK(distance(point, at, b, pb) < gap / 2 + 1e-9 * size);
}

}  // namespace

TEST_CASE("mesh gaps: two cubes are held at the corners of what faces each other") {
  const Shape cube = Shape(box_mesh({1, 1, 1}));
  for (const double turn : {0.0, 0.7, 2.0}) {
    const Pose common = Pose::from(Quat(Eigen::AngleAxisd(turn, Vec3(1, 2, 3).normalized())), {5, 6, 7});
    const Pose a = common, b{common.rotation, common * Vec3(1.1, 0.25, 0.5)};
    const Found found = gaps(cube, a, cube, b, 0.2);
    REQUIRE(found.contacts.size() == 4);
    CHECK_FALSE(found.answer.collide);
    CHECK(found.answer.signed_distance == Approx(0.1));
    for (const Contact& c : found.contacts) {
      CHECK(c.depth == Approx(-0.1));
      CHECK((c.normal - common.rotation.col(0)).norm() < 1e-12);
      const Vec3 local = common.rotation.transpose() * (c.point - common.translation);
      CHECK(local.x() == Approx(0.55));
      CHECK(std::min(std::abs(local.y() + 0.25), std::abs(local.y() - 0.5)) < 1e-9);
      CHECK(std::min(std::abs(local.z()), std::abs(local.z() - 0.5)) < 1e-9);
    }
    CHECK(gaps(cube, a, cube, b, 0.09).contacts.empty());
    CHECK(gaps(cube, a, cube, b, 0).contacts.empty());
  }
}

TEST_CASE("mesh gaps: two fine plates are held at the corners of what they share, a wave at its crests") {
  const Shape flat = Shape(plate(24, [](auto, auto) { return 0; }));
  const Found plates = gaps(flat, Pose{}, flat, Pose::at(3.25, 4.5, 0.3), 0.5);
  REQUIRE(plates.contacts.size() == 4);
  for (const Contact& c : plates.contacts) {
    CHECK(c.depth == Approx(-0.3));
    CHECK(std::min(std::abs(c.point.x() - 3.25), std::abs(c.point.x() - 24)) < 1e-9);
    CHECK(std::min(std::abs(c.point.y() - 4.5), std::abs(c.point.y() - 24)) < 1e-9);
  }
  // Two crests of different height, 16 apart: both have contacts.
  const Shape wave = Shape(plate(24, [](std::uint32_t i, auto) { return i == 4 ? 1.0 : i == 20 ? 0.9 : 0.0; }));
  const Found crests = gaps(wave, Pose{}, flat, Pose::at(0, 0, 1.1), 0.25);
  REQUIRE(crests.contacts.size() == 4);
  CHECK(crests.answer.signed_distance == Approx(0.1));
  CHECK(std::count_if(crests.contacts.begin(), crests.contacts.end(), [](const Contact& c) {
          return std::abs(c.depth + 0.1) < 1e-9 && std::abs(c.point.x() - 4) < 1e-9;
        }) == 2);
  CHECK(std::count_if(crests.contacts.begin(), crests.contacts.end(), [](const Contact& c) {
          return std::abs(c.depth + 0.2) < 1e-9 && std::abs(c.point.x() - 20) < 1e-9;
        }) == 2);
}

TEST_CASE("mesh gaps: there is a contact if and only if the gap is within the margin, and each says what is there") {
  std::mt19937_64 random(17);
  const Shape ring = Shape(torus(1, 0.35, 24, 12)), cube = Shape(box_mesh({1, 0.7, 0.4}, 2)),
              open = Shape(plate(6, [](std::uint32_t i, std::uint32_t j) { return 0.3 * ((i * 5 + j * 3) % 4); }));
  const std::array shapes{&ring, &cube, &open};
  int near = 0, far = 0;
  for (int i = 0; i < 400; ++i) {
    const Shape &a = *shapes[random() % 3], &b = *shapes[random() % 3];
    const Pose pa = Pose::from(random_turn(random), Vec3::Zero());
    const Pose pb = random_pose(random, 2.5);
    const double gap = distance(a, pa, b, pb), margin = 0.4;
    if (gap <= 0) continue;
    const Found found = gaps(a, pa, b, pb, margin);
    CHECK_FALSE(found.answer.collide);
    CHECK(found.contacts.empty() == (gap > margin));
    (gap > margin ? far : near)++;
    if (gap > margin) continue;
    double least = margin;
    for (const Contact& c : found.contacts) {
      check_contact(a, pa, b, pb, c, margin);
      least = std::min(least, -c.depth);
    }
    CHECK(least == Approx(gap).epsilon(1e-12));
    CHECK(found.answer.signed_distance == Approx(gap).epsilon(1e-12));
    const Found back = gaps(b, pb, a, pa, margin);
    REQUIRE(back.contacts.size() == found.contacts.size());
    for (std::size_t k = 0; k < back.contacts.size(); ++k) {
      CHECK(back.contacts[k].point == found.contacts[k].point);
      CHECK(back.contacts[k].normal == -found.contacts[k].normal);
      CHECK(back.contacts[k].depth == found.contacts[k].depth);
    }
  }
  CHECK(near > 40);
  CHECK(far > 40);
}

TEST_CASE("mesh gaps: without them two meshes report what intersects alone") {
  const Shape cube = Shape(box_mesh({1, 1, 1}));
  std::vector<Contact> contacts;
  NarrowPhase({.margin = 0.2, .mesh_margin = false})
      .solve(cube, Pose{}, cube, Pose::at(1.1, 0, 0), Request::contacts, &contacts);
  CHECK(contacts.empty());
}

// Triangles of the sides, which lie in one plane across a gap as narrow as rounding, have a normal out of that plane
// alone, and of a solid that side is the outside.
TEST_CASE("mesh gaps: solids whose faces are flush and sides in one plane push each other off the faces alone") {
  const Shape a = Shape(box_mesh({0.4, 0.3, 0.3}, 3)), b = Shape(box_mesh({0.4, 0.3, 0.6}, 3));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(-200, 200);
  for (int i = 0; i < 300; ++i) {
    const Mat3 turn = i % 3 == 0 ? Mat3(Mat3::Identity()) : random_turn(random).toRotationMatrix();
    const Vec3 at{place(random), place(random), place(random)};
    const Vec3 aside = Vec3(0, 0, i % 2 == 0 ? 0.15 : 0.1);
    const Found found = gaps(a, {turn, at}, b, {turn, at + turn * (Vec3(0.4, 0, 0) + aside)}, 1e-3);
    CAPTURE(i);
    CHECK_FALSE(found.contacts.empty());
    for (const Contact& c : found.contacts) CHECK(c.normal.dot(turn.col(0)) > 0.999);
  }
}

// A wall's triangle and the bottom face lie beside each other along the bottom's normal, too, in the wrong direction.
TEST_CASE("mesh gaps: a body flush in a corner has contacts on each wall, with normals that lead out of it") {
  Random r(17);
  const Shape corner = voxel_mesh(corner_cells, 1);
  const NarrowPhase with_margin({.margin = 1e-9});
  for (int i = 0; i < 200; ++i) {
    const Vec3 half = r.vec(0.05, 0.5);
    Mesh body = box_mesh(2 * half, 1 + i % 2);
    body.solid = i % 4 == 3;
    const Pose at_corner = i % 3 == 0 ? Pose{} : Pose{r.rotation(), r.vec(-2, 2)};
    const Pose at{at_corner.rotation, at_corner * (Vec3::Ones() + half)};
    std::vector<Contact> contacts;
    with_margin.solve(corner, at_corner, Shape(body), at, Request::contacts, &contacts);
    Vec3 walls = Vec3::Zero();
    for (const Contact& c : contacts) {
      const Vec3 n = at_corner.rotation.transpose() * c.normal;
      CHECK(n.minCoeff() > -1e-9);
      walls = walls.cwiseMax(n);
    }
    CAPTURE(i, walls.transpose());
    CHECK(walls.minCoeff() > 0.999);
  }
}
