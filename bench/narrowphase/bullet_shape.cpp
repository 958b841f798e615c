// Bullet's shapes for the narrow-phase bench.
#include "bullet_shape.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>

#include "shapes/shape_insides.h"

namespace tandem::bench {
namespace {

btScalar scalar(double x) { return static_cast<btScalar>(x); }

}  // namespace

btVector3 to_bullet(const Vec3& v) { return {scalar(v[0]), scalar(v[1]), scalar(v[2])}; }

btTransform bullet_pose(const Pose& pose, const Vec3& origin) {
  const Mat3& r = pose.rotation;
  return btTransform(btMatrix3x3(scalar(r(0, 0)), scalar(r(0, 1)), scalar(r(0, 2)), scalar(r(1, 0)), scalar(r(1, 1)),
                                 scalar(r(1, 2)), scalar(r(2, 0)), scalar(r(2, 1)), scalar(r(2, 2))),
                     to_bullet(Vec3(pose.translation - origin)));
}

std::unique_ptr<btConvexShape> bullet_convex(const Shape& s) {
  std::unique_ptr<btConvexShape> out;
  switch (s.kind()) {
    case ShapeKind::sphere:
      return std::make_unique<btSphereShape>(scalar(s.radius()));
    case ShapeKind::capsule:
      return std::make_unique<btCapsuleShapeZ>(scalar(s.radius()), scalar(s.length()));
    case ShapeKind::box:
      out = std::make_unique<btBoxShape>(to_bullet(s.half_size()));
      break;
    case ShapeKind::cylinder:
      out = std::make_unique<btCylinderShapeZ>(to_bullet(Vec3(s.radius(), s.radius(), 0.5 * s.length())));
      break;
    case ShapeKind::cone:
      out = std::make_unique<btConeShapeZ>(scalar(s.radius()), scalar(s.length()));
      break;
    case ShapeKind::convex: {
      auto hull = std::make_unique<btConvexHullShape>();
      for (const Vec3& v : s.vertices()) hull->addPoint(to_bullet(v), false);
      hull->recalcLocalAabb();
      out = std::move(hull);
      break;
    }
    case ShapeKind::triangle: {
      const auto& v = hull_of(s).vertices;
      if (v.size() != 3) return nullptr;
      out = std::make_unique<btTriangleShape>(to_bullet(v[0]), to_bullet(v[1]), to_bullet(v[2]));
      break;
    }
    default:
      return nullptr;
  }
  out->setMargin(0);
  return out;
}

}  // namespace tandem::bench
