// Some places that two meshes share, where there are any.
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

/// About `most` places where the surfaces cross, spread over all of them; if they do not cross, a vertex of what lies
/// in the other. In the world, right to rounding. None: the two are apart, exactly.
std::vector<SharedPlace> shared_places(const Posed& a, const Posed& b, std::size_t most, const WorkLimit* limit);

}  // namespace tandem
