#pragma once
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Makes now what queries of a mesh make when they first need it, which takes some ten milliseconds for 100,000
/// triangles: its hull, whether it is that, what of it hangs together, cones of its normals. Copies of the shape share
/// it. From any thread. Nothing for other kinds, nor for a mesh that bends (DeformableMesh), whose queries do without
/// most of it. Throws WorkStopped where the limit (null: none) ended it.
void prepare(const Shape& shape, const WorkLimit* limit = nullptr);

}  // namespace tandem
