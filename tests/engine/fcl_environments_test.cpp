// tandem::fcl::CollisionManager in environments like those of FCL's own tests of its managers: random shapes and
// meshes, grids of close objects, octrees; queried with FCL's default callbacks, beside FCL's managers.
#include <fcl/broadphase/broadphase_SSaP.h>
#include <fcl/broadphase/broadphase_bruteforce.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree_array.h>
#include <fcl/broadphase/broadphase_interval_tree.h>
#include <fcl/broadphase/broadphase_spatialhash.h>
#include <fcl/broadphase/default_broadphase_callbacks.h>
#include <fcl/geometry/geometric_shape_to_BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "catch.h"
#include "fcl_objects.h"
#include "tandem/fcl/collision_manager.h"
#include "tandem/fcl/octree_shape.h"
#include "tandem/fcl/pair_queries.h"
#include "tandem/formats/input_error.h"
#include "tandem/formats/octomap_file.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem::test;

namespace {
template <class S>
using Geometry = std::shared_ptr<::fcl::CollisionGeometry<S>>;

template <class S>
::fcl::Transform3<S> random_pose(Random& random, double reach) {
  ::fcl::Quaternion<S> q{S(uniform(random, -1, 1)), S(uniform(random, -1, 1)), S(uniform(random, -1, 1)), S(1.1)};
  ::fcl::Transform3<S> pose = ::fcl::Transform3<S>::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  for (int k = 0; k < 3; ++k) pose.translation()[k] = S(uniform(random, -reach, reach));
  return pose;
}

/// Objects, owned.
template <class S>
struct Objects {
  std::vector<std::unique_ptr<Object<S>>> held;
  std::vector<Object<S>*> all;
  void add(const Geometry<S>& geometry, const ::fcl::Transform3<S>& pose) {
    held.push_back(std::make_unique<Object<S>>(geometry, pose));
    held.back()->computeAABB();
    all.push_back(held.back().get());
  }
};

template <class S, class Shape>
Geometry<S> mesh_of(const Shape& shape) {
  auto model = std::make_shared<::fcl::BVHModel<::fcl::OBBRSS<S>>>();
  const auto here = ::fcl::Transform3<S>::Identity();
  if constexpr (std::is_same_v<Shape, ::fcl::Box<S>>)
    ::fcl::generateBVHModel(*model, shape, here);
  else
    ::fcl::generateBVHModel(*model, shape, here, 8, 8);
  return model;
}

template <class S>
Objects<S> environment(Random& random, double reach, int n, bool meshes) {
  const ::fcl::Box<S> box(5, 10, 20);
  const ::fcl::Sphere<S> sphere(30);
  const ::fcl::Cylinder<S> cylinder(10, 40);
  std::vector<Geometry<S>> kinds;
  if (meshes)
    kinds = {mesh_of<S>(box), mesh_of<S>(sphere), mesh_of<S>(cylinder)};
  else
    kinds = {std::make_shared<::fcl::Box<S>>(box), std::make_shared<::fcl::Sphere<S>>(sphere),
             std::make_shared<::fcl::Cylinder<S>>(cylinder)};
  Objects<S> objects;
  for (const auto& kind : kinds)
    for (int i = 0; i < n; ++i) objects.add(kind, random_pose<S>(random, reach));
  return objects;
}

/// A grid of objects that nearly touch, of the kinds in turn.
template <class S>
Objects<S> crowd(double reach, int edge) {
  const double step = 2 * reach / edge, gap = 0.05 * step, size = step - 2 * gap;
  const std::vector<Geometry<S>> kinds{std::make_shared<::fcl::Box<S>>(S(size), S(size), S(size)),
                                       std::make_shared<::fcl::Sphere<S>>(S(size / 2)),
                                       std::make_shared<::fcl::Ellipsoid<S>>(S(size / 2), S(size / 2), S(size / 2)),
                                       std::make_shared<::fcl::Cylinder<S>>(S(size / 2), S(size)),
                                       std::make_shared<::fcl::Cone<S>>(S(size / 2), S(size))};
  Objects<S> objects;
  for (int i = 0; i < edge * edge * edge; ++i) {
    ::fcl::Transform3<S> pose = ::fcl::Transform3<S>::Identity();
    pose.translation() = ::fcl::Vector3<S>(S(i % edge), S(i / edge % edge), S(i / edge / edge)) * S(step);
    objects.add(kinds[static_cast<std::size_t>(i) % kinds.size()], pose);
  }
  return objects;
}

/// Moves and rotates each object slightly, as between two updates.
template <class S>
void stir(Random& random, Objects<S>& objects, double by) {
  for (Object<S>* object : objects.all) {
    ::fcl::Transform3<S> turn = random_pose<S>(random, 0);
    ::fcl::Vector3<S> to = turn.linear() * object->getTranslation();
    for (int k = 0; k < 3; ++k) to[k] += S(uniform(random, -by, by));
    object->setTransform(::fcl::Matrix3<S>(turn.linear() * object->getRotation()), to);
    object->computeAABB();
  }
}

/// tandem's first, then FCL's, by name.
template <class S>
std::vector<std::pair<const char*, std::unique_ptr<Manager<S>>>> managers(const Objects<S>& objects) {
  std::vector<std::pair<const char*, std::unique_ptr<Manager<S>>>> out;
  out.emplace_back("tandem", std::make_unique<tandem::fcl::CollisionManager<S>>());
  out.emplace_back("naive", std::make_unique<::fcl::NaiveCollisionManager<S>>());
  out.emplace_back("tree", std::make_unique<::fcl::DynamicAABBTreeCollisionManager<S>>());
  // Instantiated in FCL's library; the update of its SaP manager may not terminate.
  if constexpr (std::is_same_v<S, double>) {
    out.emplace_back("tree in an array", std::make_unique<::fcl::DynamicAABBTreeCollisionManager_Array<S>>());
    out.emplace_back("SSaP", std::make_unique<::fcl::SSaPCollisionManager<S>>());
    out.emplace_back("interval tree", std::make_unique<::fcl::IntervalTreeCollisionManager<S>>());
    ::fcl::Vector3<S> lo, hi;
    ::fcl::SpatialHashingCollisionManager<S>::computeBound(const_cast<std::vector<Object<S>*>&>(objects.all), lo, hi);
    out.emplace_back("spatial hash",
                     std::make_unique<::fcl::SpatialHashingCollisionManager<S>>(S((hi - lo).maxCoeff() / 5), lo, hi));
  }
  for (auto& [name, manager] : out) {
    manager->registerObjects(objects.all);
    manager->setup();
  }
  return out;
}

/// FCL's default callbacks; for float, which FCL's library lacks, the same with tandem's answers.
bool collide_default(Object<double>* a, Object<double>* b, void* data) {
  return ::fcl::DefaultCollisionFunction<double>(a, b, data);
}
bool collide_default(Object<float>* a, Object<float>* b, void* data) {
  auto& kept = *static_cast<::fcl::DefaultCollisionData<float>*>(data);
  if (kept.done) return true;
  tandem::fcl::collide(a, b, kept.request, kept.result);
  kept.done = kept.result.numContacts() >= kept.request.num_max_contacts;
  return kept.done;
}
bool distance_default(Object<double>* a, Object<double>* b, void* data, double& least) {
  return ::fcl::DefaultDistanceFunction<double>(a, b, data, least);
}
bool distance_default(Object<float>* a, Object<float>* b, void* data, float& least) {
  auto& kept = *static_cast<::fcl::DefaultDistanceData<float>*>(data);
  least = kept.result.min_distance;
  if (kept.done) return true;
  tandem::fcl::distance(a, b, kept.request, kept.result);
  least = kept.result.min_distance;
  return least <= 0 || kept.done;
}

template <class S>
using Collides = bool (*)(Object<S>*, Object<S>*, void*);
template <class S>
using Distances = bool (*)(Object<S>*, Object<S>*, void*, S&);

template <class S, class... Asked>
std::size_t contacts(const Manager<S>& manager, std::size_t most, Asked... asked) {
  ::fcl::DefaultCollisionData<S> data;
  data.request.num_max_contacts = most;
  manager.collide(asked..., &data, static_cast<Collides<S>>(collide_default));
  return data.result.numContacts();
}
template <class S, class... Asked>
S least_distance(const Manager<S>& manager, Asked... asked) {
  ::fcl::DefaultDistanceData<S> data;
  manager.distance(asked..., &data, static_cast<Distances<S>>(distance_default));
  return data.result.min_distance;
}

/// The error of FCL's distances, which depends on the order of the two.
template <class S>
void check_same_distance(S ours, S theirs) {
  CHECK((ours <= 0) == (theirs <= 0));
  if (ours > 0) CHECK(std::abs(ours - theirs) < S(1e-2));
}

template <class S>
void check_collisions(unsigned seed, bool meshes, std::size_t most) {
  Random random(seed);
  Objects<S> objects = environment<S>(random, 120, meshes ? 8 : 20, meshes);
  Objects<S> asked = environment<S>(random, 120, 3, meshes);
  const auto all = managers<S>(objects);
  for (int round = 0; round < 3; ++round) {
    const bool all_contacts = most > 1000;
    const auto counted = [&](std::size_t n) { return all_contacts ? n : std::size_t{n > 0}; };
    const std::size_t ours = counted(contacts<S>(*all[0].second, most));
    if (all_contacts) CHECK(ours > 5);
    for (const auto& [name, manager] : all) {
      CAPTURE(name, seed, meshes, round);
      CHECK(counted(contacts<S>(*manager, most)) == ours);
      for (Object<S>* object : asked.all)
        CHECK(counted(contacts<S>(*manager, most, object)) == counted(contacts<S>(*all[0].second, most, object)));
    }
    stir(random, objects, 20);
    for (const auto& [name, manager] : all) manager->update();
  }
}

}  // namespace

