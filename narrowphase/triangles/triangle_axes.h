// Collision verdicts of triangles and boxes by separating axes.
#pragma once
#include <array>
#include <optional>
#include <span>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// True if two triangles intersect, by the axes that can separate them: their normals and the nine cross products of
/// their edges. Empty where rounding could decide: touching, coplanar and degenerate ones. Vertices in each shape's
/// frame.
std::optional<bool> triangles_collide(std::span<const Vec3, 3> a, const Pose& pose_a, std::span<const Vec3, 3> b,
                                      const Pose& pose_b);

/// True if a box (half sizes) and a triangle intersect, by the axes that can separate them (Akenine-Moeller 2001).
std::optional<bool> box_triangle_collide(const std::array<double, 4>& half, const Pose& pose_a,
                                         std::span<const Vec3, 3> b, const Pose& pose_b);

}  // namespace tandem
