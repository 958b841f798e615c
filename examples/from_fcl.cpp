// A program written for FCL that uses tandem: changed lines are shown beside FCL's. Boxes and balls move; each step
// computes all contacts and the least distance. Prints the results; exit code 1 if FCL's own manager finds other pairs.
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/sphere.h>

#include <cstdio>
#include <memory>
#include <vector>

#include "tandem/fcl/collision_manager.h"  // was: fcl/broadphase/broadphase_dynamic_AABB_tree.h
#include "tandem/fcl/pair_queries.h"       // was: fcl/narrowphase/collision.h, distance.h

namespace {

using Object = fcl::CollisionObjectd;

struct Found {
  std::size_t pairs = 0;     // pairs whose AABBs overlap
  std::size_t contacts = 0;  // contacts of these
  double least = 1e300;      // distance
};

bool on_pair(Object* a, Object* b, void* data) {
  auto& found = *static_cast<Found*>(data);
  ++found.pairs;
  const fcl::CollisionRequestd request(4, true);
  fcl::CollisionResultd result;
  found.contacts += tandem::fcl::collide(a, b, request, result);  // was: fcl::collide(a, b, request, result)
  return false;
}

bool on_near(Object* a, Object* b, void* data, double& least) {
  fcl::DistanceResultd result;
  const double distance =
      tandem::fcl::distance(a, b, fcl::DistanceRequestd(), result);  // was: fcl::distance(a, b, ..., result)
  auto& found = *static_cast<Found*>(data);
  if (distance < found.least) found.least = distance;
  least = found.least;
  return least <= 0;
}

}  // namespace

int main() {
  const auto box = std::make_shared<fcl::Boxd>(1, 1, 1);
  const auto ball = std::make_shared<fcl::Sphered>(0.5);
  std::vector<std::unique_ptr<Object>> objects;
  std::vector<Object*> all;
  for (int i = 0; i < 200; ++i) {
    std::shared_ptr<fcl::CollisionGeometryd> shape = ball;
    if (i % 2 == 0) shape = box;
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.translation() = fcl::Vector3d(1.2 * (i % 10), 1.2 * (i / 10 % 10), 1.2 * (i / 100));
    objects.push_back(std::make_unique<Object>(shape, pose));
    all.push_back(objects.back().get());
  }

  tandem::fcl::CollisionManagerd manager;  // was: fcl::DynamicAABBTreeCollisionManagerd manager;
  fcl::DynamicAABBTreeCollisionManagerd theirs;
  manager.registerObjects(all);
  theirs.registerObjects(all);
  bool same = true;
  for (int step = 0; step < 4; ++step) {
    for (std::size_t i = 0; i < all.size(); i += 3) {
      all[i]->setTranslation(all[i]->getTranslation() + fcl::Vector3d(0.1, 0, 0));
      all[i]->computeAABB();
    }
    manager.update();
    theirs.update();
    Found found, other;
    manager.collide(&found, on_pair);
    theirs.collide(&other, on_pair);
    manager.distance(&found, on_near);
    std::printf("step %d: %zu pairs, %zu contacts, least distance %.3f\n", step, found.pairs, found.contacts,
                found.least);
    same = same && found.pairs == other.pairs && found.contacts == other.contacts;
  }
  if (!same) std::puts("WRONG: FCL's manager found other pairs");
  return same ? 0 : 1;
}