TEST_CASE("FCL's default collision callback counts the same contacts in tandem's and FCL's managers") {
  for (const bool meshes : {false, true}) {
    check_collisions<double>(1, meshes, 100000);
    check_collisions<double>(2, meshes, 1);
    check_collisions<double>(3, meshes, 10);
    check_collisions<float>(1, meshes, 100000);
  }
}

namespace {

template <class S>
struct Unique {
  std::set<std::pair<Object<S>*, Object<S>*>> pairs;
};
template <class S>
bool must_be_new(Object<S>* a, Object<S>* b, void* data) {
  CHECK(static_cast<Unique<S>*>(data)->pairs.insert(std::minmax(a, b)).second);
  return false;
}
template <class S>
bool must_be_new(Object<S>* a, Object<S>* b, void* data, S&) {
  return must_be_new<S>(a, b, data);
}

template <class S>
void check_unique() {
  Random random(4);
  Objects<S> objects = environment<S>(random, 150, 60, false);
  tandem::fcl::CollisionManager<S> manager;
  manager.registerObjects(objects.all);
  for (int round = 0; round < 4; ++round) {
    Unique<S> met, near;
    manager.collide(&met, static_cast<Collides<S>>(must_be_new<S>));
    manager.distance(&near, static_cast<Distances<S>>(must_be_new<S>));
    CHECK(near.pairs.size() == 180 * 179 / 2);  // no distance is below the limit: all pairs are visited
    CHECK(met.pairs.size() > 100);
    stir(random, objects, 30);
    manager.update();
  }
}

}  // namespace

