// Bullet as a contestant of the planner bench: btCollisionWorld.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <btBulletCollisionCommon.h>

#include "bullet_shape.h"
#include "peers/bullet_body.h"
#include "planner/planner.h"

namespace tandem::bench {
namespace {

/// The obstacles in a btCollisionWorld; links are asked of it by contactTest, pairs of links by contactPairTest. It
/// keeps contacts that are a little apart: those do not count.
class BulletPlanner final : public OneByOnePlanner {
 public:
  explicit BulletPlanner(const PlannerWorld& world) : OneByOnePlanner(world) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    for (std::uint32_t i = 0; i < world.obstacles.indices(); ++i) {
      add(world.obstacles.shape_of(i), true);
      objects_.back()->setWorldTransform(bullet_pose(world.obstacles.poses()[i], Vec3::Zero()));
      world_.addCollisionObject(objects_.back().get());
    }
    for (const Shape& link : world.links) {
      add(link, false);
      links_.push_back(objects_.back().get());
    }
  }
  BulletPlanner(const BulletPlanner&) = delete;
  BulletPlanner& operator=(const BulletPlanner&) = delete;
  ~BulletPlanner() override {
    for (const auto& object : objects_) world_.removeCollisionObject(object.get());
  }

  std::string name() const override { return bullet_is_double ? "Bullet, double" : "Bullet, float"; }

  void clearance(std::span<const Pose>, std::span<double>) override {}

 private:
  struct Touch final : btCollisionWorld::ContactResultCallback {
    bool found = false;
    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override {
      found = found || point.getDistance() <= 0;
      return 0;
    }
  };

  void add(const Shape& shape, bool is_static) {
    shapes_.push_back(bullet_shape(shape, is_static));
    objects_.push_back(std::make_unique<btCollisionObject>());
    objects_.back()->setCollisionShape(shapes_.back()->shape.get());
    if (is_static) objects_.back()->setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
  }
  bool hit(const Pose* poses) override {
    for (std::size_t i = 0; i < links_.size(); ++i) links_[i]->setWorldTransform(bullet_pose(poses[i], Vec3::Zero()));
    Touch touch;
    for (const auto& [a, b] : self()) {
      world_.contactPairTest(links_[a], links_[b], touch);
      if (touch.found) return true;
    }
    for (btCollisionObject* link : links_) {
      world_.contactTest(link, touch);
      if (touch.found) return true;
    }
    return false;
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  std::vector<std::unique_ptr<BulletShape>> shapes_;
  std::vector<std::unique_ptr<btCollisionObject>> objects_;
  std::vector<btCollisionObject*> links_;
};

}  // namespace

std::unique_ptr<Planner> bullet_planner(const PlannerWorld& world) { return std::make_unique<BulletPlanner>(world); }

}  // namespace tandem::bench
