#pragma once
#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <memory>

#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

inline constexpr bool bullet_is_double = sizeof(btScalar) == sizeof(double);

btVector3 to_bullet(const Vec3& v);
inline Vec3 from_bullet(const btVector3& v) { return {v[0], v[1], v[2]}; }

/// Seen from `origin`: coordinates far out cost a float its digits.
btTransform bullet_pose(const Pose& pose, const Vec3& origin);

/// Null where Bullet has no convex shape of the kind. Without margin where the margin would round edges off.
std::unique_ptr<btConvexShape> bullet_convex(const Shape& shape);

}  // namespace tandem::bench