TEST_CASE("an FCL manager shows no pair twice, and all pairs where no distance is told") {
  check_unique<double>();
  check_unique<float>();
}

namespace {

template <class S>
void check_distances(unsigned seed, Objects<S> objects, double reach) {
  Random random(seed);
  Objects<S> asked = environment<S>(random, reach, 3, false);
  const auto all = managers<S>(objects);
  for (int round = 0; round < 2; ++round) {
    const S self = least_distance<S>(*all[0].second);
    for (const auto& [name, manager] : all) {
      CAPTURE(name, seed, round);
      check_same_distance(self, least_distance<S>(*manager));
      for (Object<S>* object : asked.all)
        check_same_distance(least_distance<S>(*all[0].second, object), least_distance<S>(*manager, object));
    }
    stir(random, objects, 1);
    for (const auto& [name, manager] : all) manager->update();
  }
}

template <class S>
void check_distances() {
  Random random(6);
  check_distances<S>(7, crowd<S>(200, 4), 400);
  check_distances<S>(8, environment<S>(random, 1500, 12, false), 1500);
  check_distances<S>(9, environment<S>(random, 2000, 4, true), 2000);
}

}  // namespace

TEST_CASE("FCL's default distance callback finds the same least distance in tandem's and FCL's managers") {
  check_distances<double>();
  check_distances<float>();
}

