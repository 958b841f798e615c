// Numbers as the messages of refusals write them: all digits that tell a double from its neighbours.
#pragma once
#include <string>

#include "tandem/narrowphase/pose.h"

namespace tandem {

std::string written(double x);
std::string written(const Vec3& v);

}  // namespace tandem
