// A shape with its pose; a mesh's hull as a convex shape.
#include "shapes/posed_mesh.h"

#include "shapes/shape_insides.h"

namespace tandem {

ConvexView view_hull(const Shape& mesh, const WorkLimit* limit) {
  const Hull& hull = mesh_of(mesh).hull(limit);
  return {.kind = ShapeKind::convex, .param = {}, .vertices = hull.vertices, .hull = &hull, .size = mesh.size()};
}

}  // namespace tandem
