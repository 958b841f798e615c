// A broad-phase manager with FCL's interface.
#pragma once
#include <fcl/broadphase/broadphase_collision_manager.h>

#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "tandem/fcl/object_boxes.h"
#include "tandem/fcl/octree_cells.h"

namespace tandem::fcl {

/// A broad-phase manager with FCL's interface (fcl/broadphase/broadphase_collision_manager.h) over tandem's hierarchy
/// of boxes: it replaces FCL's DynamicAABBTreeCollisionManager and other managers. Callbacks follow that manager's
/// rules: on the calling thread, one after the other, until one returns true; for pairs whose AABBs overlapped at the
/// last update or registration; distance callbacks with the least distance so far, approximately nearer AABBs first.
/// Differences, where that manager's behaviour is not reliable:
/// - A manager with itself, collide(&manager, ...), is collide(...), as with FCL's NaiveCollisionManager.
/// - The other manager may be of any class; its objects' current AABBs are used.
/// - An object registered twice is stored twice, as there, and update() updates both; unregisterObject removes one.
/// - Unregistering an object that is not registered does nothing.
/// - The order of a pair's objects in the callback alternates with each update, as for two objects there; with more
///   objects that manager's order follows from its tree.
/// Registration and updates record changed boxes, which the next query applies: single updates cost no more than those
/// of a list, and setup() does nothing. Const members may run from any number of threads at once.
template <class S>
class CollisionManager : public ::fcl::BroadPhaseCollisionManager<S> {
 public:
  using Object = ::fcl::CollisionObject<S>;
  using Manager = ::fcl::BroadPhaseCollisionManager<S>;

  /// True: an octree passed to a query is one object; false: as in FCL, one object for each of its cells, which lives
  /// during the callback.
  bool octree_as_geometry_collide = true;
  bool octree_as_geometry_distance = false;
  /// Options of FCL's tree, with its defaults: nothing depends on them.
  int max_tree_nonbalanced_level = 10;
  int tree_incremental_balance_pass = 10;
  int tree_topdown_balance_threshold = 2;
  int tree_topdown_level = 0;
  int tree_init_level = 0;

  void registerObjects(const std::vector<Object*>& objects) override {
    boxes_.reserve(objects.size());
    for (Object* object : objects) registerObject(object);
  }
  void registerObject(Object* object) override { boxes_.add(object, box_of(*object)); }
  void unregisterObject(Object* object) override { boxes_.remove(object); }
  void setup() override {}
  void update() override {
    const auto [objects, boxes, changed] = boxes_.places();
    bool some = false;
    for (std::size_t place = 0; place < objects.size(); ++place) {
      if (objects[place] == nullptr) continue;
      const ExactBox box = box_of(*object_at(objects[place]));
      if (std::memcmp(&box, &boxes[place], sizeof box) == 0) continue;  // NaN is the same as itself
      boxes[place] = box;
      changed[place] = 1;
      some = true;
    }
    if (some) boxes_.take_changes();
    exchanged_ = !exchanged_;
  }
  void update(Object* object) override {
    boxes_.set(object, box_of(*object));
    exchanged_ = !exchanged_;
  }
  void update(const std::vector<Object*>& objects) override {
    for (const Object* object : objects) boxes_.set(object, box_of(*object));
    exchanged_ = !exchanged_;
  }
  void clear() override { boxes_.clear(); }
  void getObjects(std::vector<Object*>& objects) const override {
    objects.clear();
    objects.reserve(boxes_.size());
    for (void* object : boxes_.objects())
      if (object != nullptr) objects.push_back(object_at(object));
  }
  bool empty() const override { return boxes_.size() == 0; }
  std::size_t size() const override { return boxes_.size(); }

  void collide(Object* object, void* data, ::fcl::CollisionCallBack<S> callback) const override {
#if FCL_HAVE_OCTOMAP
    if (!octree_as_geometry_collide && object->getNodeType() == ::fcl::GEOM_OCTREE)
      return OctreeCells<S>(boxes_, *object).collide(data, callback);
#endif
    Met met(data, callback);
    boxes_.visit_overlapping(object, box_of(*object), met);
  }
  void collide(void* data, ::fcl::CollisionCallBack<S> callback) const override {
    Met met(data, callback, exchanged_);
    boxes_.visit_overlapping(met);
  }
  void collide(Manager* other, void* data, ::fcl::CollisionCallBack<S> callback) const override {
    if (other == this) return collide(data, callback);
    Met met(data, callback);
    if (const auto* same = dynamic_cast<const CollisionManager*>(other))
      return boxes_.visit_overlapping(same->boxes_, met);
    boxes_.visit_overlapping(boxes_of(*other), met);
  }

  void distance(Object* object, void* data, ::fcl::DistanceCallBack<S> callback) const override {
#if FCL_HAVE_OCTOMAP
    if (!octree_as_geometry_distance && object->getNodeType() == ::fcl::GEOM_OCTREE)
      return OctreeCells<S>(boxes_, *object).distance(data, callback);
#endif
    Near near(data, callback);
    boxes_.visit_near(object, box_of(*object), near.least, near);
  }
  void distance(void* data, ::fcl::DistanceCallBack<S> callback) const override {
    Near near(data, callback, exchanged_);
    boxes_.visit_near(near.least, near);
  }
  void distance(Manager* other, void* data, ::fcl::DistanceCallBack<S> callback) const override {
    if (other == this) return distance(data, callback);
    Near near(data, callback);
    if (const auto* same = dynamic_cast<const CollisionManager*>(other))
      return boxes_.visit_near(same->boxes_, near.least, near);
    boxes_.visit_near(boxes_of(*other), near.least, near);
  }

 private:
  static Object* object_at(void* object) { return static_cast<Object*>(object); }
  static ExactBox box_of(const Object& object) {
    const auto& box = object.getAABB();
    return {{box.min_[0], box.min_[1], box.min_[2]}, {box.max_[0], box.max_[1], box.max_[2]}};
  }
  static ObjectBoxes boxes_of(const Manager& other) {
    std::vector<Object*> objects;
    other.getObjects(objects);
    ObjectBoxes boxes;
    boxes.reserve(objects.size());
    for (Object* object : objects)
      if (object != nullptr) boxes.add(object, box_of(*object));
    return boxes;
  }

  struct Met final : ObjectPairVisitor {
    Met(void* data, ::fcl::CollisionCallBack<S> callback, bool exchanged = false)
        : data(data), callback(callback), exchanged(exchanged) {}
    bool visit(void* a, void* b) override {
      if (exchanged) std::swap(a, b);
      return !callback(object_at(a), object_at(b), data);
    }
    void* data;
    ::fcl::CollisionCallBack<S> callback;
    bool exchanged;
  };
  struct Near final : NearPairVisitor {
    Near(void* data, ::fcl::DistanceCallBack<S> callback, bool exchanged = false)
        : data(data), callback(callback), exchanged(exchanged) {}
    bool visit(void* a, void* b, double& limit) override {
      if (exchanged) std::swap(a, b);
      const bool enough = callback(object_at(a), object_at(b), data, least);
      limit = least;
      return !enough;
    }
    S least = std::numeric_limits<S>::max();
    void* data;
    ::fcl::DistanceCallBack<S> callback;
    bool exchanged;
  };

  ObjectBoxes boxes_;
  bool exchanged_ = false;
};

using CollisionManagerf = CollisionManager<float>;
using CollisionManagerd = CollisionManager<double>;

}  // namespace tandem::fcl
