#include "shapes/written.h"

#include <sstream>

namespace tandem {

std::string written(double x) {
  std::ostringstream out;
  out.precision(17);
  out << x;
  return out.str();
}

std::string written(const Vec3& v) { return "(" + written(v.x()) + ", " + written(v.y()) + ", " + written(v.z()) + ")"; }

}  // namespace tandem
