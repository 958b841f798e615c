// The face, edge or point of a convex shape in a direction: the input of clipping.
#pragma once
#include "shapes/support.h"

namespace tandem {

/// The most corners of a face that is clipped; circles have this many.
constexpr int max_corners = 16;

/// A face (3 or more corners, counterclockwise from outside), an edge or a point of a shape, in some frame. For a
/// capsule that leans: the edge along its side, and the ball beyond its end with the farthest point.
struct FlatFeature {
  Vec3 corner[max_corners];
  int count = 0;
  int lowest = -1;             ///< the corner that is a leaning disc's deepest point
  Vec3 normal = Vec3::Zero();  ///< unit, of a face
  std::uint32_t id = 0;
  Vec3 ball = Vec3::Zero();  ///< centre of a capsule's end
  double radius = 0;         ///< of the ball; 0 for other shapes
  Vec3 end = Vec3::Zero();   ///< unit, along the axis towards that end

  bool is_face() const { return count >= 3 && radius == 0; }

  void add(const Vec3& p) { corner[count++] = p; }
};

/// The face most aligned with d (unit, in the shape's frame), or the edge or point that represents it on round shapes.
/// Of more than `max_corners` corners those around `other` (in the shape's frame) are kept, if that is given and lies
/// on one side of the face's middle; else some all around.
FlatFeature best_face(const ConvexView& v, const Vec3& d, const FlatFeature* other = nullptr);
/// True if the face has only some of its corners.
bool has_more_corners(const ConvexView& v, const FlatFeature& face);

/// The edge that lies in the contact plane with outward normal d; none (count 0) if d is not a normal of an edge.
FlatFeature flush_edge(const ConvexView& v, const Vec3& d);

/// Transforms the feature from B's frame to A's.
void move(FlatFeature& f, const RelativePose& pose);

}  // namespace tandem
