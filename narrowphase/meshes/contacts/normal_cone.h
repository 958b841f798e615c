// The normal cone of a surface at a point: the directions along which a contact there pushes.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "shapes/triangle_fan.h"

namespace tandem {

/// True if n (unit, mesh's frame) is in the normal cone of the feature of triangle t (its face, an edge, a corner) that
/// is farthest along n: no adjacent triangle reaches farther. On a flat or concave surface only faces push, not the
/// edges between them. `at` is the point of contact: for an edge only the triangles beside it count, near its ends
/// (within `slack`) also those around them.
bool in_normal_cone(const MeshModel& mesh, std::uint32_t t, const Vec3& n, const Vec3& at, double slack);

/// True if a triangle around corner k of t reaches farther along n than that corner.
bool has_higher_neighbour(const MeshModel& mesh, std::uint32_t t, std::size_t k, const Vec3& n);

/// The normal cones of a triangle's edges and corners, bounded by cones spanned by the normals of the triangles around
/// each.
class CornerNormals {
 public:
  /// False if they are unknown: at borders and slivers.
  bool find(const MeshModel& mesh, std::uint32_t t);

  /// A lower bound of least_cosine(), at most 1e-6 smaller, stored with the mesh; empty if unknown.
  static std::optional<double> kept_least_cosine(const MeshModel& mesh, std::uint32_t t);

  const Vec3& normal() const { return normal_; }  ///< the triangle's own, unit
  /// The least cosine of the angle between that normal and any direction in the cones, reduced by a margin for
  /// rounding.
  double least_cosine() const { return least_cosine_; }
  /// Unit normals about corner k; the first is the triangle's own, the first two are those on both sides of edge k,
  /// from corner k to the next.
  std::span<const Vec3> normals(std::size_t k) const { return std::span(normals_[k]).first(count_[k]); }
  /// Vertices about corner k, none of which is farther than the corner along a direction of its normal cone; the first
  /// two are the edge's end and the vertex across it.
  std::span<const std::uint32_t> around(std::size_t k) const { return std::span(around_[k]).first(count_[k]); }

 private:
  bool go_around(const MeshModel& mesh, std::uint32_t t, std::size_t k);

  Vec3 normal_;
  double least_cosine_;
  std::array<std::array<Vec3, most_about_corner>, 3> normals_;
  std::array<std::array<std::uint32_t, most_about_corner>, 3> around_;
  std::array<std::size_t, 3> count_;
};

}  // namespace tandem
