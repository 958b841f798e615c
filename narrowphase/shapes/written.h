// Numbers as the messages of refusals write them: the fewest digits that tell a double from its neighbours.
#pragma once
#include <string>

#include "tandem/narrowphase/pose.h"

namespace tandem {

std::string written(double x);
std::string written(const Vec3& v);

/// What a coordinate may be: "finite and at most 1e30 in size".
std::string allowed_coordinate();

}  // namespace tandem
