// Boxes that hold a moving shape, for one stretch of its motion after the other.
#pragma once
#include <array>
#include <cstddef>

#include "tandem/broadphase/box_array.h"
#include "tandem/narrowphase/motion.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// How far a point of a shape that reaches so far from its origin may be, during the motion, from the straight line
/// between where it starts and ends: an eighth of its acceleration.
double bulge(const Motion& motion, double reach);
/// The most that such a point goes during the motion, metres.
double path_length(const Motion& motion, double reach);
/// How far a bounded shape reaches from its origin at most, metres. The limit may end the making of a mesh's hull.
double reach_of(const Shape& shape, const WorkLimit* limit = nullptr);

/// One box about all of the motion: for a short one, or where a wide box will do.
Aabb swept_box(const Shape& shape, const Motion& motion);

/// The motion is cut so that a stretch is about as long as the shape; a point's path in it departs from the straight
/// line between its ends by at most an eighth of its acceleration times the stretch's square.
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
