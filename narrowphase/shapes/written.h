// Numbers as messages write them: the fewest digits that distinguish a double from its neighbours.
#pragma once
#include <string>

#include "tandem/narrowphase/pose.h"

namespace tandem {

std::string written(double x);
std::string written(const Vec3& v);

/// The permitted coordinates, for messages: "finite and at most 1e30 in size".
std::string allowed_coordinate();

}  // namespace tandem
