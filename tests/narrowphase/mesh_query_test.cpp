// Queries of a mesh's hierarchy.
#include "shapes/mesh_builder.h"
#include "meshes/traversal/mesh_query.h"

#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "random.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("mesh query: each triangle with a corner near a box is visited once, and few others are") {
  const MeshModel mesh = build_mesh(torus(1, 0.4, 24, 12));
  reference::Random random(6);
  std::size_t near_in_all = 0, visited_in_all = 0;
  for (int i = 0; i < 200; ++i) {
    const Mat3 axes = random.rotation();
    const Vec3 mid = random.vec(-1.2, 1.2), half = random.vec(0.02, 0.3), reach = axes.cwiseAbs() * half;
    const double margin = 0.05 * (i % 3);
    const BoxQuery query(mesh, {mid - reach, mid + reach}, mid, half, axes);
    std::vector<int> visits(mesh.triangles.size()), within(mesh.triangles.size());
    query.each_near(margin, [&](std::uint32_t t) {
      ++visits[t];
      return false;
    });
    query.nearest_first(margin, [&](std::uint32_t t) {
      ++within[t];
      return margin;
    });
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      double nearest = 1e300;
      for (const Vec3& corner : mesh.corners(t))
        nearest = std::min(nearest, ((axes.transpose() * (corner - mid)).cwiseAbs() - half).cwiseMax(0).norm());
      if (nearest <= margin) ++near_in_all;
      visited_in_all += static_cast<std::size_t>(visits[t]);
      if (visits[t] != (nearest <= margin ? 1 : visits[t])) FAIL_CHECK("box " << i << ", triangle " << t);
      if (within[t] != (nearest <= margin ? 1 : within[t])) FAIL_CHECK("box " << i << ", triangle " << t);
      CHECK(visits[t] <= 1);
      CHECK(within[t] <= visits[t]);
    }
  }
  CHECK(near_in_all > 500);
  CHECK(visited_in_all < 4 * near_in_all);
}
