// The triangles of a contact or of witness points.
#pragma once
#include <array>
#include <cstdint>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The triangle of a mesh at a point of its surface, such as a witness point: the nearest; of several equally near, as
/// beside an edge, the one most aligned with `outward` (unit, world), on either side of a surface that is not solid;
/// then the first. 0 for all other kinds. The pose must be valid.
std::uint32_t triangle_at(const Shape& shape, const Pose& pose, const Vec3& place, const Vec3& outward);

/// The triangles of A and of B on which a contact lies. Computed on demand, by a query of each mesh with a point, so
/// that contacts need not store them.
std::array<std::uint32_t, 2> triangles_at(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                          const Contact& contact);
/// The triangles of the two nearest or deepest points of an answer that has points.
std::array<std::uint32_t, 2> triangles_at(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                          const PairAnswer& answer);

}  // namespace tandem
