#pragma once
#include <cstdint>

#include "mesh_model.h"

namespace tandem {

/// Two places in hierarchies and a bound on how near they are: the nearest come first out of a priority queue.
struct Item {
  double bound;
  std::uint32_t a, b;  ///< node << 3 | lane, or 4 for the root
  bool operator<(const Item& o) const { return bound != o.bound ? bound > o.bound : a != o.a ? a > o.a : b > o.b; }
};

inline constexpr std::uint32_t whole = 4;  ///< lane of the root

/// The box of a child of a node in doubles, in the mesh's frame.
struct BoxOf {
  Vec3 mid, half;
  BoxOf(const MeshModel& mesh, std::uint32_t ref) : mid(mesh.centre), half(mesh.half) {
    if ((ref & 7) == whole) return;
    const MeshNode& n = mesh.nodes[ref >> 3];
    for (int k = 0; k < 3; ++k) {
      mid[k] = mesh.centre[k] + mesh.unit * static_cast<double>(n.mid[k][ref & 7]);
      half[k] = mesh.unit * static_cast<double>(n.half[k][ref & 7]);
    }
  }
};

inline bool is_leaf(const MeshModel& mesh, std::uint32_t ref) {
  return (ref & 7) != whole && mesh.nodes[ref >> 3].count[ref & 7] > 0;
}

template <class Visit>
void each_child(const MeshModel& mesh, std::uint32_t ref, Visit&& visit) {
  const std::uint32_t node = (ref & 7) == whole ? 0 : mesh.nodes[ref >> 3].child[ref & 7];
  for (std::uint32_t k = 0; k < mesh.nodes[node].lanes; ++k) visit(node << 3 | k);
}

template <class Visit>
void each_triangle(const MeshModel& mesh, std::uint32_t leaf, Visit&& visit) {
  const MeshNode& n = mesh.nodes[leaf >> 3];
  for (std::uint32_t k = 0; k < n.count[leaf & 7]; ++k) visit(mesh.order[n.child[leaf & 7] + k]);
}

}  // namespace tandem
