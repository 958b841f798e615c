// The methods that solve a pair, a row each: printed by `--list-solvers` and named by NarrowPhaseOptions::solver.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "tandem/narrowphase/solver_info.h"

namespace tandem {

enum class Method : std::uint8_t { closed, sat, gjk, newton, fcl, libccd, mpr, bvh, cells };
inline constexpr std::size_t method_count = 9;

struct MethodRow {
  Method method;
  SolverInfo info;
  bool by_peers;  ///< FCL's or libccd's: only if the library is built with them
};

inline constexpr std::array<MethodRow, method_count> method_rows = {{
    {Method::closed,
     {"closed", "closed forms: a sphere or half-space with any simple shape, capsules and boxes"},
     false},
    {Method::sat,
     {"sat", "boxes and triangles by their separating axes (Gottschalk 1996), apart by nearest points or edges"},
     false},
    {Method::gjk,
     {"gjk",
      "GJK on the shapes' cores (1988), polytopes by a portal first; expanding polytope for depths (van den Bergen "
      "2001)"},
     false},
    {Method::newton,
     {"newton", "cylinder, cone or ellipsoid with any convex shape: Newton's method on the support functions"},
     false},
    {Method::fcl, {"fcl", "FCL 0.7, collide and signed distance"}, true},
    {Method::libccd,
     {"libccd", "libccd, GJK and EPA; only touching pairs have a distance, the others' is by gjk"},
     true},
    {Method::mpr, {"mpr", "libccd, MPR (Snethen 2008); depth along the portal, an upper bound; apart: gjk"}, true},
    {Method::bvh, {"bvh", "triangle meshes by their hierarchy of boxes, exact triangle predicates"}, false},
    {Method::cells, {"cells", "voxels by their hierarchy of boxes, each cell as the box that it is"}, false},
}};
static_assert([] {
  for (std::size_t i = 0; i < method_count; ++i)
    if (method_rows[i].method != static_cast<Method>(i) || method_rows[i].info.name.empty()) return false;
  return true;
}());

constexpr std::string_view name(Method method) { return method_rows[static_cast<std::size_t>(method)].info.name; }

/// True if the method is in this build.
bool is_built(Method method);

/// The method of that name; empty for an unknown name, and for FCL's and libccd's if the library is built without them.
std::optional<Method> find_method(std::string_view solver);

}  // namespace tandem
