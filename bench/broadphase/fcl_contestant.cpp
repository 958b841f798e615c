// FCL as a contestant of the broad-phase bench.
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision_object.h>

#include <utility>

#include "contestant.h"

namespace tandem::bench {
namespace {

/// A collision object that is only a box.
class BoxObject final : public fcl::CollisionObject<float> {
 public:
  BoxObject(const std::shared_ptr<fcl::CollisionGeometry<float>>& geometry, std::uint32_t index)
      : CollisionObject(geometry), index(index) {}
  void set(const Aabb& box) {
    aabb.min_ = {box.lo[0], box.lo[1], box.lo[2]};
    aabb.max_ = {box.hi[0], box.hi[1], box.hi[2]};
  }
  const std::uint32_t index;
};

bool put(fcl::CollisionObject<float>* a, fcl::CollisionObject<float>* b, void* list) {
  static_cast<PairList*>(list)->put(static_cast<BoxObject*>(a)->index, static_cast<BoxObject*>(b)->index);
  return false;  // continue
}

/// DynamicAABBTreeCollisionManager; bodies are registered all at once at first, then as they appear and leave.
class FclContestant final : public BoxContestant {
 public:
  std::string name() const override { return "FCL tree"; }

  void changes(std::span<const std::uint8_t> changed) override { changed_ = changed; }

  void step(const BoxArray& boxes, PairList& out) override {
    while (objects_.size() < boxes.size())
      objects_.push_back(std::make_unique<BoxObject>(geometry_, static_cast<std::uint32_t>(objects_.size())));
    registered_.resize(boxes.size());
    std::vector<fcl::CollisionObject<float>*> fresh;
    const std::span<const std::uint8_t> changed = std::exchange(changed_, {});
    std::vector<fcl::CollisionObject<float>*> moved;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (!changed.empty() && changed[i] == 0) continue;
      const Aabb box = boxes[i];
      const bool there = box.lo[0] <= box.hi[0];
      if (there) objects_[i]->set(box);
      if (there && !changed.empty() && registered_[i] != 0) moved.push_back(objects_[i].get());
      if (there && registered_[i] == 0) fresh.push_back(objects_[i].get());
      if (!there && registered_[i] != 0) manager_.unregisterObject(objects_[i].get());
      registered_[i] = there ? 1 : 0;
    }
    if (fresh.size() == manager_.size() + fresh.size())
      manager_.registerObjects(fresh);
    else
      for (auto* object : fresh) manager_.registerObject(object);
    if (changed.empty())
      manager_.update();
    else if (!moved.empty())
      manager_.update(moved);
    manager_.collide(&out, put);
  }

 private:
  std::shared_ptr<fcl::CollisionGeometry<float>> geometry_ = std::make_shared<fcl::Sphere<float>>(1.0f);
  std::vector<std::unique_ptr<BoxObject>> objects_;
  std::vector<std::uint8_t> registered_;
  std::span<const std::uint8_t> changed_;
  fcl::DynamicAABBTreeCollisionManager<float> manager_;
};

}  // namespace

std::unique_ptr<BoxContestant> fcl_contestant() { return std::make_unique<FclContestant>(); }

}  // namespace tandem::bench
