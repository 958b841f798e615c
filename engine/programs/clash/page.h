// The HTML page of clashes.
#pragma once
#include <string>
#include <vector>

#include "clash.h"

namespace tandem::clash {

/// A page that opens offline: a table of the clashes beside a drawing of the meshes, with the clashes marked. Of large
/// meshes a uniform selection of triangles is drawn.
std::string page(const std::vector<Part>& parts, const std::vector<Clash>& clashes, double clearance);

}  // namespace tandem::clash
