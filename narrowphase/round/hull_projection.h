// The point of a hull nearest to another, by a search over its features.
#pragma once
#include <cstdint>

#include "convex/projection.h"
#include "shapes/hull.h"

namespace tandem {

/// The point of a hull nearest to another.
struct NearestOnHull {
  Surface surface = Surface::none;
  Vec3 q = Vec3::Zero();
  std::uint32_t vertex = 0;  ///< the corner; for an edge or a face one of its corners
  std::uint32_t other = 0;   ///< the edge's other end
  std::uint32_t face = 0;
};

/// True if the hull can be searched: it has a volume, and its faces form one ring around each vertex.
inline bool has_rings(const Hull& hull) { return !hull.neighbour_face.empty(); }

/// The nearest point to p, by steps from the vertex `from` over edges and faces (Lin and Canny 1991), each nearer than
/// the one before: a vertex, an edge or a face over which p lies. `none`, q = p, if p lies beneath the face on which
/// the search ends, as it does inside, or if there are many steps.
NearestOnHull nearest_on_hull(const Hull& hull, const Vec3& p, std::uint32_t from);

/// True if a point of the face's plane lies on the face, at least `inward` from its edges.
bool on_face(const Hull& hull, std::uint32_t face, const Vec3& q, double inward);

/// On the segment from a point of the face to another of its plane: the end, or the point where it leaves the face by
/// more than `rounding`.
Vec3 end_on_face(const Hull& hull, std::uint32_t face, const Vec3& from, const Vec3& to, double rounding);

}  // namespace tandem
