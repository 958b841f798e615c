#include "shapes/posed_mesh.h"

namespace tandem {

ConvexView view_hull(const Shape& mesh) {
  const Hull& hull = mesh.mesh().hull;
  return {.kind = ShapeKind::convex, .param = {}, .vertices = hull.vertices, .hull = &hull, .size = mesh.size()};
}

}  // namespace tandem
