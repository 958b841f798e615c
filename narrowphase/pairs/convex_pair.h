#pragma once
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "shapes/convex_view.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

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

/// Convex (or half-space) against convex: closed forms, SAT, GJK and the rest, by the dispatcher's table.
/// At least one of the two is bounded. Appends to `contacts` only for Request::contacts.
PairAnswer solve_convex(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b,
                        Request request, const NarrowPhaseOptions& options, std::vector<Contact>* contacts,
                        WarmStart* warm = nullptr);

}  // namespace tandem
