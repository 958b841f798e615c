#pragma once
#include <array>
#include <optional>
#include <string_view>

#include "solvers.h"
#include "support.h"

namespace tandem {

/// The rows of the solver table, cheapest first. `bvh` is the one for meshes.
enum class Method : std::uint8_t { closed, sat, gjk, newton, fcl, libccd, mpr, bvh };

/// Their names, in that order.
inline constexpr std::array<std::string_view, 8> method_names = {"closed", "sat",    "gjk", "newton",
                                                                 "fcl",    "libccd", "mpr", "bvh"};
std::optional<Method> find_method(std::string_view solver);

/// Does the method answer this (unordered) pair of convex kinds?
bool covers(Method method, ShapeKind a, ShapeKind b);

/// The method that is right to rounding for the pair, and cheapest among those.
Method best_method(ShapeKind a, ShapeKind b);

/// Empty where the method cannot answer the request for this pair (it then falls to gjk), or failed at it.
std::optional<bool> fcl_collide(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b);
std::optional<LocalAnswer> fcl_signed_distance(const ConvexView& a, const ConvexView& b, const RelativePose& pose);
std::optional<bool> ccd_collide(const ConvexView& a, const ConvexView& b, const RelativePose& pose, bool portal);
std::optional<LocalAnswer> ccd_depth(const ConvexView& a, const ConvexView& b, const RelativePose& pose, bool portal);

}  // namespace tandem