TEST_CASE("two FCL managers are asked about each other") {
  Random random(10);
  Objects<double> some = environment<double>(random, 150, 25, false),
                  others = environment<double>(random, 150, 12, false);
  Objects<double> far = environment<double>(random, 100, 5, false);
  for (Object<double>* object : far.all) {
    object->setTranslation(object->getTranslation() + ::fcl::Vector3d(2000, 0, 0));
    object->computeAABB();
  }
  const auto one = managers<double>(some), other = managers<double>(others), third = managers<double>(far);
  // tandem's octree with tandem's and with each of FCL's; FCL's tree manager takes only its own kind.
  const std::size_t theirs = contacts<double>(*one[2].second, 100000, other[2].second.get());
  const double apart = least_distance<double>(*one[2].second, third[2].second.get());
  CHECK(theirs > 10);
  CHECK(apart > 100);
  for (std::size_t i = 0; i < other.size(); ++i) {
    CAPTURE(other[i].first);
    CHECK(contacts<double>(*one[0].second, 100000, other[i].second.get()) == theirs);
    check_same_distance(least_distance<double>(*one[0].second, third[i].second.get()), apart);
  }
}

namespace {

/// FCL's test "DynamicAABBTreeCollisionManager, class": a tree of two spheres, whose order changes with each update.
bool note_order(Object<double>* a, Object<double>* b, void* data, double&) {
  static_cast<std::vector<std::pair<Object<double>*, Object<double>*>>*>(data)->emplace_back(a, b);
  return false;
}

}  // namespace

TEST_CASE("two objects of an FCL manager change their order with each update, as in FCL's tree") {
  Object<double> one(std::make_shared<::fcl::Sphered>(0.1)), other(std::make_shared<::fcl::Sphered>(0.2));
  one.setTranslation({0.1, 0.2, 0.3});
  other.setTranslation({0.11, 0.21, 0.31});
  for (Object<double>* object : {&one, &other}) object->computeAABB();
  tandem::fcl::CollisionManagerd ours;
  ::fcl::DynamicAABBTreeCollisionManagerd theirs;
  std::vector<std::pair<Object<double>*, Object<double>*>> seen[2];
  for (Manager<double>* manager : {static_cast<Manager<double>*>(&ours), static_cast<Manager<double>*>(&theirs)}) {
    auto& order = seen[manager == &ours ? 0 : 1];
    manager->registerObject(&one);
    manager->registerObject(&other);
    for (int count = 0; count < 8; ++count) {
      manager->update();
      manager->distance(&order, static_cast<Distances<double>>(note_order));
    }
    CHECK(order.size() == 8);
  }
  CHECK(seen[0] == seen[1]);
}

