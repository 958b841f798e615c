// The properties of each kind of shape: a row a kind, in which no entry may be omitted. Properties that are code
// (supports, faces, nearest points) are switches over ShapeKind without a default, so that the compiler reports them
// for a new kind.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The surface of a kind's core (every bounded convex shape is a core with a radius about each of its points).
enum class CoreSurface : std::uint8_t {
  flat,   ///< only flat faces, straight edges and vertices, or a point: a polytope
  round,  ///< at least partly curved
};

/// A required entry of a row: it has no default.
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
  Entry<bool> swept;    ///< the first parameter is the radius about the core; else the radius is 0
  Entry<bool> centred;  ///< the inscribed ball of quick tests is about the frame's origin (pairs/centre_test.cpp)
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
    {ShapeKind::voxels, "voxels", false, true, CoreSurface::flat, false, false},
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

/// The kinds whose rows satisfy `which`.
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
