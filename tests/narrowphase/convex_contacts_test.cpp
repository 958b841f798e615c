// Triangles so deep inside a convex shape that they need no solver: leaving them out changes no force, and the deepest
// contact is still found.
#include "meshes/contacts/convex_contacts.h"

#include <limits>

#include "catch.h"
#include "mesh_samples.h"
#include "meshes/contacts/normal_cone.h"
#include "random_pairs.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::test;

namespace {

std::vector<Shape> large_shapes() {
  Random random(4);
  Convex hull;
  for (int i = 0; i < 24; ++i) hull.vertices.push_back(0.6 * random.direction());
  return {Sphere{0.6},    Box{Vec3(0.7, 0.4, 0.5)},   Capsule{0.4, 0.6}, Cylinder{0.5, 0.9},
          Cone{0.6, 1.1}, Ellipsoid{{0.7, 0.5, 0.4}}, Shape(hull)};
}

}  // namespace

TEST_CASE("contacts with a convex shape: of triangles deep inside none that pushes is left out, nor the deepest") {
  Random random(3);
  std::size_t pushing = 0, inside = 0;
  for (const Shape& mesh : {Shape(torus(0.5, 0.25, 24, 16)), Shape(box_mesh({0.8, 0.7, 0.6}, 5))})
    for (const Shape& convex : large_shapes())
      for (int i = 0; i < 6; ++i) {
        const Pose at{random.rotation(), random.vec(-0.5, 0.5)};
        CAPTURE(name(convex.kind()), mesh.triangles().size(), i);
        const NarrowPhaseOptions options;
        const Pose home;
        const MeshConvexPair pair({mesh, home}, {convex, at}, options);
        const ConvexContacts contacts(pair, 0);
        PatchCollector all(pair.size(), {});
        PairAnswer near;
        near.signed_distance = std::numeric_limits<double>::infinity();
        std::vector<Contact> found;
        contacts.find(near, all, found);
        contacts.append_patches(all, std::numeric_limits<double>::infinity(), found);
        double deepest = std::numeric_limits<double>::infinity();
        for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
          const Corners p = pair.corners(t);
          const PairAnswer own = pair.solve(p, Request::distance);
          if (!(own.signed_distance < -1e-6)) continue;
          ++inside;
          deepest = std::min(deepest, own.signed_distance);
          const Vec3 outward = area_vector(p).normalized();
          if (outward.dot(own.normal) < 0.1 || own.normal.dot(pair.centre() - own.point_a) < 0) continue;
          if (!in_normal_cone(pair.model(), t, own.normal, pair.in_mesh(own.point_a), 1e-9)) continue;
          ++pushing;
          CHECK(std::any_of(found.begin(), found.end(), [&](const Contact& c) {
            return c.normal.dot(own.normal) > 0.95 && c.depth > -own.signed_distance - 1e-9;
          }));
        }
        if (std::isfinite(deepest)) CHECK(near.signed_distance == Approx(deepest).margin(1e-9));
      }
  CHECK(inside > 4000);
  CHECK(pushing > 50);
}
