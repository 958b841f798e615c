// The triangles of a bottom node and a convex shape, one per lane: which lie so deep in it that they have no contact
// beyond those along their own normals.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "shapes/convex_view.h"
#include "shapes/mesh_model.h"

namespace tandem {

/// Bounds for the triangles of a bottom node against a convex shape, one per lane, without a solver; lengths in metres.
struct ScreenedTriangles {
  /// A bit for each triangle that has a point certainly inside, and whose chord is longer than its depth. The fields
  /// below are set for these only; other lanes may hold values of an earlier call.
  std::uint32_t deep = 0;
  /// A bit for each triangle over which no part of the shape's side against the normal lies (for a surface that is not
  /// solid: on the side of the shape's middle).
  std::uint32_t beside = 0;
  /// An upper bound on the triangle's depth.
  alignas(64) double depth[mesh_lanes];
  /// The length inside the convex shape from a point of the triangle against the triangle's normal; for a surface the
  /// shorter one of both directions.
  alignas(64) double chord[mesh_lanes];
  /// A bound on the error of the cosine of an angle to the triangle's normal.
  alignas(64) double cosine_off[mesh_lanes];
  std::uint32_t outside_of = 0;  ///< the hull's face outside of which the last triangles were: tested first
};

/// The convex shape in its frame, and the transformation of a mesh's corners to it.
struct ScreeningShape {
  /// The length of a direction's component across an axis above which it determines a point of the circle about the
  /// axis; below, the whole circle counts. An error of x is at most 2 x / least_lean after division by that length.
  static constexpr double least_lean = 0.1;
  /// A normal with a larger error is not used. Less than 1, so that a cylinder's side, which counts where the
  /// length along the axis is less than that across plus this, is not divided by 0, nor by less than `least_lean`.
  static constexpr double most_off = 0.5;

  ShapeKind kind{};
  double param[3]{};  ///< as in ConvexView; for capsules, cylinders and cones half the length
  double slant = 0;   ///< metres, from a cone's apex to the edge of its base
  const Hull* hull = nullptr;
  double to_own[3][4]{};  ///< from the mesh's units
  double middle[3]{};
  double pad = 0;         ///< metres: lengths up to this count as 0
  double corner_off = 0;  ///< metres: the rounding error of a corner's position
  /// Metres: an error of a normal's angle, times this, bounds the error of heights over a triangle's sides.
  double reach = 0;
  bool solid = false;     ///< true: the mesh is solid
};

/// Screens the triangles of a bottom node against a convex shape, all at once.
class TriangleScreen {
 public:
  /// `shift` and `turn` take the mesh's frame to that of the shape: turn^T (p - shift). `size`: of both.
  TriangleScreen(const MeshModel& mesh, const ConvexView& convex, const Mat3& turn, const Vec3& shift, double size);

  /// True for spheres, capsules, boxes, cylinders, cones, ellipsoids and hulls of at most `most_faces_in_turn` faces.
  bool applies() const { return applies_; }
  /// The work of a call of `look`, in units of WorkMeter.
  int units() const { return units_; }
  /// `within`: a bit for each triangle to be screened.
  void look(const MeshNode& bottom, std::uint32_t within, ScreenedTriangles& out) const;

 private:
  const MeshModel& mesh_;
  ScreeningShape shape_;
  bool applies_;
  int units_ = 1;
};

}  // namespace tandem
