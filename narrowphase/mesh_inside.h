#pragma once
#include "mesh_model.h"

namespace tandem {

/// Is a point, not on the surface, inside a closed mesh (winding number not 0)? `p` in the mesh's frame.
bool is_inside(const MeshModel& mesh, const Vec3& p);

}  // namespace tandem
