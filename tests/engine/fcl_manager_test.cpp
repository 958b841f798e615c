// tandem::fcl::CollisionManager compared with FCL's own managers: the same pairs, the same least distances.
#include "tandem/fcl/collision_manager.h"

#include <fcl/broadphase/broadphase_bruteforce.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <thread>

#include "catch.h"
#include "fcl_objects.h"

using namespace tandem::test;

namespace {

/// An object whose AABB can be set.
template <class S>
class Placed final : public Object<S> {
 public:
  Placed() : Object<S>(std::make_shared<::fcl::Sphere<S>>(S(1))) {}
  void set(const ::fcl::AABB<S>& box) { this->aabb = box; }
};

template <class S>
::fcl::AABB<S> box_at(const ::fcl::Vector3d& low, double size) {
  return {low.template cast<S>(), ::fcl::Vector3d(low.array() + size).template cast<S>()};
}

/// Random boxes; `endless`: unbounded ones among them, on some of which FCL's tree ends in a segmentation fault.
template <class S>
::fcl::AABB<S> random_box(Random& random, bool endless) {
  constexpr S most = std::numeric_limits<S>::max();
  const auto kind = endless ? random() % 60 : 3 + random() % 57;
  if (kind == 0) return {};                                                                       // FCL's null box
  if (kind == 1) return {::fcl::Vector3<S>::Constant(-most), ::fcl::Vector3<S>::Constant(most)};  // a half-space's
  if (kind == 2) {
    constexpr S inf = std::numeric_limits<S>::infinity();
    return {::fcl::Vector3<S>(-inf, S(uniform(random, 0, 10)), -inf), ::fcl::Vector3<S>(inf, inf, S(3))};
  }
  const double size = kind < 6 ? uniform(random, 2, 9) : uniform(random, 0, 1);
  return box_at<S>(random_point(random, 0, 12), size);
}

template <class S>
using PairCounts = std::map<std::pair<Object<S>*, Object<S>*>, int>;

template <class S>
bool count_pair(Object<S>* a, Object<S>* b, void* data) {
  ++(*static_cast<PairCounts<S>*>(data))[std::minmax(a, b)];
  return false;
}

template <class S>
bool count_overlapping(Object<S>* a, Object<S>* b, void* data) {
  return a->getAABB().overlap(b->getAABB()) && count_pair(a, b, data);
}

/// The distance of two objects is at least that of their boxes, but may be larger; `asked` counts calls.
template <class S>
struct Least {
  S value = std::numeric_limits<S>::max();
  std::size_t asked = 0;
};
template <class S>
bool keep_least(Object<S>* a, Object<S>* b, void* data, S& least) {
  auto& kept = *static_cast<Least<S>*>(data);
  ++kept.asked;
  const S more = (a->getAABB().center() - b->getAABB().center()).norm();
  const S apart = a->getAABB().distance(b->getAABB());
  kept.value = std::min(kept.value, apart + (apart > 0 && std::isfinite(more) ? S(0.125) * more : S(0)));
  least = kept.value;
  return least <= 0;
}

/// The naive manager visits all pairs; the tree manager also those whose boxes overlapped before an update shrank them.
template <class S>
PairCounts<S> collide(const Manager<S>& manager) {
  PairCounts<S> found;
  manager.collide(&found, count_overlapping<S>);
  return found;
}
/// All arguments of a callback.
template <class S>
PairCounts<S> called_for(const Manager<S>& manager) {
  PairCounts<S> found;
  manager.collide(&found, count_pair<S>);
  return found;
}
template <class S, class Other>
PairCounts<S> collide(const Manager<S>& manager, Other* other) {
  PairCounts<S> found;
  manager.collide(other, &found, count_overlapping<S>);
  return found;
}
template <class S, class... Other>
S distance(const Manager<S>& manager, Other*... other) {
  Least<S> least;
  manager.distance(other..., &least, keep_least<S>);
  return least.value;
}

template <class S>
void check_random_world(unsigned seed, bool endless) {
  Random random(seed);
  std::vector<std::unique_ptr<Placed<S>>> objects(160);
  for (auto& object : objects) {
    object = std::make_unique<Placed<S>>();
    object->set(random_box<S>(random, endless));
  }
  // Two sets of objects, each in tandem's, the naive and the tree manager.
  struct World {
    tandem::fcl::CollisionManager<S> ours;
    ::fcl::NaiveCollisionManager<S> naive;
    ::fcl::DynamicAABBTreeCollisionManager<S> tree;
    std::vector<Object<S>*> in;
    std::vector<Manager<S>*> all(bool with_tree) {
      if (with_tree) return {&ours, &naive, &tree};
      return {&ours, &naive};
    }
  } worlds[2];
  for (int round = 0; round < 40; ++round) {
    World& world = worlds[random() % 2];
    for (auto& object : objects) {
      const auto there = std::find(world.in.begin(), world.in.end(), object.get());
      const auto what = random() % 12;
      if (what == 0 && there != world.in.end()) {
        for (auto* manager : world.all(!endless)) manager->unregisterObject(object.get());
        world.in.erase(there);
      } else if (what == 1 && there == world.in.end()) {
        for (auto* manager : world.all(!endless)) manager->registerObject(object.get());
        world.in.push_back(object.get());
      }
    }
    if (round == 0) {
      std::vector<Object<S>*> fresh;
      for (std::size_t i = 0; i < 100; ++i)
        if (std::find(world.in.begin(), world.in.end(), objects[i].get()) == world.in.end())
          fresh.push_back(objects[i].get());
      for (auto* manager : world.all(!endless)) manager->registerObjects(fresh);
      world.in.insert(world.in.end(), fresh.begin(), fresh.end());
      for (auto* manager : world.all(!endless)) manager->setup();
    }
    std::vector<Object<S>*> moved;
    for (auto& object : objects)
      if (random() % 5 == 0) {
        object->set(random_box<S>(random, endless));
        moved.push_back(object.get());
      }
    for (World& w : worlds)  // unregistered objects are ignored
      for (auto* manager : w.all(!endless)) {
        if (round % 3 == 0) manager->update();
        if (round % 3 == 1) manager->update(moved);
        if (round % 3 == 2)
          for (auto* object : moved) manager->update(object);
      }

    CAPTURE(seed, round);
    REQUIRE(world.ours.size() == world.in.size());
    std::vector<Object<S>*> held;
    world.ours.getObjects(held);
    std::sort(held.begin(), held.end());
    auto wanted = world.in;
    std::sort(wanted.begin(), wanted.end());
    REQUIRE(held == wanted);

    REQUIRE(called_for<S>(world.ours) == called_for<S>(world.naive));
    if (!endless) REQUIRE(collide<S>(world.ours) == collide<S>(world.tree));
    REQUIRE(distance<S>(world.ours) == distance<S>(world.naive));
    if (!endless) REQUIRE(distance<S>(world.ours) == distance<S>(world.tree));
    for (int q = 0; q < 8; ++q) {
      Placed<S> asked;
      asked.set(random_box<S>(random, endless));
      Object<S>* const object = q < 6 ? &asked : objects[random() % objects.size()].get();
      REQUIRE(collide<S>(world.ours, object) == collide<S>(world.naive, object));
      if (!endless) REQUIRE(collide<S>(world.ours, object) == collide<S>(world.tree, object));
      REQUIRE(distance<S>(world.ours, object) == distance<S>(world.naive, object));
    }
    for (const bool turned : {false, true}) {
      World &one = worlds[turned ? 1 : 0], &other = worlds[turned ? 0 : 1];
      const auto pairs = collide<S>(one.naive, static_cast<Manager<S>*>(&other.naive));
      const S least = distance<S>(one.naive, static_cast<Manager<S>*>(&other.naive));
      for (auto* manager : other.all(!endless)) {
        REQUIRE(collide<S>(one.ours, manager) == pairs);
        REQUIRE(distance<S>(one.ours, manager) == least);
      }
    }
  }
}

}  // namespace

