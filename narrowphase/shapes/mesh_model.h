// A mesh with the data that queries need: hierarchy, neighbours, hull.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "shapes/hull.h"
#include "shapes/kept_cosines.h"
#include "shapes/lazily.h"
#include "shapes/mesh_frame.h"
#include "shapes/normal_cones.h"
#include "shapes/uninitialised.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

inline constexpr std::uint32_t no_index = 0xffffffffu;

using Corners = std::array<Vec3, 3>;  ///< of a triangle

/// Perpendicular to a triangle, to the side from which its corners run counterclockwise, twice its area long.
inline Vec3 area_vector(const Corners& p) { return (p[1] - p[0]).cross(p[2] - p[0]); }

inline double least_along(const Vec3& d, const Corners& p) { return std::min({d.dot(p[0]), d.dot(p[1]), d.dot(p[2])}); }
inline double most_along(const Vec3& d, const Corners& p) { return std::max({d.dot(p[0]), d.dot(p[1]), d.dot(p[2])}); }

inline constexpr std::size_t mesh_lanes = 8;
inline constexpr std::size_t most_mesh_levels = 64;  ///< of a hierarchy: MeshModel::depth is less

/// A node of the hierarchy: up to eight children, or, for a bottom node, triangles. Boxes are floats rounded outward,
/// relative to MeshModel::centre, in units of MeshModel::unit.
class alignas(32) MeshNode {
 public:
  float box_mid[3], box_half[3];  ///< box of its whole content
  /// A bottom node's triangles, in the order of its lanes; another node's boxes and slabs.
  std::uint32_t block;

  /// `lanes`: number in use, 1..8. A bottom node's triangles are order[first, first + lanes); for others `first` is 0.
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

/// The boxes of an inner node's children, or of a bottom node's triangles, as arrays, so that one instruction tests a
/// bound of all. An unused lane of an inner node has half = -1e30 and overlaps nothing.
struct alignas(32) LaneBoxes {
  float mid[3][mesh_lanes];
  float half[3][mesh_lanes];
};

struct alignas(32) ChildBoxes : LaneBoxes {
  std::uint32_t child[mesh_lanes];  ///< indices of nodes
};

/// The corners of the triangles of a bottom node, in the units and relative to the centre of its boxes; unused lanes
/// repeat the last one.
struct alignas(32) TriangleBlock {
  float corner[3][3][mesh_lanes];  ///< [corner][axis]
};

/// The slabs of an inner node's children: each child's content lies between two planes of a direction of its own, in
/// which it is thin: |normal . x - mid| <= half, in the units and relative to the centre of its boxes; rounded outward.
struct alignas(32) ChildSlabs {
  float normal[3][mesh_lanes];  ///< unit to rounding
  float mid[mesh_lanes];
  float half[mesh_lanes];
};

namespace detail {

/// The convex hull of a mesh's used vertices.
struct MeshHull {
  Hull hull;
  std::vector<std::uint32_t>
      extreme;  ///< the mesh's vertices that are the hull's: sufficient for bounds (to 1e-12 of the size)
};

/// A capsule inside a solid mesh: a ball about each point of the segment from centre - half to centre + half.
struct InnerCapsule {
  Vec3 centre, half;  ///< metres, in the mesh's frame
  double radius;      ///< metres; 0: none is known
};

/// A checked mesh with the data that queries need, built once except for data that only some queries need. Immutable
/// when shared.
struct MeshModel : MeshFrame {
  MeshFrame& frame() { return *this; }

  std::vector<Vec3> vertices;
  /// Triangles, consistently oriented if possible, those of a closed surface outward.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  bool solid = false;
  /// The vertices may change (DeformableMesh): then the hull, the costliest data, is built only if an answer needs it,
  /// never to save time.
  bool bends = false;
  /// Every edge has as many triangles in one direction as in the other: a solid's surface, or one that could be.
  bool closed = false;

  /// The triangle across edge k, from corner k to corner k + 1; no_index at a border. Corners with equal coordinates
  /// count as one vertex here; on a surface's borders also those whose coordinates differ only by rounding.
  using Neighbours = std::vector<std::array<std::uint32_t, 3>>;

