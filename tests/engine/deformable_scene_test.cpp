// Replacing the shape of a scene, as for a deforming mesh: steps and queries use the new one at once.
#include <memory>

#include "catch.h"
#include "sheet_mesh.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/deformable_mesh.h"

namespace tandem {
namespace {

// A cloth of n x n squares, side 4, sagged by `depth` in the middle.
Mesh sheet(int n, double depth) {
  return test::sheet(n, [&](double x, double y) { return Vec3(2 * x, 2 * y, -depth * (1 - x * x) * (1 - y * y)); });
}

// A cloth as the shape of two bodies, with balls, a box and a ring of boxes around it.
struct ClothWorld {
  Scene scene;
  ShapeId cloth;

  explicit ClothWorld(const Shape& shape) : cloth(scene.add_shape(shape)) {
    scene.add_body({.shape = cloth, .is_static = true});
    scene.add_body({.shape = cloth, .pose = Pose::at(0.3, 0.2, -1.5), .is_static = true});
    const auto ball = scene.add_shape(Sphere{0.2}), box = scene.add_shape(Box{{0.3, 0.4, 0.2}});
    const auto floor = scene.add_shape(HalfSpace{{0, 0, 1}, -1.9});
    scene.add_body({.shape = floor, .is_static = true});
    for (int i = 0; i < 60; ++i)
      scene.add_body({.shape = i % 2 == 0 ? ball : box,
                      .pose = Pose::at(0.5 * (i % 8) - 1.8, 0.45 * (i / 8) - 1.6, 0.1 - 0.3 * (i % 5))});
  }
};

}  // namespace

TEST_CASE(
    "scenes: a shape that is replaced is seen by kept contacts, computed ones and queries as in a scene built anew") {
  DeformableMesh mesh(sheet(16, 0));
  ClothWorld world(mesh.shape());
  Pipeline kept({.threads = 2, .answer = {.keep_contacts = 1e-3, .contact_hash = true}}),
      computed({.threads = 1, .answer = {.contact_hash = true}});
  SceneQueries queries(world.scene);
  std::size_t contacts = 0;
  for (int step = 0; step < 12; ++step) {
    if (step % 3 != 2) {  // otherwise nothing has moved: contacts are kept
      mesh.update(sheet(16, 0.1 * step).vertices);
      world.scene.replace_shape(world.cloth, mesh.shape());
    }
    Mesh bent = sheet(16, 0);
    bent.vertices.assign(mesh.vertices().begin(), mesh.vertices().end());
    const ClothWorld anew{Shape(bent)};
    Pipeline fresh({.threads = 1, .answer = {.contact_hash = true}});
    const StepReport expected = fresh.step(anew.scene), report = computed.step(world.scene),
                     of_kept = kept.step(world.scene);
    CHECK(report.contact_hash == expected.contact_hash);
    CHECK(of_kept.contacts == expected.contacts);
    CHECK(of_kept.colliding_pairs == expected.colliding_pairs);
    CHECK(of_kept.max_depth == Approx(expected.max_depth));
    CHECK((step % 3 != 2 || of_kept.kept_pairs > 0));
    contacts += expected.contacts;

    if (step % 2 == 0) continue;  // queries only now and then
    queries.update(world.scene);
    const SceneQueries of_anew(anew.scene);
    for (double x = -1.5; x < 2; x += 0.5) {
      const auto hit = queries.nearest(Sphere{0.05}, Pose::at(x, 0.1, 0.4)),
                 other = of_anew.nearest(Sphere{0.05}, Pose::at(x, 0.1, 0.4));
      REQUIRE((hit && other));
      CHECK(hit->body == other->body);
      CHECK(hit->answer.signed_distance == other->answer.signed_distance);
    }
  }
  CHECK(contacts > 100);
}

TEST_CASE("scenes: what may not replace a shape") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  scene.add_body({.shape = ball});
  CHECK_THROWS_AS(scene.replace_shape(ball, HalfSpace{}), std::invalid_argument);
  CHECK_THROWS_AS(scene.replace_shape(ShapeId{}, Sphere{2}), std::invalid_argument);
  CHECK(scene.shapes()[0].kind() == ShapeKind::sphere);
  scene.replace_shape(ball, Box{{1, 1, 1}});
  CHECK(scene.has_kind(ShapeKind::box));
  CHECK_FALSE(scene.has_kind(ShapeKind::sphere));
}

}  // namespace tandem