#if FCL_HAVE_OCTOMAP
namespace {

std::shared_ptr<octomap::OcTree> octree(double resolution) {
  auto tree = std::make_shared<octomap::OcTree>(resolution);
  // A block observed as occupied within one observed as free.
  for (int x = -10; x < 10; ++x)
    for (int y = -10; y < 10; ++y)
      for (int z = -10; z < 10; ++z)
        tree->updateNode(octomap::point3d(float(x) * 0.1f + 0.01f, float(y) * 0.1f + 0.01f, float(z) * 0.1f + 0.01f),
                         true);
  for (int x = -15; x < 15; ++x)
    for (int y = -15; y < 15; ++y)
      for (int z = -15; z < 15; ++z)
        tree->updateNode(octomap::point3d(float(x) * 0.2f + 0.01f, float(y) * 0.2f + 0.01f, float(z) * 0.2f + 0.01f),
                         false);
  return tree;
}

/// The arguments of a callback: an object and a cell, by its position and size in thousandths.
template <class S>
struct Cells {
  std::map<std::tuple<Object<S>*, long, long, long, long>, int> seen;
  S least = std::numeric_limits<S>::max();
  std::size_t wanted = static_cast<std::size_t>(-1);
};
template <class S>
bool note_cell(Object<S>* object, Object<S>* cell, void* data) {
  auto& cells = *static_cast<Cells<S>*>(data);
  const auto& box = static_cast<const ::fcl::Box<S>&>(*cell->collisionGeometry());
  const auto at = [&](int k) { return std::lround(1000 * cell->getTranslation()[k]); };
  ++cells.seen[{object, at(0), at(1), at(2), std::lround(1000 * box.side[0])}];
  CHECK((box.cost_density == S(0.5) || box.isOccupied()));
  return cells.seen.size() >= cells.wanted;
}
template <class S>
bool note_cell(Object<S>* object, Object<S>* cell, void* data, S& least) {
  auto& cells = *static_cast<Cells<S>*>(data);
  note_cell<S>(object, cell, data);
  cells.least = std::min(cells.least, object->getAABB().distance(cell->getAABB()));
  least = cells.least;
  return false;
}

template <class S>
void check_octree(bool is_turned) {
  Random random(11);
  Objects<S> objects;
  for (int i = 0; i < 60; ++i)
    objects.add(std::make_shared<::fcl::Box<S>>(S(0.2), S(0.1), S(0.3)), random_pose<S>(random, i < 40 ? 1.5 : 30));
  const auto geometry = std::make_shared<::fcl::OcTree<S>>(octree(0.1));
  Object<S> asked(geometry, is_turned ? random_pose<S>(random, 0.3) : ::fcl::Transform3<S>::Identity());
  if (!is_turned) asked.setTranslation({S(0.125), S(0.25), S(0)});
  asked.computeAABB();
  tandem::fcl::CollisionManager<S> ours;
  ::fcl::DynamicAABBTreeCollisionManager<S> theirs;
  ours.registerObjects(objects.all);
  theirs.registerObjects(objects.all);
  ours.octree_as_geometry_collide = theirs.octree_as_geometry_collide = false;
  Cells<S> our_cells, their_cells;
  ours.collide(&asked, &our_cells, static_cast<Collides<S>>(note_cell<S>));
  theirs.collide(&asked, &their_cells, static_cast<Collides<S>>(note_cell<S>));
  CHECK(our_cells.seen.size() > 100);
  CHECK(our_cells.seen == their_cells.seen);
  Cells<S> three;
  three.wanted = 3;
  ours.collide(&asked, &three, static_cast<Collides<S>>(note_cell<S>));
  CHECK(three.seen.size() == 3);

  for (Object<S>* object : objects.all) {  // away from all others, for a distance above 0
    object->setTranslation(object->getTranslation() + ::fcl::Vector3<S>(40, 0, 0));
    object->computeAABB();
  }
  ours.update();
  theirs.update();
  Cells<S> our_distance, their_distance;
  ours.distance(&asked, &our_distance, static_cast<Distances<S>>(note_cell<S>));
  theirs.distance(&asked, &their_distance, static_cast<Distances<S>>(note_cell<S>));
  CHECK(our_distance.least > S(1));
  CHECK(our_distance.least == their_distance.least);
  CHECK(our_distance.seen.size() <= their_distance.seen.size());
}

}  // namespace

TEST_CASE("cells of an octree are shown to callbacks as by FCL's tree") {
  for (const bool is_turned : {false, true}) {
    check_octree<double>(is_turned);
    check_octree<float>(is_turned);
  }
}

TEST_CASE("an octree collides, costs and is as far as the boxes of its occupied cells") {
  Random random(12);
  const auto geometry = std::make_shared<::fcl::OcTreed>(octree(0.1));
  Object<double> tree(geometry);
  tree.computeAABB();
  Objects<double> boxes;
  for (const auto& cell : geometry->toBoxes()) {
    ::fcl::Transform3d pose = ::fcl::Transform3d::Identity();
    pose.translation() = ::fcl::Vector3d(cell[0], cell[1], cell[2]);
    boxes.add(std::make_shared<::fcl::Boxd>(cell[3], cell[3], cell[3]), pose);
  }
  REQUIRE(boxes.all.size() > 100);
  tandem::fcl::CollisionManagerd other;
  other.registerObjects(boxes.all);
  for (const bool near : {true, false}) {
    Objects<double> objects;
    for (int i = 0; i < 40; ++i) {
      auto pose = random_pose<double>(random, 1.5);
      if (!near) pose.translation().x() += 6;
      objects.add(std::make_shared<::fcl::Sphered>(0.05), pose);
    }
    tandem::fcl::CollisionManagerd manager;
    ::fcl::DynamicAABBTreeCollisionManagerd theirs;
    manager.registerObjects(objects.all);
    theirs.registerObjects(objects.all);
    theirs.octree_as_geometry_collide = manager.octree_as_geometry_collide = false;
    const std::size_t by_cells = contacts<double>(manager, 100000, &tree);
    CHECK((by_cells > 0) == near);
    CHECK(by_cells == contacts<double>(theirs, 100000, &tree));
    CHECK(by_cells == contacts<double>(manager, 100000, static_cast<Manager<double>*>(&other)));
    manager.octree_as_geometry_collide = true;
    CHECK(by_cells == contacts<double>(manager, 100000, &tree));

    const double apart = least_distance<double>(manager, &tree);
    CHECK((apart > 1) == !near);
    check_same_distance(apart, least_distance<double>(theirs, &tree));
    check_same_distance(apart, least_distance<double>(manager, static_cast<Manager<double>*>(&other)));
    manager.octree_as_geometry_distance = true;
    check_same_distance(apart, least_distance<double>(manager, &tree));

    ::fcl::DefaultCollisionData<double> ours_cost, theirs_cost;
    for (auto* data : {&ours_cost, &theirs_cost}) {
      data->request = ::fcl::CollisionRequestd(100000, false, 100000, true);
      Manager<double>& asked = data == &ours_cost ? static_cast<Manager<double>&>(manager) : theirs;
      asked.collide(&tree, data, static_cast<Collides<double>>(collide_default));
    }
    CHECK(ours_cost.result.numContacts() == theirs_cost.result.numContacts());
  }
}

