// Queries of registered objects with the cells of FCL's octrees.
#pragma once
#include <fcl/config.h>
#if FCL_HAVE_OCTOMAP
#include <fcl/broadphase/broadphase_collision_manager.h>
#include <fcl/geometry/octree/octree.h>
#include <fcl/geometry/shape/utility.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "tandem/fcl/object_boxes.h"

namespace tandem::fcl {

/// Registered objects and the cells of an octree, passed to callbacks as by ::fcl::DynamicAABBTreeCollisionManager
/// where octrees are not geometries: for collisions the cells that are not free, and those that the octree does not
/// know, with their occupancy as cost, whose boxes overlap an object's; for distances the occupied cells. A cell is a
/// box that lives during the callback.
template <class S>
class OctreeCells {
 public:
  using Object = ::fcl::CollisionObject<S>;

  /// Both must outlive it.
  OctreeCells(const ObjectBoxes& boxes, const Object& octree)
      : boxes_(boxes),
        tree_(static_cast<const ::fcl::OcTree<S>&>(*octree.collisionGeometry())),
        pose_(octree.getTransform()),
        is_turned_(!pose_.linear().isIdentity()) {}

  void collide(void* data, ::fcl::CollisionCallBack<S> callback) const {
    Met met(*this, data, callback);
    collide_from(tree_.getRoot(), tree_.getRootBV(), met);
  }
  void distance(void* data, ::fcl::DistanceCallBack<S> callback) const {
    Near near(*this, data, callback);
    if (tree_.getRoot() != nullptr) distance_from(tree_.getRoot(), tree_.getRootBV(), near);
  }

 private:
  using Node = typename ::fcl::OcTree<S>::OcTreeNode;  // null: the octree does not know the cell
  using Box = ::fcl::AABB<S>;

  /// A cell as an object, made on first use.
  class CellObject {
   public:
    explicit CellObject(const OctreeCells& cells) : cells_(cells) {}
    void set(const Node* node, const Box& cell) {
      node_ = node;
      cell_ = cell;
      object_.reset();
    }
    const Box& box() const { return cell_; }
    Object* get() {
      if (object_ != nullptr) return object_.get();
      const auto box = std::make_shared<::fcl::Box<S>>();
      ::fcl::Transform3<S> pose;
      ::fcl::constructBox(cell_, cells_.pose_, *box, pose);
      if (node_ != nullptr) {
        box->cost_density = static_cast<S>(node_->getOccupancy());
        box->threshold_occupied = cells_.tree_.getOccupancyThres();
      } else {
        box->cost_density = cells_.tree_.getDefaultOccupancy();
      }
      object_ = std::make_unique<Object>(box, pose);
      return object_.get();
    }

   private:
    const OctreeCells& cells_;
    const Node* node_ = nullptr;
    Box cell_;
    std::unique_ptr<Object> object_;
  };

  struct Met final : BoxedObjectVisitor {
    Met(const OctreeCells& cells, void* data, ::fcl::CollisionCallBack<S> callback)
        : cells(cells), cell(cells), data(data), callback(callback) {}
    bool visit(void* object, const ExactBox& box, double&) override {
      auto* const met = static_cast<Object*>(object);
      is_going = met->isFree() || !cells.overlap(box, cell.box()) || !callback(met, cell.get(), data);
      return is_going;
    }
    const OctreeCells& cells;
    CellObject cell;
    void* data;
    ::fcl::CollisionCallBack<S> callback;
    bool is_going = true;
  };
  struct Near final : BoxedObjectVisitor {
    Near(const OctreeCells& cells, void* data, ::fcl::DistanceCallBack<S> callback)
        : cell(cells), data(data), callback(callback) {}
    bool visit(void* object, const ExactBox&, double& limit) override {
      is_going = !callback(static_cast<Object*>(object), cell.get(), data, least);
      limit = least;
      return is_going;
    }
    CellObject cell;
    void* data;
    ::fcl::DistanceCallBack<S> callback;
    S least = std::numeric_limits<S>::max();
    bool is_going = true;
  };
  struct Any final : BoxedObjectVisitor {
    bool visit(void*, const ExactBox&, double&) override { return !(found = true); }
    bool found = false;
  };
  struct Nearest final : BoxedObjectVisitor {
    bool visit(void*, const ExactBox& box, double& limit) override {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double off = std::max({asked.lo[k] - box.hi[k], box.lo[k] - asked.hi[k], 0.0});
        sum += off * off;
      }
      limit = least = std::min(least, std::sqrt(sum));
      return true;
    }
    ExactBox asked{};
    double least = std::numeric_limits<double>::infinity();
  };

