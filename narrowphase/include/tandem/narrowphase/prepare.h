// Preparation of meshes for queries.
#pragma once
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Computes in advance the data of a mesh that queries otherwise compute when they first need it, in some ten
/// milliseconds for 100,000 triangles: its hull, whether it equals that, its connected components, cones of its
/// normals; and of a solid of up to 8,192 triangles a capsule inside it, which queries use only if it was prepared:
/// shapes that intersect it collide, without a test of triangles. Copies of the shape share the data. From any thread.
/// Does nothing for other kinds, nor for a deforming mesh (DeformableMesh), whose queries do without most of it. Throws
/// WorkStopped if the limit (null: none) ended it.
void prepare(const Shape& shape, const WorkLimit* limit = nullptr);

}  // namespace tandem
