#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "shapes/hull.h"
#include "shapes/kept_cosines.h"
#include "shapes/lazily.h"
#include "shapes/normal_cones.h"
#include "shapes/uninitialised.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

inline constexpr std::uint32_t no_index = 0xffffffffu;

inline constexpr std::size_t mesh_lanes = 8;
inline constexpr std::size_t most_mesh_levels = 64;  ///< of a hierarchy: MeshModel::depth is less

/// A node of the hierarchy: up to eight children, or, of a bottom node, triangles. Boxes are floats rounded outward,
/// about MeshModel::centre, in units of MeshModel::unit.
class alignas(32) MeshNode {
 public:
  float box_mid[3], box_half[3];  ///< around all that it holds
  std::uint32_t block;            ///< a bottom node's triangles, in the lanes' order; of others the boxes and slabs

  /// `lanes`: in use, 1..8. A bottom node's triangles are order[first, first + lanes); of others `first` is 0.
  void set(bool is_bottom, std::uint32_t lanes, std::uint32_t first) {
    packed_ = first << 4 | (lanes - 1) << 1 | (is_bottom ? 1 : 0);
  }
  bool bottom() const { return (packed_ & 1) != 0; }
  std::uint32_t lanes() const { return (packed_ >> 1 & 7) + 1; }
  std::uint32_t first() const { return packed_ >> 4; }

  std::uint32_t used() const { return (2u << (packed_ >> 1 & 7)) - 1; }
  float reach() const { return std::max({box_half[0], box_half[1], box_half[2]}); }

 private:
  std::uint32_t packed_;
};

/// The boxes of an inner node's children, or of a bottom node's triangles, side by side, so that one instruction tests
/// a bound of all. An unused lane of an inner node has half = -1e30 and touches nothing.
struct alignas(32) LaneBoxes {
  float mid[3][mesh_lanes];
  float half[3][mesh_lanes];
};

struct alignas(32) ChildBoxes : LaneBoxes {
  std::uint32_t child[mesh_lanes];  ///< nodes
};

/// Corners of the triangles of a bottom node, in the units and about the centre of its boxes; lanes not in use repeat
/// the last one.
struct alignas(32) TriangleBlock {
  float corner[3][3][mesh_lanes];  ///< [corner][axis]
};

/// What lies under the children of an inner node, each between two planes of a direction of its own, in which it is
/// thin: |normal . x - mid| <= half, in the units and about the centre of its boxes; rounded outward.
struct alignas(32) ChildSlabs {
  float normal[3][mesh_lanes];  ///< of length 1 to rounding
  float mid[mesh_lanes];
  float half[mesh_lanes];
};

namespace detail {

/// The convex hull of a mesh's vertices in use.
struct MeshHull {
  Hull hull;
  std::vector<std::uint32_t>
      extreme;  ///< the mesh's vertices that are the hull's: enough for bounds (to 1e-12 of the size)
};

/// A checked mesh with what queries need of it, built once but for what only some queries need. Immutable where more
/// than one knows of it.
struct MeshModel {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< of a surface turned to go round alike, a closed one outward
  bool solid = false;
  /// Vertices change every now and then (DeformableMesh): the hull, which takes longer than all else, is asked for
  /// where an answer needs it, and never to be quicker.
  bool bends = false;
  /// Every edge joins as many triangles in one sense as in the other: a solid's, or a surface that could be one's.
  bool closed = false;

  /// Triangle on the other side of edge k, from corner k to corner k + 1; no_index on a border. Corners with equal
  /// coordinates are one vertex here; of a surface's borders also those with coordinates that differ by rounding only.
  using Neighbours = std::vector<std::array<std::uint32_t, 3>>;

  // Made when first asked for, from any thread. Who asks may be ended by a limit while it is made: WorkStopped is
  // thrown, nothing is left, and the next who asks makes it.
  const Neighbours& neighbours(const WorkLimit* limit = nullptr) const;  ///< of all copies the same
  const Hull& hull(const WorkLimit* limit = nullptr) const { return with_hull(limit).hull; }
  bool is_hull_made() const { return hull_.made() != nullptr; }
  const std::vector<std::uint32_t>& extreme(const WorkLimit* limit = nullptr) const { return with_hull(limit).extreme; }
  const NormalCones& normal_cones(const WorkLimit* limit = nullptr) const;
  /// Of the angle between each triangle's normal and the directions in which it may push (CornerNormals).
  const KeptCosines& least_cosines() const {
    return least_cosines_.get(nullptr, [&](const WorkLimit*) { return KeptCosines(triangles.size()); });
  }
  /// Closed, and the surface of its hull, to 1e-13 of the size.
  bool own_hull(const WorkLimit* limit = nullptr) const;
  bool convex(const WorkLimit* limit = nullptr) const {
    return solid && own_hull(limit);
  }  ///< it is solved as its hull

  /// Vertices of what hangs together by vertices with equal coordinates: those farthest along -x, x, -y, y, -z, z.
  using Component = std::array<std::uint32_t, 6>;
  const std::vector<Component>& components(const WorkLimit* limit = nullptr) const;  ///< made as the hull is
  /// For each vertex the first of those that are one; empty where each is only itself.
  std::vector<std::uint32_t> stands_for;

  Vec3 centre = Vec3::Zero();         ///< of the bounding box
  Vec3 half = Vec3::Zero();           ///< of the bounding box
  double unit = 1;                    ///< power of two, at least the largest half
  UninitialisedList<MeshNode> nodes;  ///< the root is nodes[0]
  UninitialisedList<TriangleBlock> blocks;
  UninitialisedList<ChildBoxes> boxes;
  UninitialisedList<ChildSlabs> slabs;
  std::vector<std::uint32_t> order;  ///< triangles in the leaves' order
  int depth = 0;                     ///< levels of nodes: bounds every traversal's stack

  const ChildBoxes& boxes_of(const MeshNode& inner) const { return boxes[inner.block]; }
  std::uint32_t triangle_of(const MeshNode& bottom, std::uint32_t lane) const { return order[bottom.first() + lane]; }
  /// By which boxes about corners in floats are to be wider, so that they hold the corners as given; units.
  float corner_pad() const;
  /// Of the triangles of a bottom node. Lanes not in use are as the last one.
  void boxes_of_triangles(const MeshNode& bottom, LaneBoxes& out) const;
  /// Of a node's children or triangles; `room` holds the latter.
  const LaneBoxes& lane_boxes(const MeshNode& node, LaneBoxes& room) const {
    if (!node.bottom()) return boxes_of(node);
    boxes_of_triangles(node, room);
    return room;
  }

  ShapeMemory memory() const;

  std::array<Vec3, 3> corners(std::uint32_t triangle) const {
    const auto& t = triangles[triangle];
    return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
  }

  /// After vertices have changed.
  void forget_extremes() {
    hull_.clear(), own_hull_.clear(), components_.clear(), cones_.clear(), least_cosines_.clear();
  }

 private:
  const MeshHull& with_hull(const WorkLimit* limit) const;

  std::shared_ptr<const Lazily<Neighbours>> neighbours_ = std::make_shared<const Lazily<Neighbours>>();
  Lazily<MeshHull> hull_;
  Lazily<bool> own_hull_;
  Lazily<std::vector<std::uint32_t>> component_numbers_;  // of each vertex in use; stay as vertices move
  Lazily<NormalCones> cones_;
  Lazily<KeptCosines> least_cosines_;
  Lazily<std::vector<Component>> components_;
};

}  // namespace detail

using detail::MeshHull;
using detail::MeshModel;

}  // namespace tandem
