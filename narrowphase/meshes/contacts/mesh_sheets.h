#pragma once
#include <array>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "manifold/patch_collector.h"
#include "shapes/mesh_model.h"
#include "shapes/unit_vector.h"
#include "triangles/predicates.h"

namespace tandem {

template <class T>
using List = std::pmr::vector<T>;

/// Two meshes; what is computed is in A's frame.
struct PosedMeshes {
  const MeshModel& a;
  const MeshModel& b;
  const TriangleTest& frame;
  /// Its triangles are taken to go round the other way: of a surface with a border either side may be the outer one.
  bool turned_a = false, turned_b = false;

  bool turned(bool of_a) const { return of_a ? turned_a : turned_b; }
  std::array<Vec3, 3> corners(bool of_a, std::uint32_t t) const {
    if (of_a) return a.corners(t);
    auto c = b.corners(t);
    for (Vec3& v : c) v = frame.in_a(v);
    return c;
  }
  Vec3 vertex(bool of_a, std::uint32_t v) const { return of_a ? a.vertices[v] : frame.in_a(b.vertices[v]); }
  const MeshModel& mesh(bool of_a) const { return of_a ? a : b; }
};

/// A triangle of a patch, in A's frame.
struct Facet {
  std::uint32_t triangle;
  std::array<Vec3, 3> p;
  Vec3 n;  ///< unit, from A to B; zero without area
};

/// Of B, of A.
using Facets = std::array<std::span<const Facet>, 2>;

inline Facet facet_of(const PosedMeshes& m, bool of_a, std::uint32_t t) {
  Facet f{t, m.corners(of_a, t), Vec3::Zero()};
  const Vec3 area = (f.p[1] - f.p[0]).cross(f.p[2] - f.p[0]);
  if (const double length = area.norm(); length > 0) f.n = unit(m.turned(of_a) == of_a ? Vec3(-area) : area, length);
  return f;
}

/// Where flat faces of both meshes have sunk into each other, as thick all over, it is these that push: adds the
/// corners of what each two of them share, along their normal. Of two whose edges have gone past each other only those
/// count that have less of a way; in a corner of either mesh all. `facets` are those of a patch, `area` the area vector
/// of its curve, zero where that is not known. False, and nothing: there are no such faces, or they are the lesser part
/// of the patch. What `room` holds stays as it is.
bool add_sheets(const PosedMeshes& m, const Facets& facets, const Vec3& area, std::pmr::memory_resource* memory,
                PatchCollector& collector, std::vector<Contact>& room);

}  // namespace tandem
