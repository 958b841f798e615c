// Generalised winding numbers compared with the sum over all triangles, and solids made by them.
#include "tandem/narrowphase/winding_number.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "catch.h"
#include "mesh_samples.h"
#include "random.h"
#include "tandem/narrowphase/hausdorff.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::test;
using reference::Random;

namespace {

/// By the angles of the three corners of each triangle on a sphere about the point (L'Huilier).
double by_all(const Mesh& mesh, const Vec3& place) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = (mesh.vertices[t[0]] - place).normalized(), b = (mesh.vertices[t[1]] - place).normalized(),
               c = (mesh.vertices[t[2]] - place).normalized();
    const auto arc = [](const Vec3& u, const Vec3& v) { return std::atan2(u.cross(v).norm(), u.dot(v)); };
    const double x = arc(b, c), y = arc(c, a), z = arc(a, b), s = (x + y + z) / 2;
    const double tans = std::tan(s / 2) * std::tan((s - x) / 2) * std::tan((s - y) / 2) * std::tan((s - z) / 2);
    const double angle = 4 * std::atan(std::sqrt(std::max(0.0, tans)));
    sum += a.dot(b.cross(c)) > 0 ? angle : -angle;
  }
  return sum / (4 * std::numbers::pi);
}

}  // namespace

TEST_CASE("winding number: the sum over all triangles, of closed, open, turned and repeated ones") {
  Random random(17);
  Mesh whole = torus(1, 0.3, 32, 16);
  Mesh open = whole, turned = whole, twice = whole, soup;
  for (std::size_t i = 0; i < 100; ++i)
    open.triangles.erase(open.triangles.begin() + static_cast<std::ptrdiff_t>(5 * i));
  for (std::size_t i = 0; i < turned.triangles.size(); i += 7)
    std::swap(turned.triangles[i][0], turned.triangles[i][1]);
  for (std::size_t i = 0; i < 60; ++i) twice.triangles.push_back(whole.triangles[3 * i]);
  for (const auto& t : open.triangles) {
    for (const std::uint32_t v : t) soup.vertices.push_back(open.vertices[v]);
    const auto n = static_cast<std::uint32_t>(soup.vertices.size());
    soup.triangles.push_back({n - 3, n - 2, n - 1});
  }
  for (const Mesh& mesh : {whole, open, turned, twice, soup}) {
    const WindingNumber winding(mesh);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p =
          i % 2 == 0 ? random.vec(-1.5, 1.5)
                     : Vec3((1 + random.in(-0.28, 0.28)) * Vec3{random.in(-1, 1), random.in(-1, 1), 0}.normalized());
      CHECK(std::abs(winding.at(p) - by_all(mesh, p)) < 1e-9);
    }
  }
  const WindingNumber closed(whole);
  CHECK(std::abs(closed.at({1, 0, 0}) - 1) < 1e-12);
  CHECK(std::abs(closed.at({0, 0, 0})) < 1e-12);
  CHECK(std::abs(closed.at({50, 0, 0})) < 1e-12);
  // Without a lid, the winding number is near 0 far away, and above a half inside.
  Mesh lidless = box_mesh({2, 2, 2}, 4);
  std::erase_if(lidless.triangles, [&](const auto& t) {
    return lidless.vertices[t[0]].z() > 0.99 && lidless.vertices[t[1]].z() > 0.99 && lidless.vertices[t[2]].z() > 0.99;
  });
  CHECK(std::abs(WindingNumber(lidless).at({0, 0, 0}) - 5.0 / 6) < 1e-12);
}

TEST_CASE("winding number: a solid of cells for a mesh with a hole") {
  Mesh pot = box_mesh({2, 2, 2}, 8);
  pot.triangles.erase(pot.triangles.begin() + 40, pot.triangles.begin() + 44);
  pot.solid = true;
  CHECK_THROWS_AS(Shape(pot), std::invalid_argument);
  const Shape solid = voxel_solid(pot, {.size = 0.25});
  CHECK(solid.is_solid());
  CHECK(std::abs(solid.mass().volume - 8) < 1e-9);
  pot.solid = false;
  CHECK(hausdorff_distance(solid, {}, Shape(pot), {}).upper < 0.25 * std::sqrt(3.0) / 2 + 0.25);
  // For a closed mesh: within half the diagonal of a cell.
  Mesh ring = torus(1, 0.3, 32, 16);
  const Shape cells = voxel_solid(ring, {.size = 0.1});
  ring.solid = false;
  CHECK(hausdorff_distance(cells, {}, Shape(ring), {}).lower < 0.1 * std::sqrt(3.0) / 2);
  CHECK(NarrowPhase().solve(cells, {}, Sphere{0}, Pose::at(1, 0, 0), Request::collide).collide);
  CHECK_FALSE(NarrowPhase().solve(cells, {}, Sphere{0}, {}, Request::collide).collide);
}

TEST_CASE("winding number: what cannot be a solid is refused") {
  Mesh ring = torus(1, 0.3, 16, 8);
  CHECK_THROWS_AS(voxel_solid(ring, {.size = 0}), std::invalid_argument);
  CHECK_THROWS_AS(voxel_solid(ring, {.size = 1e-6}), std::invalid_argument);
  Mesh far = ring;
  for (Vec3& v : far.vertices) v.x() += 1e12;
  CHECK_THROWS_AS(voxel_solid(far, {.size = 0.1}), std::invalid_argument);
  CHECK_THROWS_AS(voxel_solid(ring, {.size = 0.1, .least = std::nan("")}), std::invalid_argument);
  const WorkLimit limit{.ended = [] { return true; }};
  CHECK_THROWS_AS(voxel_solid(ring, {.size = 0.1, .limit = &limit}), WorkStopped);
  for (auto& t : ring.triangles) std::swap(t[0], t[1]);
  CHECK_THROWS_AS(voxel_solid(ring, {.size = 0.1}), std::invalid_argument);
  CHECK_THROWS_AS(WindingNumber(Mesh{}), std::invalid_argument);
}
