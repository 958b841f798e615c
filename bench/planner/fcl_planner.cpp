// FCL as a contestant of the planner bench: its AABB tree manager.
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>

#include "fcl_shape.h"
#include "planner/planner.h"

namespace tandem::bench {
namespace {

/// The obstacles in a DynamicAABBTreeCollisionManager; links are asked of it one by one, pairs of links by
/// fcl::collide. GJK is FCL's own (GST_INDEP), which is its fastest here.
class FclPlanner final : public OneByOnePlanner {
 public:
  explicit FclPlanner(const PlannerWorld& world) : OneByOnePlanner(world) {
    for (std::uint32_t i = 0; i < world.obstacles.indices(); ++i) {
      objects_.push_back(std::make_unique<fcl::CollisionObjectd>(
          fcl_shape(world.obstacles.shape_of(i)), fcl_pose(world.obstacles.poses()[i])));
      manager_.registerObject(objects_.back().get());
    }
    manager_.setup();
    for (const Shape& link : world.links) links_.push_back(std::make_unique<fcl::CollisionObjectd>(fcl_shape(link)));
    request_.gjk_solver_type = fcl::GST_INDEP;
    distance_request_.gjk_solver_type = fcl::GST_INDEP;
  }

  std::string name() const override { return "FCL"; }

  void clearance(std::span<const Pose> poses, std::span<double> distances) override {
    for (std::size_t i = 0; i < distances.size(); ++i) {
      place(&poses[i * links_.size()]);
      least_ = std::numeric_limits<double>::infinity();
      for (const auto& link : links_) manager_.distance(link.get(), this, nearer);
      for (const auto& [a, b] : self()) take_distance(links_[a].get(), links_[b].get());
      distances[i] = std::max(least_, 0.0);
    }
  }

 private:
  void place(const Pose* poses) {
    for (std::size_t i = 0; i < links_.size(); ++i) {
      links_[i]->setTransform(fcl_pose(poses[i]));
      links_[i]->computeAABB();
    }
  }
  bool hit(const Pose* poses) override {
    place(poses);
    hit_ = false;
    for (const auto& [a, b] : self())
      if (links_[a]->getAABB().overlap(links_[b]->getAABB()) && meet(links_[a].get(), links_[b].get(), this))
        return true;
    for (const auto& link : links_) {
      manager_.collide(link.get(), this, meet);
      if (hit_) return true;
    }
    return false;
  }
  static bool meet(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* self) {
    auto& planner = *static_cast<FclPlanner*>(self);
    fcl::CollisionResultd result;
    fcl::collide(a, b, planner.request_, result);
    return planner.hit_ = result.isCollision();
  }
  void take_distance(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b) {
    fcl::DistanceResultd result;
    fcl::distance(a, b, distance_request_, result);
    least_ = std::min(least_, result.min_distance);
  }
  static bool nearer(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* self, double& least) {
    auto& planner = *static_cast<FclPlanner*>(self);
    planner.take_distance(a, b);
    least = planner.least_;
    return least <= 0;
  }

  fcl::CollisionRequestd request_;
  fcl::DistanceRequestd distance_request_;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects_, links_;
  fcl::DynamicAABBTreeCollisionManagerd manager_;
  bool hit_ = false;
  double least_ = 0;
};

}  // namespace

std::unique_ptr<Planner> fcl_planner(const PlannerWorld& world) { return std::make_unique<FclPlanner>(world); }

}  // namespace tandem::bench
