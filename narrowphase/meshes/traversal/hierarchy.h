// Places in a mesh's hierarchy, for best-first traversals of two.
#pragma once
#include <cstdint>

#include "shapes/mesh_hierarchy.h"
#include "shapes/mesh_model.h"

namespace tandem {

/// Places in two hierarchies with a lower bound on their distance: the nearest come first out of a priority queue.
struct Item {
  double bound;
  std::uint32_t a, b;  ///< child_ref, or `whole`
  bool operator<(const Item& o) const { return bound != o.bound ? bound > o.bound : a != o.a ? a > o.a : b > o.b; }
};

/// A child of a node as one number. The root is no node's child: `whole` stands for it.
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
    float in_units[3], half_in_units[3];
    if (n.bottom()) {
      box_of_triangle(mesh, mesh.triangle_of(n, lane_of(ref)), in_units, half_in_units);
    } else {
      const ChildBoxes& boxes = mesh.boxes_of(n);
      for (int k = 0; k < 3; ++k)
        in_units[k] = boxes.mid[k][lane_of(ref)], half_in_units[k] = boxes.half[k][lane_of(ref)];
    }
    for (int k = 0; k < 3; ++k) {
      mid[k] = mesh.centre[k] + mesh.unit * static_cast<double>(in_units[k]);
      half[k] = mesh.unit * static_cast<double>(half_in_units[k]);
    }
  }
};

inline bool is_leaf(const MeshModel& mesh, std::uint32_t ref) {
  return lane_of(ref) != whole && mesh.nodes[node_of(ref)].bottom();
}

/// The node of a place that is not a leaf.
inline std::uint32_t node_under(const MeshModel& mesh, std::uint32_t ref) {
  return lane_of(ref) == whole ? 0 : mesh.boxes_of(mesh.nodes[node_of(ref)]).child[lane_of(ref)];
}

/// The triangle of a leaf, which holds one.
inline std::uint32_t leaf_triangle(const MeshModel& mesh, std::uint32_t leaf) {
  return mesh.triangle_of(mesh.nodes[node_of(leaf)], lane_of(leaf));
}

template <class Visit>
void each_child(const MeshModel& mesh, std::uint32_t ref, Visit&& visit) {
  const std::uint32_t node = node_under(mesh, ref);
  for (std::uint32_t k = 0; k < mesh.nodes[node].lanes(); ++k) visit(child_ref(node, k));
}

}  // namespace tandem