TEST_CASE("an FCL manager's pairs and least distances, while objects come, go and move") {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    for (const bool endless : {false, true}) {
      check_random_world<double>(seed, endless);
      check_random_world<float>(seed, endless);
    }
  }
}

TEST_CASE("a manager of many objects, of which some or all move, is asked as FCL's tree") {
  Random random(5);
  std::vector<std::unique_ptr<Placed<double>>> objects(3000);
  const auto put = [&](Placed<double>& object) { object.set(box_at<double>(random_point(random, 0, 20), 1)); };
  std::vector<Object<double>*> all;
  for (auto& object : objects) {
    object = std::make_unique<Placed<double>>();
    put(*object);
    all.push_back(object.get());
  }
  tandem::fcl::CollisionManagerd ours;
  ::fcl::DynamicAABBTreeCollisionManager<double> tree;
  ours.registerObjects(all);
  tree.registerObjects(all);
  for (int round = 0; round < 12; ++round) {
    for (auto& object : objects)
      if (round % 4 == 0 || random() % 20 == 0) put(*object);
    ours.update();
    tree.update();
    REQUIRE(collide<double>(ours) == collide<double>(tree));
    Placed<double> far;
    far.set(box_at<double>({uniform(random, -40, 60), 30, uniform(random, -40, 60)}, 1));
    Object<double>* const asked = &far;
    Least<double> least, theirs;
    ours.distance(asked, &least, keep_least<double>);
    tree.distance(asked, &theirs, keep_least<double>);
    REQUIRE(least.value == theirs.value);
    REQUIRE(least.asked < 500);  // of 3000: nearer ones first
  }
}

namespace {

bool stop_at_fourth(Object<double>*, Object<double>*, void* data) { return ++*static_cast<int*>(data) == 4; }
bool stop_at_fourth(Object<double>*, Object<double>*, void* data, double&) { return ++*static_cast<int*>(data) == 4; }
bool touch_at_once(Object<double>*, Object<double>*, void* data, double& least) {
  ++*static_cast<int*>(data);
  least = 0;
  return false;
}

}  // namespace

