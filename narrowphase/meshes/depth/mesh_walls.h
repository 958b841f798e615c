#pragma once
#include <span>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// Translations t with normal (unit) . t >= bound.
struct Wall {
  Vec3 normal;
  double bound;
};

/// A wall that all translations lie beyond that part two bodies and are no longer than `reach`.
struct Hold {
  Wall wall;
  double reach;
};

/// The shortest translation beyond all the walls, each to `slack`; false where there is none.
bool shortest_beyond(std::span<const Wall> walls, double slack, Vec3& shortest);

}  // namespace tandem
