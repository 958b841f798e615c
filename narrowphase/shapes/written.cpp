#include "shapes/written.h"

#include <sstream>

namespace tandem {

std::string written(double x) {
  std::ostringstream out;
  out.precision(17);
  out << x;
  return out.str();
}

std::string written(const Vec3& v) {
  std::ostringstream out;
  out.precision(17);
  out << "(" << v.x() << ", " << v.y() << ", " << v.z() << ")";
  return out.str();
}

}  // namespace tandem
