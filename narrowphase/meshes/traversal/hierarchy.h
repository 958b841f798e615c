#pragma once
#include <cstdint>

#include "shapes/mesh_model.h"

namespace tandem {

/// Two places in hierarchies and a bound on how near they are: the nearest come first out of a priority queue.
struct Item {
  double bound;
  std::uint32_t a, b;  ///< child_ref, or `whole`
  bool operator<(const Item& o) const { return bound != o.bound ? bound > o.bound : a != o.a ? a > o.a : b > o.b; }
};

/// A child of a node: its place in one number. The root, as a whole, is no node's child.
inline constexpr std::uint32_t whole = 15;
inline std::uint32_t child_ref(std::uint32_t node, std::uint32_t lane) { return node << 4 | lane; }
inline std::uint32_t node_of(std::uint32_t ref) { return ref >> 4; }
inline std::uint32_t lane_of(std::uint32_t ref) { return ref & 15; }

/// The box of a child of a node in doubles, in the mesh's frame.
struct BoxOf {
  Vec3 mid, half;
  BoxOf(const MeshModel& mesh, std::uint32_t ref) : mid(mesh.centre), half(mesh.half) {
    if (lane_of(ref) == whole) return;
    const MeshNode& n = mesh.nodes[node_of(ref)];
    for (int k = 0; k < 3; ++k) {
      mid[k] = mesh.centre[k] + mesh.unit * static_cast<double>(n.mid[k][lane_of(ref)]);
      half[k] = mesh.unit * static_cast<double>(n.half[k][lane_of(ref)]);
    }
  }
};

inline bool is_leaf(const MeshModel& mesh, std::uint32_t ref) {
  return lane_of(ref) != whole && mesh.nodes[node_of(ref)].count[lane_of(ref)] > 0;
}

/// The node of a place that is no leaf.
inline std::uint32_t node_under(const MeshModel& mesh, std::uint32_t ref) {
  return lane_of(ref) == whole ? 0 : mesh.nodes[node_of(ref)].child[lane_of(ref)];
}

/// The triangle of a leaf, which holds one.
inline std::uint32_t leaf_triangle(const MeshModel& mesh, std::uint32_t leaf) {
  return mesh.order[mesh.nodes[node_of(leaf)].child[lane_of(leaf)]];
}

template <class Visit>
void each_child(const MeshModel& mesh, std::uint32_t ref, Visit&& visit) {
  const std::uint32_t node = node_under(mesh, ref);
  for (std::uint32_t k = 0; k < mesh.nodes[node].lanes; ++k) visit(child_ref(node, k));
}

template <class Visit>
void each_triangle(const MeshModel& mesh, std::uint32_t leaf, Visit&& visit) {
  const MeshNode& n = mesh.nodes[node_of(leaf)];
  for (std::uint32_t k = 0; k < n.count[lane_of(leaf)]; ++k) visit(mesh.order[n.child[lane_of(leaf)] + k]);
}

}  // namespace tandem
