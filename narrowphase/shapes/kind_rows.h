// What each kind of shape is: a row a kind, in which no entry may be left out. What cannot stand in a row (supports,
// faces, nearest points) is a switch over ShapeKind without a default, so that the compiler names it for a new kind.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// What the surface of a kind's core is made of (every bounded convex shape is a core and a ball about each of its
/// points).
enum class CoreSurface : std::uint8_t {
  flat,   ///< flat faces, straight edges and corners alone, or a point: a polytope
  round,  ///< some of it is curved
};

/// What a row must say: it has no default.
template <class T>
struct Entry {
  T value;
  constexpr Entry(auto given) : value(given) {}
  constexpr operator T() const { return value; }
};

struct KindRow {
  Entry<ShapeKind> kind;
  Entry<std::string_view> name;  ///< in files, messages and Python
  Entry<bool> convex;
  Entry<bool> bounded;
  Entry<CoreSurface> core;
  Entry<bool> swept;    ///< the first parameter is the radius of the ball about each point of the core; else it is 0
  Entry<bool> centred;  ///< the ball inside it that quick tests use is about the frame's origin (pairs/centre_test.cpp)
};

inline constexpr std::array<KindRow, shape_kinds> kind_rows = {{
    // kind, name, convex, bounded, core, swept, centred
    {ShapeKind::sphere, "sphere", true, true, CoreSurface::flat, true, true},
    {ShapeKind::box, "box", true, true, CoreSurface::flat, false, true},
    {ShapeKind::capsule, "capsule", true, true, CoreSurface::flat, true, true},
    {ShapeKind::cylinder, "cylinder", true, true, CoreSurface::round, false, true},
    {ShapeKind::cone, "cone", true, true, CoreSurface::round, false, false},
    {ShapeKind::ellipsoid, "ellipsoid", true, true, CoreSurface::round, false, true},
    {ShapeKind::halfspace, "halfspace", true, false, CoreSurface::flat, false, true},
    {ShapeKind::convex, "convex", true, true, CoreSurface::flat, false, false},
    {ShapeKind::triangle, "triangle", true, true, CoreSurface::flat, false, false},
    {ShapeKind::mesh, "mesh", false, true, CoreSurface::flat, false, false},
    {ShapeKind::plane, "plane", true, false, CoreSurface::flat, false, true},
}};

constexpr const KindRow& kind_row(ShapeKind kind) { return kind_rows[static_cast<std::size_t>(kind)]; }

/// A set of kinds.
struct KindSet {
  std::uint32_t bits = 0;
  constexpr bool has(ShapeKind kind) const { return bits >> static_cast<unsigned>(kind) & 1u; }
};

template <class... Kind>
constexpr KindSet kinds(Kind... kind) {
  return {((1u << static_cast<unsigned>(kind)) | ...)};
}
constexpr KindSet without(KindSet all, KindSet some) { return {all.bits & ~some.bits}; }

/// The kinds whose rows `which` holds for.
template <class Which>
constexpr KindSet kinds_where(Which which) {
  KindSet set;
  for (const KindRow& row : kind_rows)
    if (which(row)) set.bits |= kinds(row.kind.value).bits;
  return set;
}

static_assert(shape_kinds <= 32);
static_assert(
    [] {
      for (std::size_t i = 0; i < shape_kinds; ++i)
        if (kind_rows[i].kind != static_cast<ShapeKind>(i)) return false;
      return true;
    }(),
    "rows stand in the order of ShapeKind");

}  // namespace tandem
