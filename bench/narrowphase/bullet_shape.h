// Bullet's shapes and poses for ours.
#pragma once
#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <memory>

#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

inline constexpr bool bullet_is_double = sizeof(btScalar) == sizeof(double);

btVector3 to_bullet(const Vec3& v);
inline Vec3 from_bullet(const btVector3& v) { return {v[0], v[1], v[2]}; }

/// The pose relative to `origin`: large coordinates would cost a float its digits.
btTransform bullet_pose(const Pose& pose, const Vec3& origin);

/// Bullet's convex shape; null if it has none of the kind. Without margin where a margin would round edges off.
std::unique_ptr<btConvexShape> bullet_convex(const Shape& shape);

}  // namespace tandem::bench
