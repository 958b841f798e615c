// Numbers as text for messages.
#include "shapes/written.h"

#include <charconv>

#include "tolerances.h"

namespace tandem {

std::string written(double x) {
  char text[32];
  std::string out(text, std::to_chars(text, text + sizeof text, x).ptr);
  // 1e+30 and 2e-06 are written as 1e30 and 2e-6.
  if (const std::size_t e = out.find('e'); e != out.npos) {
    std::size_t digits = e + 1;
    if (out[digits] == '+') out.erase(digits, 1);
    if (out[digits] == '-') ++digits;
    if (out[digits] == '0') out.erase(digits, 1);
  }
  return out;
}

std::string written(const Vec3& v) {
  return '(' + written(v.x()) + ", " + written(v.y()) + ", " + written(v.z()) + ')';
}

std::string allowed_coordinate() { return "finite and at most " + written(tolerance::longest_length) + " in size"; }

}  // namespace tandem
