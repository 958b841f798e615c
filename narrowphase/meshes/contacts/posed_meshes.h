// Two meshes in the frame of the first, their triangles, and the names of contacts.
#pragma once
#include <array>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "shapes/mesh_model.h"
#include "shapes/unit_vector.h"
#include "shapes/work_meter.h"
#include "tandem/narrowphase/answer.h"
#include "triangles/predicates.h"

namespace tandem {

/// All data of a query are in one block of memory, usually on the stack, and are released with it.
using Memory = std::pmr::memory_resource*;
constexpr std::size_t usual_memory = std::size_t{48} << 10;  // bytes

template <class T>
using List = std::pmr::vector<T>;

/// Two meshes; computations are in A's frame.
struct PosedMeshes {
  const MeshModel& a;
  const MeshModel& b;
  const TriangleTest& frame;
  /// Reverses the orientation of its triangles: for a surface with a border either side may be the outer one.
  bool turned_a = false, turned_b = false;
  const WorkLimit* limit = nullptr;

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

/// Facets of B, of A.
using Facets = std::array<std::span<const Facet>, 2>;

inline Facet facet_of(const PosedMeshes& m, bool of_a, std::uint32_t t) {
  Facet f{t, m.corners(of_a, t), Vec3::Zero()};
  const Vec3 area = area_vector(f.p);
  if (const double length = area.norm(); length > 0) f.n = unit(m.turned(of_a) == of_a ? Vec3(-area) : area, length);
  return f;
}

/// The name of a vertex or edge.
constexpr std::uint32_t feature_of(std::uint32_t kind, std::uint32_t index) {
  return kind << 30 | (index & 0x3fffffffu);
}

/// By feature; for one feature in several patches by position.
void sort_contacts(std::span<Contact> contacts);

}  // namespace tandem