  // The following are computed at their first use, from any thread. A limit may end the computation: WorkStopped is
  // thrown, nothing is kept, and the next call computes it.
  const Neighbours& neighbours(const WorkLimit* limit = nullptr) const;  ///< the same for all copies
  const Hull& hull(const WorkLimit* limit = nullptr) const { return with_hull(limit).hull; }
  bool is_hull_made() const { return hull_.made() != nullptr; }
  const std::vector<std::uint32_t>& extreme(const WorkLimit* limit = nullptr) const { return with_hull(limit).extreme; }
  const NormalCones& normal_cones(const WorkLimit* limit = nullptr) const;
  /// Cosines of the angle between each triangle's normal and the directions in which it may push (CornerNormals).
  const KeptCosines& least_cosines() const {
    return least_cosines_.get(nullptr, [&](const WorkLimit*) { return KeptCosines(triangles.size()); });
  }
  /// Computed by make_inner_capsule alone.
  const Lazily<InnerCapsule>& inner_capsule() const { return inner_capsule_; }
  /// True if the mesh is closed and equals the surface of its hull, to 1e-13 of the size.
  bool own_hull(const WorkLimit* limit = nullptr) const;
  bool convex(const WorkLimit* limit = nullptr) const {
    return solid && own_hull(limit);
  }  ///< it is solved as its hull

  /// The extreme vertices of a component of triangles connected by vertices of equal coordinates: farthest along -x, x,
  /// -y, y, -z, z.
  using Component = std::array<std::uint32_t, 6>;
  const std::vector<Component>& components(const WorkLimit* limit = nullptr) const;  ///< computed like the hull
  /// For each vertex the first of those that coincide with it; empty if none do.
  std::vector<std::uint32_t> representatives;
  std::uint32_t representative(std::uint32_t v) const { return representatives.empty() ? v : representatives[v]; }

  UninitialisedList<MeshNode> nodes;  ///< the root is nodes[0]
  UninitialisedList<TriangleBlock> blocks;
  UninitialisedList<ChildBoxes> boxes;
  UninitialisedList<ChildSlabs> slabs;
  std::vector<std::uint32_t> order;  ///< triangles in the leaves' order
  int depth = 0;                     ///< levels of nodes: bounds the stack of every traversal

  const ChildBoxes& boxes_of(const MeshNode& inner) const { return boxes[inner.block]; }
  std::uint32_t triangle_of(const MeshNode& bottom, std::uint32_t lane) const { return order[bottom.first() + lane]; }
  /// The margin, in units, by which boxes about corners in floats must be enlarged to contain the given corners.
  float corner_pad() const;
  /// The boxes of the triangles of a bottom node. Unused lanes equal the last one.
  void boxes_of_triangles(const MeshNode& bottom, LaneBoxes& out) const;
  /// The boxes of a node's children or triangles; `room` stores the latter.
  const LaneBoxes& lane_boxes(const MeshNode& node, LaneBoxes& room) const {
    if (!node.bottom()) return boxes_of(node);
    boxes_of_triangles(node, room);
    return room;
  }

  ShapeMemory memory() const;

  Corners corners(std::uint32_t triangle) const {
    const auto& t = triangles[triangle];
    return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
  }

  /// To be called after vertices have changed.
  void forget_extremes() {
    hull_.clear(), own_hull_.clear(), components_.clear(), cones_.clear(), least_cosines_.clear(),
        inner_capsule_.clear();
  }

 private:
  const MeshHull& with_hull(const WorkLimit* limit) const;

  std::shared_ptr<const Lazily<Neighbours>> neighbours_ = std::make_shared<const Lazily<Neighbours>>();
  Lazily<MeshHull> hull_;
  Lazily<bool> own_hull_;
  Lazily<std::vector<std::uint32_t>> component_numbers_;  // of each used vertex; unchanged when vertices move
  Lazily<NormalCones> cones_;
  Lazily<KeptCosines> least_cosines_;
  Lazily<InnerCapsule> inner_capsule_;
  Lazily<std::vector<Component>> components_;
};

}  // namespace detail

using detail::InnerCapsule;
using detail::MeshHull;
using detail::MeshModel;

}  // namespace tandem
