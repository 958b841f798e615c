// Relations between what `solve` answers and what the other calls, options and kinds do.
#pragma once
#include <string>

#include "relations.h"

namespace tandem::relations {

std::string motions(const Case& c, Random& random);
std::string contact_points(const Case& c, Random& random);
std::string planes(const Case& c, Random& random);
std::string along(const Case& c, Random& random);
std::string least_depth(const Case& c, Random& random);
std::string options(const Case& c, Random& random);
std::string lanes(const Case& c, Random& random);
std::string scene(const Case& c, Random& random);
std::string near_triangles(const Case& c, Random& random);
std::string triangle_places(const Case& c, Random& random);
std::string cloud(const Case& c, Random& random);
std::string unions(const Case& c, Random& random);
std::string deformed(const Case& c, Random& random);

}  // namespace tandem::relations
