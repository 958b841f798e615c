// A copy of a scene's bodies with a hierarchy of their boxes, for queries.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "queries/interval_bits.h"
#include "queries/link_boxes.h"
#include "scene/scene_changes.h"
#include "tandem/broadphase/box_queries.h"
#include "tandem/engine/scene_queries.h"

namespace tandem {

/// The box of a shape and all that is within `margin` of it, rounded outward; the limit may end the making of a mesh's
/// hull.
Aabb outward_box(const Shape& shape, const Pose& pose, double margin, const WorkLimit* limit);

/// The bodies of a scene as of the last update. Const calls from any number of threads.
class QueryWorld {
 public:
  UpdateReport update(const Scene& scene);
  std::size_t memory() const;

  const Shape& shape(std::uint32_t index) const { return shapes_[shape_[index]]; }
  const Pose& pose(std::uint32_t index) const { return poses_[index]; }
  BodyId id(std::uint32_t index) const { return ids_[index]; }
  Aabb box(std::uint32_t index) const { return boxes_[index]; }
  /// For a body with a box; own_box is in the body's frame.
  PlacedBox placed_box(std::uint32_t index) const { return {own_boxes_[index], poses_[index], boxes_[index]}; }
  const LinkBox& own_box(std::uint32_t index) const { return own_boxes_[index]; }
  bool has(BodyId id) const { return id.index() < ids_.size() && ids_[id.index()] == id; }
  std::uint32_t group(std::uint32_t index) const { return groups_[index]; }
  std::uint32_t mask(std::uint32_t index) const { return masks_[index]; }
  bool is_static(std::uint32_t index) const { return static_[index] != 0; }
  const BoxQueries& tree() const { return tree_; }
  const IntervalBits& bits() const { return bits_; }  ///< of the same boxes; built if there are few of them
  /// Calls visit(index) for the bodies whose boxes overlap this one, in an order that depends on the world only, until
  /// it returns false, and returns that.
  template <class Visit>
  bool visit_overlapping(const Aabb& box, const Visit& visit) const {
    if (bits_.is_built())
      return bits_.visit_near(bits_.ends_of(box),
                              [&](std::uint32_t index) { return !overlap(boxes_[index], box) || visit(index); });
    struct Visitor final : BoxVisitor {
      const Visit& take;
      explicit Visitor(const Visit& visit) : take(visit) {}
      bool visit(std::uint32_t index) override { return take(index); }
    } visitor(visit);
    return tree_.visit_overlapping(box, visitor);
  }
  /// Bodies without a box: half-spaces, ascending.
  std::span<const std::uint32_t> unbounded() const { return unbounded_; }

  bool admits(const QueryFilter& filter, std::uint32_t index) const;

 private:
  bool copy_changed(const Scene& scene);
  void copy_shapes(const Scene& scene);
  void copy_all(const Scene& scene);
  void build();
  void set_box(std::uint32_t index);
  void set_own_box(std::uint32_t index);

  SceneChanges::HistoryName history_;
  std::uint64_t shape_changes_ = 0;
  std::vector<Shape> shapes_;
  std::vector<std::uint32_t> shape_, groups_, masks_, versions_, unbounded_;
  std::vector<Pose> poses_;
  std::vector<LinkBox> own_boxes_;  // in the bodies' frames
  std::vector<BodyId> ids_;         // "no body" at free indices
  std::vector<std::uint8_t> static_;
  std::vector<std::uint8_t> placed_;  // 1: had a box when the tree was built
  std::vector<std::uint32_t> changed_;
  BoxArray boxes_;
  BoxQueries tree_;
  IntervalBits bits_;
};

}  // namespace tandem
