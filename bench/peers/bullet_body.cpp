// Bullet's shapes for bodies of a scene.
#include "bullet_body.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include "bullet_shape.h"

namespace tandem::bench {

BulletShape::BulletShape() = default;
BulletShape::~BulletShape() = default;

std::unique_ptr<BulletShape> bullet_shape(const Shape& shape, bool is_static) {
  auto out = std::make_unique<BulletShape>();
  if (shape.kind() == ShapeKind::halfspace) {
    out->shape = std::make_unique<btStaticPlaneShape>(to_bullet(shape.normal()), static_cast<btScalar>(shape.offset()));
    out->shape->setMargin(0);
  } else if (shape.kind() == ShapeKind::mesh) {
    for (const Vec3& v : shape.vertices()) out->vertices.push_back(to_bullet(v));
    for (const auto& triangle : shape.triangles())
      for (const std::uint32_t corner : triangle) out->indices.push_back(static_cast<int>(corner));
    out->triangles = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(shape.triangles().size()), out->indices.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(out->vertices.size()), &out->vertices[0][0], static_cast<int>(sizeof(btVector3)));
    if (is_static) {
      out->shape = std::make_unique<btBvhTriangleMeshShape>(out->triangles.get(), true);
      out->shape->setMargin(0);
    } else {
      auto mesh = std::make_unique<btGImpactMeshShape>(out->triangles.get());
      mesh->setMargin(0);
      mesh->updateBound();
      out->shape = std::move(mesh);
    }
  } else {
    out->shape = bullet_convex(shape);
  }
  return out;
}

}  // namespace tandem::bench
