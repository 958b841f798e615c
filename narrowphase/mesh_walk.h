#pragma once
#include <cstdint>

#include "mesh_model.h"

namespace tandem {

/// Two places in hierarchies and a bound on how near they are: the nearest come first out of a priority queue.
struct Item {
  double bound;
  std::uint32_t a, b;  ///< node << 4 | lane, or 8 for the root
  bool operator<(const Item& o) const { return bound != o.bound ? bound > o.bound : a != o.a ? a > o.a : b > o.b; }
};

inline constexpr std::uint32_t whole = 8;  ///< lane of the root

/// The box of a child of a node in doubles, in the mesh's frame.
struct BoxOf {
  Vec3 mid, half;
  BoxOf(const MeshModel& mesh, std::uint32_t ref) : mid(mesh.centre), half(mesh.half) {
    if ((ref & 15) == whole) return;
    const MeshNode& n = mesh.nodes[ref >> 4];
    for (int k = 0; k < 3; ++k) {
      mid[k] = mesh.centre[k] + mesh.unit * static_cast<double>(n.mid[k][ref & 15]);
      half[k] = mesh.unit * static_cast<double>(n.half[k][ref & 15]);
    }
  }
};

inline bool is_leaf(const MeshModel& mesh, std::uint32_t ref) {
  return (ref & 15) != whole && mesh.nodes[ref >> 4].count[ref & 15] > 0;
}

template <class Visit>
void each_child(const MeshModel& mesh, std::uint32_t ref, Visit&& visit) {
  const std::uint32_t node = (ref & 15) == whole ? 0 : mesh.nodes[ref >> 4].child[ref & 15];
  for (std::uint32_t k = 0; k < mesh.nodes[node].lanes; ++k) visit(node << 4 | k);
}

template <class Visit>
void each_triangle(const MeshModel& mesh, std::uint32_t leaf, Visit&& visit) {
  const MeshNode& n = mesh.nodes[leaf >> 4];
  for (std::uint32_t k = 0; k < n.count[leaf & 15]; ++k) visit(mesh.order[n.child[leaf & 15] + k]);
}

}  // namespace tandem
