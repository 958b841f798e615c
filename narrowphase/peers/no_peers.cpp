// Replaces FCL and libccd where the library is built without them: their names are refused, so these functions are not
// called.
#include "peers/peer_solvers.h"

namespace tandem {

std::optional<bool> fcl_collide(const ConvexView&, const Pose&, const ConvexView&, const Pose&) { return {}; }
std::optional<LocalAnswer> fcl_signed_distance(const ConvexView&, const ConvexView&, const RelativePose&) { return {}; }
std::optional<bool> ccd_collide(const ConvexView&, const ConvexView&, const RelativePose&, bool) { return {}; }
std::optional<LocalAnswer> ccd_depth(const ConvexView&, const ConvexView&, const RelativePose&, bool) { return {}; }

}  // namespace tandem
