// Exact test of a point in a closed mesh.
#pragma once
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// True if the point `pose_p` * p is inside a closed mesh (winding number not 0) or on it. Exact for the real numbers R
/// v + t. Throws WorkStopped once the limit, if any, is reached.
bool is_inside(const MeshModel& mesh, const Pose& pose, const Vec3& p, const Pose& pose_p,
               const WorkLimit* limit = nullptr);

/// True if a point in the mesh's frame is inside it or on it.
bool is_inside(const MeshModel& mesh, const Vec3& p, const WorkLimit* limit = nullptr);

}  // namespace tandem
