#pragma once
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// What the line between two points inside the shapes tells.
struct CentreTest {
  enum class Verdict : std::uint8_t { open, apart, overlapping } verdict = Verdict::open;
  Vec3 between = Vec3::Zero();  ///< apart: the line, world, from A to B
};

/// Apart by more than the margin along the line of centres, or overlapping by balls inside both: most pairs of a scene
/// are the one or the other, and no solver need be started. Certain, rounding included; the same with A and B
/// exchanged. Both shapes convex and bounded.
CentreTest test_centres(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin);

/// How far apart they are along the unit normal n, in world directions, to rounding.
double separation(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& n);

/// What is known of two meshes that are apart.
struct MeshGap {
  double at_least = 0;  ///< metres between any point of one and of the other; 0: not known
  Vec3 normal =
      Vec3::Zero();  ///< where it is: unit, world, from A to B, a direction along which they are that far apart
};

/// Two with triangles by the line between the middles of their hulls, which parts most that are apart: certain,
/// rounding included, the same with A and B exchanged.
MeshGap test_hulls(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                   const WorkLimit* limit = nullptr);

/// How far a mesh's hull keeps from a bounded convex shape along the line between their middles, metres, certain; 0:
/// not known. Most that are near by their boxes and apart are so by this.
double test_hull(const Shape& mesh, const Pose& pose_mesh, const Shape& convex, const Pose& pose_convex,
                 const WorkLimit* limit = nullptr);

}  // namespace tandem