  /// False: the callback has ended the query.
  bool collide_from(const Node* node, const Box& cell, Met& met) const {
    if (node != nullptr && tree_.isNodeFree(node)) return true;
    if (node == nullptr || !tree_.nodeHasChildren(node)) {
      met.cell.set(node, cell);
      boxes_.visit_overlapping(box_of(cell), met);
      return met.is_going;
    }
    Any any;
    boxes_.visit_overlapping(box_of(cell), any);
    for (unsigned i = 0; i < 8 && any.found; ++i)
      if (!collide_from(child(node, i), child_cell(cell, i), met)) return false;
    return true;
  }

  /// Nearer cells first.
  bool distance_from(const Node* node, const Box& cell, Near& near) const {
    if (!tree_.isNodeOccupied(node)) return true;
    if (!tree_.nodeHasChildren(node)) {
      near.cell.set(node, cell);
      boxes_.visit_near(box_of(cell), near.least, near);
      return near.is_going;
    }
    constexpr double none = std::numeric_limits<double>::infinity();
    std::array<double, 8> apart{none, none, none, none, none, none, none, none};
    for (unsigned i = 0; i < 8; ++i) {
      if (!tree_.nodeChildExists(node, i) || !tree_.isNodeOccupied(tree_.getNodeChild(node, i))) continue;
      Nearest nearest;
      nearest.asked = box_of(child_cell(cell, i));
      boxes_.visit_near(nearest.asked, near.least, nearest);
      apart[i] = nearest.least;
    }
    for (;;) {
      const auto i = static_cast<unsigned>(std::min_element(apart.begin(), apart.end()) - apart.begin());
      if (!(apart[i] < near.least)) return true;
      if (!distance_from(tree_.getNodeChild(node, i), child_cell(cell, i), near)) return false;
      apart[i] = none;
    }
  }

  const Node* child(const Node* node, unsigned i) const {
    return tree_.nodeChildExists(node, i) ? tree_.getNodeChild(node, i) : nullptr;
  }
  static Box child_cell(const Box& cell, unsigned i) {
    Box child;
    ::fcl::computeChildBV(cell, i, child);
    return child;
  }

  /// FCL's test of an object's box and a cell.
  bool overlap(const ExactBox& box, const Box& cell) const {
    if (!is_turned_) return true;  // box_of is the cell itself
    const Box object(::fcl::Vector3<S>(S(box.lo[0]), S(box.lo[1]), S(box.lo[2])),
                     ::fcl::Vector3<S>(S(box.hi[0]), S(box.hi[1]), S(box.hi[2])));
    ::fcl::OBB<S> a, b;
    ::fcl::convertBV(object, ::fcl::Transform3<S>::Identity(), a);
    ::fcl::convertBV(cell, pose_, b);
    return a.overlap(b);
  }

  /// The box around a cell in its pose, enlarged by more than FCL's test of rotated boxes tolerates.
  ExactBox box_of(const Box& cell) const {
    if (!is_turned_) {
      const Box placed = ::fcl::translate(cell, pose_.translation());
      const auto &lo = placed.min_, &hi = placed.max_;
      return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
    }
    ExactBox box;
    constexpr double slack = 64 * std::numeric_limits<float>::epsilon();  // of sizes
    const ::fcl::Vector3<S> centre = pose_ * cell.center(), half = (cell.max_ - cell.min_) / 2;
    for (int k = 0; k < 3; ++k) {
      const double reach = pose_.linear().row(k).cwiseAbs().dot(half) + slack * (half.sum() + std::abs(centre[k]));
      box.lo[static_cast<std::size_t>(k)] = centre[k] - reach;
      box.hi[static_cast<std::size_t>(k)] = centre[k] + reach;
    }
    return box;
  }

  const ObjectBoxes& boxes_;
  const ::fcl::OcTree<S>& tree_;
  const ::fcl::Transform3<S>& pose_;
  const bool is_turned_;
};

}  // namespace tandem::fcl
#endif  // FCL_HAVE_OCTOMAP
