// A bottom node's triangles and a convex shape, a lane each: which lie so deep in it that they push nowhere.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "shapes/convex_view.h"
#include "shapes/mesh_model.h"

namespace tandem {

/// What a bottom node's triangles with a convex shape show, a lane each, without a solver; lengths in metres.
struct ScreenedTriangles {
  /// A bit for each of which a point is inside for sure and the chord is longer than the depth. What follows is told of
  /// these alone: in other lanes it may be what an earlier call has left there.
  std::uint32_t deep = 0;
  /// A bit for each of which nothing that the convex shape shows against the normal (of a surface that is no solid: on
  /// the side of its middle) lies over the triangle.
  std::uint32_t beside = 0;
  /// No less than the triangle's depth.
  alignas(64) double depth[mesh_lanes];
  /// Of the convex shape, from a point of the triangle on against the triangle's normal; of a surface the shorter one
  /// of both ways.
  alignas(64) double chord[mesh_lanes];
  /// By how much the cosine of an angle to the triangle's normal may be off.
  alignas(64) double cosine_off[mesh_lanes];
  std::uint32_t outside_of = 0;  ///< a hull's face that those looked at last were outside of; says what is tried first
};

/// The convex shape in its frame, and what takes a mesh's corners there.
struct ScreeningShape {
  /// Of a direction the length across an axis above which it tells a point of the circle about that; below, all of the
  /// circle counts. What is off by x is off by at most 2 x / least_lean once it is divided by its length.
  static constexpr double least_lean = 0.1;
  /// A normal that may be off by more tells nothing. Less than 1, so that a cylinder's side, which counts where the
  /// length along the axis is less than that across plus this, is not divided by 0, nor by less than `least_lean`.
  static constexpr double most_off = 0.5;

  ShapeKind kind{};
  double param[3]{};  ///< a ConvexView's; of capsules, cylinders and cones half the length
  double slant = 0;   ///< metres, from a cone's apex to the edge of its base
  const Hull* hull = nullptr;
  double to_own[3][4]{};  ///< from the mesh's units
  double middle[3]{};
  double pad = 0;         ///< metres, what counts as nothing
  double corner_off = 0;  ///< metres, by how much a corner may be off its place by rounding
  /// Metres: where a normal is off by an angle, heights over a triangle's sides are off by at most that times this.
  double reach = 0;
  bool solid = false;     ///< the mesh
};

/// Triangles of a bottom node against a convex shape, all at once.
class TriangleScreen {
 public:
  /// `shift` and `turn` take the mesh's frame to that of the shape: turn^T (p - shift). `size`: of both.
  TriangleScreen(const MeshModel& mesh, const ConvexView& convex, const Mat3& turn, const Vec3& shift, double size);

  /// Of spheres, capsules, boxes, cylinders, cones, ellipsoids and hulls of no more faces than `most_faces_in_turn`.
  bool applies() const { return applies_; }
  /// Of a call of `look`, in a WorkMeter's.
  int units() const { return units_; }
  /// `within`: a bit for each of the triangles that are asked for.
  void look(const MeshNode& bottom, std::uint32_t within, ScreenedTriangles& out) const;

 private:
  const MeshModel& mesh_;
  ScreeningShape shape_;
  bool applies_;
  int units_ = 1;
};

}  // namespace tandem
