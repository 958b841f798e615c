// Boxes of a link in many poses, at a few nanoseconds each.
#pragma once
#include <cstddef>

#include "tandem/broadphase/box_array.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// A box in the link's frame and a ball about each of its points: all of a sphere, capsule or box, and more than the rest.
class LinkBox {
 public:
  explicit LinkBox(const Shape& link);
  LinkBox(const LinkBox& link, double margin) : LinkBox(link) { radius += margin; }  ///< grown by it, metres

  double radius;
  Vec3 centre, half;

  /// The farthest of its points from the origin of its frame.
  double reach() const { return half.norm() + centre.norm() + radius; }
};

/// Boxes in world axes of the link in poses first, first + stride, ..., `count` of them, into boxes[at], boxes[at + 1],
/// ..., several at a time, and up to a vector more behind them, where there must be room. A float's last bit is added
/// outward whether it is needed or not. `all` becomes the box of them together. False if a pose may be one that
/// require_valid refuses. As many poses from `next` on, if it is not null, are fetched into the caches meanwhile.
bool link_boxes(const LinkBox& link, const Pose* first, std::size_t stride, std::size_t count, BoxArray& boxes,
                std::size_t at, const Pose* next, Aabb& all);

}  // namespace tandem
