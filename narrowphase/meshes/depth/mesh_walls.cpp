#include "meshes/depth/mesh_walls.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tolerances.h"

namespace tandem {

// One wall after the other: where what was found so far does not do, the answer lies on the wall (Seidel 1991, in this
// order).
bool shortest_beyond(std::span<const Wall> walls, double slack, Vec3& shortest) {
  shortest.setZero();
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const Wall& wall = walls[i];
    if (wall.normal.dot(shortest) >= wall.bound - slack) continue;
    // Within the wall's plane, from the foot on it.
    const Vec3 foot = wall.bound * wall.normal;
    const auto within = [&](const Wall& w) {
      return Wall{w.normal - w.normal.dot(wall.normal) * wall.normal, w.bound - w.normal.dot(foot)};
    };
    Vec3 y = Vec3::Zero();
    for (std::size_t j = 0; j < i; ++j) {
      const Wall line = within(walls[j]);
      if (line.normal.dot(y) >= line.bound - slack) continue;
      const double length2 = line.normal.squaredNorm();
      if (!(length2 > tolerance::parallel_planes2)) return false;
      // Along the line where the two meet.
      const Vec3 on_line = (line.bound / length2) * line.normal;
      const Vec3 along = wall.normal.cross(line.normal) / std::sqrt(length2);
      double low = -infinity, high = infinity;
      for (std::size_t k = 0; k < j; ++k) {
        const Wall other = within(walls[k]);
        const double slope = other.normal.dot(along), left = other.bound - other.normal.dot(on_line);
        if (slope > tolerance::parallel_lines) low = std::max(low, left / slope);
        if (slope < -tolerance::parallel_lines) high = std::min(high, left / slope);
        if (std::abs(slope) <= tolerance::parallel_lines && left > slack) return false;
      }
      if (low > high + slack) return false;
      y = on_line + std::clamp(0.0, low, std::max(low, high)) * along;
    }
    shortest = foot + y;
  }
  return true;
}

}  // namespace tandem
