// The normal cone of a surface about a point of it: the directions along which a contact there pushes.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "shapes/triangle_fan.h"

namespace tandem {

/// Is n (unit, mesh's frame) in the normal cone of the feature of triangle t (its face, an edge, a corner) that lies
/// farthest along it? It is if no triangle beside that feature reaches farther: on a flat or hollow surface only faces
/// push, not the edges between them. `at` is where t is touched: of an edge only what lies beside it there counts,
/// around its corners within `slack` of these.
bool in_normal_cone(const MeshModel& mesh, std::uint32_t t, const Vec3& n, const Vec3& at, double slack);

/// Does a triangle around corner k of t reach farther along n than that corner?
bool has_higher_neighbour(const MeshModel& mesh, std::uint32_t t, std::size_t k, const Vec3& n);

/// What holds the normal cones of a triangle's edges and corners: cones spanned by the normals of the triangles about
/// each.
class CornerNormals {
 public:
  /// False where they are not known: at borders and slivers.
  bool find(const MeshModel& mesh, std::uint32_t t);

  /// least_cosine() alone, less by at most 1e-6, kept with the mesh; none where it is not known.
  static std::optional<double> kept_least_cosine(const MeshModel& mesh, std::uint32_t t);

  const Vec3& normal() const { return normal_; }  ///< the triangle's own, unit
  /// Of the angle between that and any direction in the cones, at most; with something to spare for rounding.
  double least_cosine() const { return least_cosine_; }
  /// Unit, about corner k; the first is the triangle's own, the first two are those on both sides of edge k, which
  /// leads from corner k to the next.
  std::span<const Vec3> normals(std::size_t k) const { return std::span(normals_[k]).first(count_[k]); }
  /// Vertices about corner k, none of which reaches farther than that along a direction of its normal cone; the first
  /// two are the edge's end and the one across it.
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
