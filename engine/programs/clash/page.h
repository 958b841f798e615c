#pragma once
#include <string>
#include <vector>

#include "clash.h"

namespace tandem::clash {

/// A page that opens offline: a table of the clashes beside a picture of the parts, the places marked. Of large parts
/// some triangles are drawn, evenly picked.
std::string page(const std::vector<Part>& parts, const std::vector<Clash>& clashes, double clearance);

}  // namespace tandem::clash
