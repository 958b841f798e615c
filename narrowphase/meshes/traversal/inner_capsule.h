// A capsule inside a solid mesh: shapes that intersect it collide with the mesh, without a test of triangles.
#pragma once
#include "shapes/mesh_model.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Computes the capsule, unless it was computed before: along the longest side of the mesh's box, through its middle;
/// of a few lengths the one with the largest volume. Throws WorkStopped if the limit (null: none) ended it.
void make_inner_capsule(const Shape& mesh, const WorkLimit* limit);

/// True: the capsule inside the mesh, if it was computed, intersects the other mesh's or the bounded convex shape;
/// false: not known.
bool meets_inner_capsule(const Posed& mesh, const Posed& other);

}  // namespace tandem
