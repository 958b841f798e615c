// Quick certain tests of two shapes by the line between their centres.
#pragma once
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The result of testing the line between two interior points of the shapes.
struct CentreTest {
  enum class Verdict : std::uint8_t { open, apart, overlapping } verdict = Verdict::open;
  Vec3 between = Vec3::Zero();  ///< if apart: the direction of the line, world, from A to B
};

/// Tests whether the shapes are separated by more than the margin along the line of centres, or overlap by balls inside
/// both: most pairs of a scene are one or the other, and need no solver. Certain, rounding included; the same with A
/// and B exchanged. Both shapes convex and bounded.
CentreTest test_centres(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin);

/// The separation along the unit normal n, in world directions, to rounding.
double separation(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& n);

/// A separation of two meshes.
struct MeshGap {
  double at_least = 0;         ///< a lower bound in metres on their distance; 0: unknown
  Vec3 normal = Vec3::Zero();  ///< unit, world, from A to B, a direction of that separation
};

/// Tests two shapes with triangles along the line between the centres of their hulls, which separates most pairs that
/// are apart: certain, rounding included, the same with A and B exchanged.
MeshGap test_hulls(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                   const WorkLimit* limit = nullptr);

/// The separation of a mesh's hull from a bounded convex shape along the line between their centres, metres, certain;
/// 0: unknown. It separates most pairs that are apart but whose boxes are near.
double test_hull(const Shape& mesh, const Pose& pose_mesh, const Shape& convex, const Pose& pose_convex,
                 const WorkLimit* limit = nullptr);

}  // namespace tandem
