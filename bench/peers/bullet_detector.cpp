// Bullet's collision world as a contestant of the bench of whole steps.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <map>

#include "bullet_body.h"
#include "bullet_shape.h"
#include "scene_detector.h"

namespace tandem::bench {
namespace {

class BulletDetector final : public SceneDetector {
 public:
  explicit BulletDetector(const Scene& scene) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    world_.setForceUpdateAllAabbs(false);
    std::map<std::pair<std::uint32_t, bool>, const BulletShape*> made;
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      const bool is_static = scene.is_static()[i] != 0;
      const BulletShape*& shape = made[{scene.shape_indices()[i], is_static}];
      if (shape == nullptr) shape = shapes_.emplace_back(bullet_shape(scene.shape_of(i), is_static)).get();
      auto object = std::make_unique<btCollisionObject>();
      object->setCollisionShape(shape->shape.get());
      object->setWorldTransform(bullet_pose(scene.poses()[i], Vec3::Zero()));
      object->setUserIndex(static_cast<int>(i));
      const int moving = btBroadphaseProxy::DefaultFilter, fixed = btBroadphaseProxy::StaticFilter;
      if (is_static) {
        object->setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
        object->forceActivationState(ISLAND_SLEEPING);
        world_.addCollisionObject(object.get(), fixed, moving);
      } else {
        object->setCollisionFlags(0);
        moving_.push_back(object.get());
        world_.addCollisionObject(object.get(), moving, moving | fixed);
      }
      objects_.push_back(std::move(object));
    }
  }
  BulletDetector(const BulletDetector&) = delete;
  BulletDetector& operator=(const BulletDetector&) = delete;
  ~BulletDetector() override {
    for (const auto& object : objects_) world_.removeCollisionObject(object.get());
  }

  std::string name() const override { return bullet_is_double ? "Bullet, double" : "Bullet, float"; }

  void detect(const Scene& scene) override {
    for (btCollisionObject* object : moving_)
      object->setWorldTransform(
          bullet_pose(scene.poses()[static_cast<std::size_t>(object->getUserIndex())], Vec3::Zero()));
    world_.performDiscreteCollisionDetection();
  }

  std::vector<TouchingPair> found() const override {
    std::map<std::pair<std::uint32_t, std::uint32_t>, TouchingPair> pairs;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold* manifold = dispatcher_.getManifoldByIndexInternal(i);
      const auto a = static_cast<std::uint32_t>(manifold->getBody0()->getUserIndex());
      const auto b = static_cast<std::uint32_t>(manifold->getBody1()->getUserIndex());
      for (int k = 0; k < manifold->getNumContacts(); ++k) {
        const double depth = -manifold->getContactPoint(k).getDistance();
        if (depth < 0) continue;  // Bullet keeps points that are a little apart
        const auto key = std::minmax(a, b);
        TouchingPair& pair = pairs.try_emplace(key, TouchingPair{key.first, key.second, 0, 0}).first->second;
        ++pair.contacts;
        pair.depth = std::max(pair.depth, depth);
      }
    }
    std::vector<TouchingPair> out;
    for (const auto& [key, pair] : pairs) out.push_back(pair);
    return out;
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  std::vector<std::unique_ptr<BulletShape>> shapes_;
  std::vector<std::unique_ptr<btCollisionObject>> objects_;
  std::vector<btCollisionObject*> moving_;
};

}  // namespace

SceneDetectors bullet_detectors(const Scene& scene) {
  SceneDetectors out;
  out.push_back(std::make_unique<BulletDetector>(scene));
  return out;
}

}  // namespace tandem::bench