TEST_CASE("a callback that returns true is the last one") {
  std::vector<std::unique_ptr<Placed<double>>> objects(700);
  std::vector<Object<double>*> all;
  for (auto& object : objects) {
    object = std::make_unique<Placed<double>>();
    object->set(box_at<double>({0, 0, 0}, 1));
    all.push_back(object.get());
  }
  tandem::fcl::CollisionManagerd manager, other;
  manager.registerObjects(all);
  other.registerObjects({all.begin(), all.begin() + 10});
  const auto calls = [&](auto... asked) {
    int count = 0;
    manager.collide(asked..., &count, static_cast<::fcl::CollisionCallBack<double>>(stop_at_fourth));
    CHECK(count == 4);
    count = 0;
    manager.distance(asked..., &count, static_cast<::fcl::DistanceCallBack<double>>(stop_at_fourth));
    CHECK(count == 4);
    count = 0;  // no distance is below 0
    manager.distance(asked..., &count, touch_at_once);
    CHECK(count == 1);
  };
  calls();
  calls(all[0]);
  calls(static_cast<Manager<double>*>(&other));
  calls(static_cast<Manager<double>*>(&manager));
}

TEST_CASE("FCL objects registered twice, not registered, registered and not updated") {
  Placed<double> a, b, stranger;
  a.set(box_at<double>({0, 0, 0}, 1));
  b.set(box_at<double>({0.5, 0, 0}, 1));
  stranger.set(box_at<double>({0, 0, 0}, 1));
  tandem::fcl::CollisionManagerd ours;
  ::fcl::DynamicAABBTreeCollisionManager<double> tree;
  CHECK(ours.empty());
  ours.setup();
  ours.update();
  ours.unregisterObject(&a);
  CHECK(called_for<double>(ours).empty());
  CHECK(distance<double>(ours) == std::numeric_limits<double>::max());

  for (Manager<double>* manager : {static_cast<Manager<double>*>(&ours), static_cast<Manager<double>*>(&tree)}) {
    manager->registerObject(&a);
    manager->registerObject(&b);
    manager->registerObject(&a);
    CHECK(manager->size() == 3);
    CHECK(called_for<double>(*manager) == PairCounts<double>{{{&a, &a}, 1}, {std::minmax<Object<double>*>(&a, &b), 2}});
    manager->unregisterObject(&a);
    CHECK(manager->size() == 2);
    CHECK(called_for<double>(*manager) == PairCounts<double>{{std::minmax<Object<double>*>(&a, &b), 1}});
  }
  ours.unregisterObject(&stranger);
  ours.update(&stranger);
  CHECK(ours.size() == 2);

  tree.clear();
  tree.registerObject(&a);
  tree.registerObject(&b);
  b.set(box_at<double>({5, 0, 0}, 1));
  CHECK(called_for<double>(ours).size() == 1);  // as they were
  CHECK(called_for<double>(tree).size() == 1);
  ours.update(&b);
  tree.update(&b);
  CHECK(called_for<double>(ours).empty());
  CHECK(called_for<double>(tree).empty());

  ours.unregisterObject(&a);
  ours.unregisterObject(&b);
  CHECK(ours.empty());
  CHECK(called_for<double>(ours).empty());
  ours.registerObject(&b);
  CHECK(ours.size() == 1);
  ours.clear();
  CHECK(ours.empty());
}

TEST_CASE("an FCL manager takes boxes with NaN for what FCL's test makes of them") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::unique_ptr<Placed<double>>> objects(40);
  tandem::fcl::CollisionManagerd ours;
  ::fcl::NaiveCollisionManager<double> naive;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    objects[i] = std::make_unique<Placed<double>>();
    auto box = box_at<double>({static_cast<double>(i), 0, 0}, 1.5);
    if (i % 7 == 0) box.min_[i % 3] = nan;
    if (i % 9 == 0) box.max_[i % 3] = nan;
    objects[i]->set(box);
    ours.registerObject(objects[i].get());
    naive.registerObject(objects[i].get());
  }
  CHECK(called_for<double>(ours) == called_for<double>(naive));
}

TEST_CASE("many threads may ask an FCL manager right after objects were registered") {
  std::vector<std::unique_ptr<Placed<double>>> objects(2000);
  tandem::fcl::CollisionManagerd manager;
  Random random(3);
  for (auto& object : objects) {
    object = std::make_unique<Placed<double>>();
    object->set(box_at<double>(random_point(random, 0, 10), 1));
    manager.registerObject(object.get());
  }
  std::vector<PairCounts<double>> found(4);
  std::vector<std::thread> threads;
  for (auto& counts : found) threads.emplace_back([&] { manager.collide(&counts, count_pair<double>); });
  for (std::thread& thread : threads) thread.join();
  CHECK(found[0].size() > 1000);
  for (const auto& counts : found) CHECK(counts == found[0]);
}
