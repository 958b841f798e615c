#pragma once
#include <fcl/broadphase/broadphase_collision_manager.h>

#include <limits>
#include <vector>

#include "tandem/fcl/object_boxes.h"

namespace tandem::fcl {

/// FCL's broad-phase manager (fcl/broadphase/broadphase_collision_manager.h) over tandem's hierarchy of boxes: in place
/// of FCL's DynamicAABBTreeCollisionManager and its kin. Callbacks are called as by that one: on the calling thread,
/// one after the other, until one returns true; for pairs whose AABBs overlap as they were at the last update or
/// registration; distances with the least distance so far, nearer AABBs about first. It differs where that one's
/// behaviour is none to rely on:
/// - A manager with itself, collide(&manager, ...), is collide(...), as with FCL's NaiveCollisionManager.
/// - The other manager may be of any class; its objects' AABBs are then those of now.
/// - An object registered twice is there twice, as there, and update() sees to both; each unregisterObject takes one
///   away.
/// - An object that is not registered can be unregistered; nothing happens.
/// - An octree is one object, never one for each of its cells (octree_as_geometry_distance).
/// Registration and updates take note of boxes that changed, the next query works them in: updates one by one cost no
/// more than those of a list, and setup() has nothing to do. Const members may run from any number of threads at once.
template <class S>
class CollisionManager : public ::fcl::BroadPhaseCollisionManager<S> {
 public:
  using Object = ::fcl::CollisionObject<S>;
  using Manager = ::fcl::BroadPhaseCollisionManager<S>;

  void registerObjects(const std::vector<Object*>& objects) override {
    boxes_.reserve(objects.size());
    for (Object* object : objects) registerObject(object);
  }
  void registerObject(Object* object) override { boxes_.add(object, box_of(*object)); }
  void unregisterObject(Object* object) override { boxes_.remove(object); }
  void setup() override {}
  void update() override {
    const auto objects = boxes_.objects();
    for (std::size_t place = 0; place < objects.size(); ++place)
      if (objects[place] != nullptr) boxes_.set(place, box_of(*object_at(objects[place])));
  }
  void update(Object* object) override { boxes_.set(object, box_of(*object)); }
  void update(const std::vector<Object*>& objects) override {
    for (const Object* object : objects) boxes_.set(object, box_of(*object));
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
    Met met(data, callback);
    boxes_.visit_overlapping(object, box_of(*object), met);
  }
  void collide(void* data, ::fcl::CollisionCallBack<S> callback) const override {
    Met met(data, callback);
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
    Near near(data, callback);
    boxes_.visit_near(object, box_of(*object), near.least, near);
  }
  void distance(void* data, ::fcl::DistanceCallBack<S> callback) const override {
    Near near(data, callback);
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
    Met(void* data, ::fcl::CollisionCallBack<S> callback) : data(data), callback(callback) {}
    bool visit(void* a, void* b) override { return !callback(object_at(a), object_at(b), data); }
    void* data;
    ::fcl::CollisionCallBack<S> callback;
  };
  struct Near final : NearPairVisitor {
    Near(void* data, ::fcl::DistanceCallBack<S> callback) : data(data), callback(callback) {}
    bool visit(void* a, void* b, double& limit) override {
      const bool enough = callback(object_at(a), object_at(b), data, least);
      limit = least;
      return !enough;
    }
    S least = std::numeric_limits<S>::max();
    void* data;
    ::fcl::DistanceCallBack<S> callback;
  };

  ObjectBoxes boxes_;
};

using CollisionManagerf = CollisionManager<float>;
using CollisionManagerd = CollisionManager<double>;

}  // namespace tandem::fcl
