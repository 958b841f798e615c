#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The rows of the solver table, cheapest first. `bvh` is the one for meshes.
enum class Method : std::uint8_t { closed, sat, gjk, newton, fcl, libccd, mpr, bvh };

/// Their names, in that order.
inline constexpr std::array<std::string_view, 8> method_names = {"closed", "sat",    "gjk", "newton",
                                                                 "fcl",    "libccd", "mpr", "bvh"};
/// Empty for an unknown name, and for FCL's and libccd's where the library is built without them.
std::optional<Method> find_method(std::string_view solver);

/// Is it in this build?
bool is_built(Method method);

/// Does the method answer this (unordered) pair of convex kinds?
bool covers(Method method, ShapeKind a, ShapeKind b);

/// The method that is right to rounding for the pair, and cheapest among those.
Method best_method(ShapeKind a, ShapeKind b);

}  // namespace tandem
