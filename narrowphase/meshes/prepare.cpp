// Computes in advance the data of a mesh that queries compute on demand.
#include "tandem/narrowphase/prepare.h"

#include "meshes/traversal/inner_capsule.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"

namespace tandem {

void prepare(const Shape& shape, const WorkLimit* limit) {
  if (shape.kind() != ShapeKind::mesh || mesh_of(shape).bends) return;
  const MeshModel& mesh = mesh_of(shape);
  mesh.hull(limit);
  mesh.own_hull(limit);
  mesh.components(limit);
  mesh.normal_cones(limit);
  make_inner_capsule(shape, limit);
}

}  // namespace tandem
