// Bullet's shapes for bodies of a scene.
#pragma once
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <memory>
#include <vector>

#include "tandem/narrowphase/shape.h"

class btCollisionShape;

namespace tandem::bench {

/// A shape with the data that it refers to. A mesh that moves becomes a GImpact shape, one that does not a triangle
/// tree.
struct BulletShape {
  BulletShape();
  ~BulletShape();
  std::vector<btVector3> vertices;
  std::vector<int> indices;
  std::unique_ptr<btTriangleIndexVertexArray> triangles;
  std::unique_ptr<btCollisionShape> shape;
};

std::unique_ptr<BulletShape> bullet_shape(const Shape& shape, bool is_static);

}  // namespace tandem::bench
