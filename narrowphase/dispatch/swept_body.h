// A shape in the searches for the first touch of two that move: a convex shape, or a mesh or voxels by their hierarchy
// of boxes.
#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "meshes/traversal/hierarchy.h"
#include "shapes/convex_view.h"
#include "shapes/mesh_model.h"
#include "shapes/posed_mesh.h"
#include "shapes/shape_insides.h"
#include "shapes/support.h"
#include "shapes/without_hull.h"
#include "shapes/work_meter.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// Options without a cut-off of distances, because it does not apply to impacts.
inline NarrowPhaseOptions without_cutoff(NarrowPhaseOptions options) {
  options.cutoff = std::numeric_limits<double>::infinity();
  return options;
}

/// The units of work of a distance between two moving shapes: more for large hulls.
inline int work_of_advance(const ConvexView& p, const ConvexView& q) {
  return 8 + static_cast<int>(std::min<std::size_t>(56, (p.vertices.size() + q.vertices.size()) / 64));
}

/// The time of impact of shapes that do not touch.
inline constexpr double never = std::numeric_limits<double>::infinity();

struct SweptBody {
  const MeshModel* mesh = nullptr;
  const VoxelModel* voxels = nullptr;
  ConvexView view{};  // of a convex shape
  Vec3 mid, half;     // the shape's box in its frame

  SweptBody(const Shape& shape, const WorkLimit* limit) {
    const Bounds box = quick_bounds(shape, Pose{}, limit);
    mid = (box.lo + box.hi) / 2;
    half = (box.hi - box.lo) / 2;
    if (shape.is_convex())
      view = tandem::view(shape);
    else if (shape.kind() == ShapeKind::voxels)
      voxels = &voxels_of(shape);
    else if (mesh_of(shape).convex(limit))
      view = view_hull(shape, limit);
    else
      mesh = &mesh_of(shape);
  }
  bool has_hierarchy() const { return mesh != nullptr || voxels != nullptr; }
  std::uint32_t root() const { return voxels != nullptr ? voxels->root() : whole; }
  bool is_leaf(std::uint32_t ref) const {
    if (voxels != nullptr) return voxels->is_cell(ref);
    return !mesh || tandem::is_leaf(*mesh, ref);
  }
  std::pair<Vec3, Vec3> box(std::uint32_t ref) const {
    if (voxels != nullptr) return voxels->box(ref);
    if (!mesh) return {mid, half};
    const BoxOf b(*mesh, ref);
    return {b.mid, b.half};
  }
  /// Speeds are those of the core: a ball about a point does not rotate, so the gap shrinks as fast as the cores
  /// approach.
  std::pair<Vec3, Vec3> core_box(std::uint32_t ref) const {
    return has_hierarchy() ? box(ref) : std::pair(mid, Vec3((half.array() - core_radius(view)).cwiseMax(0)));
  }
  template <class Visit>
  void each_child_of(std::uint32_t ref, Visit&& visit) const {
    if (voxels == nullptr) return each_child(*mesh, ref, visit);
    const VoxelModel::Node& node = voxels->node(ref);
    for (std::uint32_t k = 0; k < node.count; ++k) visit(node.first + k);
  }
  /// Calls visit(view, the origin of its frame in the body's frame, triangle or cell; 0 for a convex shape).
  template <class Visit>
  void each_convex(std::uint32_t leaf, Visit&& visit) const {
    const Vec3 here = Vec3::Zero();
    if (voxels != nullptr) return visit(tandem::view(voxels->box_of(leaf)), voxels->centre(leaf), leaf);
    if (!mesh) return visit(view, here, std::uint32_t{0});
    const std::uint32_t t = leaf_triangle(*mesh, leaf);
    const auto corners = mesh->corners(t);
    visit(TriangleView(corners), here, t);
  }
};

}  // namespace tandem