TEST_CASE("an octree from octomap's file as voxels: a ball meets and is as far as from its occupied cells") {
  std::stringstream file;
  REQUIRE(octree(0.1)->writeBinary(file));
  auto read = std::make_shared<octomap::OcTree>(1.0);
  REQUIRE(read->readBinary(file));
  const ::fcl::OcTreed geometry(read);
  const auto solid = tandem::fcl::to_voxels(geometry);
  REQUIRE(solid);
  const auto cells = geometry.toBoxes();
  const tandem::NarrowPhase narrow;
  Random random(13);
  int hits = 0;
  for (int i = 0; i < 60; ++i) {
    const tandem::Vec3 at{uniform(random, -2, 2), uniform(random, -2, 2), uniform(random, -2, 2)};
    const tandem::Shape ball = tandem::Sphere{0.1};
    double least = std::numeric_limits<double>::infinity();
    for (const auto& cell : cells) {
      tandem::Vec3 off;
      for (int k = 0; k < 3; ++k) off[k] = std::max(std::abs(at[k] - cell[std::size_t(k)]) - cell[3] / 2, 0.0);
      least = std::min(least, off.norm() - 0.1);
    }
    const auto pose = tandem::Pose::at(at.x(), at.y(), at.z());
    CHECK(narrow.solve(ball, pose, *solid, {}, tandem::Request::collide).collide == (least <= 0));
    if (least > 0)
      CHECK(std::abs(narrow.solve(ball, pose, *solid, {}, tandem::Request::distance).signed_distance - least) < 1e-9);
    hits += least <= 0;
  }
  CHECK(hits > 5);
  CHECK_FALSE(tandem::fcl::to_voxels(::fcl::OcTreed(0.1)));
}

TEST_CASE("octomap's files, of either kind, are read as its own library reads them") {
  const auto folder = std::filesystem::temp_directory_path() / "tandem-octomap-test";
  std::filesystem::create_directories(folder);
  const auto tree = octree(0.05);
  for (const char* name : {"map.bt", "map.ot"}) {
    const std::string path = (folder / name).string();
    const bool is_binary = std::string(name).ends_with("bt");
    REQUIRE((is_binary ? tree->writeBinary(path) : tree->write(path)));
    const tandem::Shape ours(tandem::read_octomap_file(path));
    const auto theirs = tandem::fcl::to_voxels(::fcl::OcTreed(tree));
    REQUIRE(theirs);
    CHECK(ours.cell_size() == 0.05);
    CHECK(ours.cells().size() > 10);
    CHECK(std::equal(ours.cells().begin(), ours.cells().end(), theirs->cells().begin(), theirs->cells().end()));
    // Cut off anywhere, or of another tree.
    std::ifstream in(path, std::ios::binary);
    std::stringstream all;
    all << in.rdbuf();
    const std::string bytes = all.str();
    for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 50) {
      std::ofstream(path, std::ios::binary) << bytes.substr(0, length);
      CHECK_THROWS_AS(tandem::read_octomap_file(path), tandem::InputError);
    }
    std::string other = bytes;
    other.replace(other.find("id OcTree"), 9, "id ColorOcTree");
    std::ofstream(path, std::ios::binary) << other;
    CHECK_THROWS_AS(tandem::read_octomap_file(path), tandem::InputError);
  }
  std::filesystem::remove_all(folder);
}
#endif  // FCL_HAVE_OCTOMAP
