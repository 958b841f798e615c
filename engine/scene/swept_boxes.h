// Boxes that contain a moving shape and all points within its share of the gap up to which two shapes count as touching
// (touch_share), for consecutive intervals of its motion.
#pragma once
#include <array>
#include <cstddef>

#include "tandem/broadphase/box_array.h"
#include "tandem/narrowphase/motion.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// The largest distance of a point of a shape, at most `reach` from its origin, from the straight line between its
/// start and end, during the motion: an eighth of its acceleration.
double bulge(const Motion& motion, double reach);
/// The longest path of such a point during the motion, metres.
double path_length(const Motion& motion, double reach);
/// The largest distance of a bounded shape's points from its origin, metres. The limit may end the building of a mesh's
/// hull.
double reach_of(const Shape& shape, const WorkLimit* limit = nullptr);

/// What a shape adds to that gap, metres, if none of its points has a longer path than `path`.
double touch_share(const Shape& shape, double path = 0);

/// One box for the whole motion: for a short one, or where a wide box will do.
Aabb swept_box(const Shape& shape, const Motion& motion);

/// Divides the motion into intervals about as long as the shape; a point's path in one departs from the straight line
/// between its ends by at most an eighth of its acceleration times the square of the interval.
class SweptBoxes {
 public:
  SweptBoxes(const Shape& shape, const Motion& motion, const WorkLimit* limit = nullptr);

  std::size_t size() const { return size_; }
  double begins(std::size_t i) const { return static_cast<double>(i) / static_cast<double>(size()); }
  const Aabb& box(std::size_t i) const { return boxes_[i]; }

 private:
  static constexpr std::size_t most = 64;

  std::array<Aabb, most> boxes_;
  std::size_t size_ = 0;
};

}  // namespace tandem
