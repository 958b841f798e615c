// Some points that two meshes share, if there are any.
#pragma once
#include <cstddef>
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

struct SharedPlace {
  Vec3 at;
  Vec3 inward;  ///< where surfaces cross: into both, the sum of two unit normals; else zero
};

/// About `most` points where the surfaces cross, distributed over the crossings; if they do not cross, a vertex of the
/// one inside the other. In the world, right to rounding. Empty: the two are separated, exactly.
std::vector<SharedPlace> shared_places(const Posed& a, const Posed& b, std::size_t most, const WorkLimit* limit);

}  // namespace tandem
