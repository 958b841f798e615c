// tandem::fcl::CollisionManager beside FCL's own managers on the same moving objects: every manager does each operation
// of each step in turn, in one process.
#include <fcl/broadphase/broadphase_SaP.h>
#include <fcl/broadphase/broadphase_bruteforce.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>
#include <fmt/format.h>

#include <random>
#include <stdexcept>

#include "benches.h"
#include "clocks.h"
#include "tandem/fcl/collision_manager.h"

namespace tandem::bench {
namespace {

using Object = ::fcl::CollisionObject<double>;
using Manager = ::fcl::BroadPhaseCollisionManager<double>;

/// Boxes and spheres, a fraction of which rotates and moves by up to a fiftieth of an edge a step.
class Objects {
 public:
  Objects(std::size_t n, double share) : side_(1.6 * std::cbrt(static_cast<double>(n))) {
    const auto box = std::make_shared<::fcl::Boxd>(1, 0.8, 0.6);
    const auto sphere = std::make_shared<::fcl::Sphered>(0.5);
    for (std::size_t i = 0; i < n; ++i) {
      objects_.push_back(i % 2 == 0 ? std::make_unique<Object>(box) : std::make_unique<Object>(sphere));
      Object& object = *objects_.back();
      object.setTransform(turn(), point());
      object.setUserData(reinterpret_cast<void*>(i));
      object.computeAABB();
      if (number() > share) continue;
      const ::fcl::Vector3d velocity(number() - 0.5, number() - 0.5, number() - 0.5), axis(0, number(), 1);
      moving_.push_back({i, 0.04 * velocity, ::fcl::AngleAxisd(0.05, axis.normalized()).toRotationMatrix()});
    }
  }
  std::vector<Object*> all() const {
    std::vector<Object*> out;
    for (const auto& object : objects_) out.push_back(object.get());
    return out;
  }
  /// One step of the objects that move, between the walls.
  void move() {
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      Moving& m = moving_[i];
      Object& object = *objects_[m.index];
      ::fcl::Vector3d to = object.getTranslation() + m.velocity;
      for (int k = 0; k < 3; ++k)
        if (to[k] < 0 || to[k] > side_) m.velocity[k] = -m.velocity[k];
      object.setTransform(::fcl::Matrix3d(m.turn * object.getRotation()), to);
      object.computeAABB();
    }
  }
  /// An object that is not registered, anywhere in the world; for distances `beyond` away from its side.
  Object stranger(double beyond) {
    Object object(std::make_shared<::fcl::Boxd>(1, 1, 1), turn(), point() + ::fcl::Vector3d(0, 0, beyond * side_));
    object.setUserData(reinterpret_cast<void*>(objects_.size()));
    return object;
  }

 private:
  double number() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  ::fcl::Vector3d point() { return side_ * ::fcl::Vector3d(number(), number(), number()); }
  ::fcl::Matrix3d turn() {
    return ::fcl::Quaterniond(number() - 0.5, number() - 0.5, number() - 0.5, number() + 0.1)
        .normalized()
        .toRotationMatrix();
  }

  struct Moving {
    std::size_t index;
    ::fcl::Vector3d velocity;
    ::fcl::Matrix3d turn;
  };

  std::mt19937 random_{1};
  double side_;
  std::vector<Moving> moving_;
  std::vector<std::unique_ptr<Object>> objects_;
};

/// A hash of the pairs, independent of their order, and the least distance.
struct Answer {
  std::uint64_t pairs = 0, hash = 0;
  double least = std::numeric_limits<double>::max();
};

std::uint64_t index_of(const Object* object) { return reinterpret_cast<std::uint64_t>(object->getUserData()); }

bool take(Object* a, Object* b, void* data) {
  if (!a->getAABB().overlap(b->getAABB())) return false;  // the naive manager does not test boxes
  auto& answer = *static_cast<Answer*>(data);
  const auto [lo, hi] = std::minmax({index_of(a), index_of(b)});
  std::uint64_t z = (lo << 32 | hi) + 0x9e3779b97f4a7c15;  // SplitMix64 (Steele et al. 2014)
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  ++answer.pairs;
  answer.hash += z ^ (z >> 27);
  return false;
}

/// The distance of the bounding spheres of the two, which is no less than that of their boxes.
bool take_distance(Object* a, Object* b, void* data, double& least) {
  auto& answer = *static_cast<Answer*>(data);
  ++answer.pairs;
  const double apart = (a->getTranslation() - b->getTranslation()).norm() -
                       (a->collisionGeometry()->aabb_radius + b->collisionGeometry()->aabb_radius);
  least = std::min(least, std::max(apart, a->getAABB().distance(b->getAABB())));
  answer.least = least;
  return least <= 0;
}

/// FCL's distance of the two, as a program would ask for it.
bool take_fcl_distance(Object* a, Object* b, void* data, double& least) {
  auto& answer = *static_cast<Answer*>(data);
  ++answer.pairs;
  ::fcl::DistanceResultd result;
  ::fcl::distance(a, b, ::fcl::DistanceRequestd(), result);
  answer.least = least = std::min(least, result.min_distance);
  return least <= 0;
}

struct ManagerEntrant {
  std::string name;
  std::unique_ptr<Manager> manager;
};

std::vector<ManagerEntrant> entrants(std::size_t n, const Settings& settings) {
  std::vector<ManagerEntrant> all;
  all.push_back({"tandem", std::make_unique<tandem::fcl::CollisionManagerd>()});
  all.push_back({"FCL tree", std::make_unique<::fcl::DynamicAABBTreeCollisionManagerd>()});
  all.push_back({"FCL SaP", std::make_unique<::fcl::SaPCollisionManagerd>()});
  if (n <= 3000) all.push_back({"FCL naive", std::make_unique<::fcl::NaiveCollisionManagerd>()});
  const auto& wanted = settings.contestants;
  std::erase_if(all, [&](const ManagerEntrant& entrant) {
    return !wanted.empty() && std::find(wanted.begin(), wanted.end(), entrant.name) == wanted.end();
  });
  return all;
}

struct Operation {
  std::string name;
  bool after_a_move;
  std::function<void(Manager&, Answer&)> run;
  std::vector<Samples> times{};   // by contestant
  std::vector<Samples> ratios{};  // to the first's time in the same step
  Answer answer{};
};

/// The error of FCL's distances, which depends on the order of the two.
constexpr double fcl_error = 1e-4;

void run_in_turn(Operation& operation, std::vector<ManagerEntrant>& all, int step) {
  std::vector<double> times(all.size());
  std::vector<Answer> answers(all.size());
  for (std::size_t turn = 0; turn < all.size(); ++turn) {
    const std::size_t who = (turn + static_cast<std::size_t>(step)) % all.size();
    const double begin = cpu_ns();
    operation.run(*all[who].manager, answers[who]);
    times[who] = cpu_ns() - begin;
  }
  operation.answer = answers[0];
  for (std::size_t who = 0; who < all.size(); ++who) {
    if (answers[who].hash != answers[0].hash || !(std::abs(answers[who].least - answers[0].least) <= fcl_error))
      throw std::runtime_error(fmt::format("step {}: {} and {} differ in {}: {} and {} pairs, distances {} and {}",
                                           step, all[0].name, all[who].name, operation.name, answers[0].pairs,
                                           answers[who].pairs, answers[0].least, answers[who].least));
    operation.times[who].add(times[who]);
    operation.ratios[who].add(times[who] / times[0]);
  }
}

/// The objects that a step queries with: among the others, and beside them.
struct Askers {
  std::vector<Object> inside, outside;
};

std::vector<Operation> all_operations(Askers& askers) {
  return {
      {"update", true, [](Manager& m, Answer&) { m.update(); }},
      {"update, collide", true,
       [](Manager& m, Answer& answer) {
         m.update();
         m.collide(&answer, take);
       }},
      {"update, distance", true,
       [](Manager& m, Answer& answer) {
         m.update();
         m.distance(&answer, take_distance);
       }},
      {"update, 100 ask", true,
       [&askers](Manager& m, Answer& answer) {
         m.update();
         for (Object& object : askers.inside) m.collide(&object, &answer, take);
       }},
      {"collide object", false,
       [&askers](Manager& m, Answer& answer) {
         for (Object& object : askers.inside) m.collide(&object, &answer, take);
       }},
      {"distance object", false,
       [&askers](Manager& m, Answer& answer) {
         for (Object& object : askers.outside) m.distance(&object, &answer, take_distance);
       }},
      {"its FCL distance", false,
       [&askers](Manager& m, Answer& answer) {
         for (Object& object : askers.outside) m.distance(&object, &answer, take_fcl_distance);
       }},
  };
}

void report(const std::string& world, std::size_t n, const std::vector<Operation>& operations,
            const std::vector<ManagerEntrant>& all, std::vector<Row>& rows) {
  fmt::print("\n{}, microseconds (times tandem's, 10th to 90th percentile)\n", world);
  for (const Operation& operation : operations) {
    fmt::print("  {:16}", operation.name);
    for (std::size_t who = 0; who < all.size(); ++who) {
      const Samples &time = operation.times[who], &ratio = operation.ratios[who];
      fmt::print("  {} {:.1f}", all[who].name, time.median() / 1000);
      if (who != 0) fmt::print(" ({:.2f}x, {:.2f}-{:.2f})", ratio.median(), ratio.quantile(0.1), ratio.quantile(0.9));
      Row row;
      row.bench = "fcl";
      row.workload = world + ": " + operation.name;
      row.contestant = all[who].name;
      row.n = n;
      row.time = time;
      row.hash = operation.answer.hash;
      row.more = {{"pairs", operation.answer.pairs}, {"ratio", ratio.median()}};
      rows.push_back(std::move(row));
    }
    fmt::print("  pairs {} hash {}\n", operation.answer.pairs, hex(operation.answer.hash));
  }
}

void race(std::size_t n, double share, int steps, const Settings& settings, std::vector<Row>& rows) {
  Objects objects(n, share);
  std::vector<ManagerEntrant> all = entrants(n, settings);
  for (ManagerEntrant& entrant : all) {
    entrant.manager->registerObjects(objects.all());
    entrant.manager->setup();
  }
  constexpr int asked = 100;  // query objects a step
  Askers askers;
  std::vector<Operation> operations = all_operations(askers);
  for (Operation& operation : operations) {
    operation.times.resize(all.size());
    operation.ratios.resize(all.size());
  }
  for (int step = 0; step < steps; ++step) {
    askers = {};
    for (int i = 0; i < asked; ++i) {
      askers.inside.push_back(objects.stranger(0));
      askers.outside.push_back(objects.stranger(1.1));
    }
    for (Operation& operation : operations) {
      if (operation.after_a_move) objects.move();
      run_in_turn(operation, all, step);
    }
  }
  const std::string world = fmt::format("{} of {} move", share == 1 ? "all" : fmt::format("{:g} %", 100 * share), n);
  report(world, n, operations, all, rows);
}

}  // namespace

std::vector<Row> fcl_bench(const Settings& settings) {
  std::vector<std::size_t> sizes = settings.sizes;
  if (sizes.empty())
    sizes = settings.quick ? std::vector<std::size_t>{300, 3000} : std::vector<std::size_t>{300, 3000, 30000};
  std::vector<Row> rows;
  for (const std::size_t n : sizes)
    for (const double share : {1.0, 0.1}) {
      const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 10 : 60;
      race(n, share, steps, settings, rows);
    }
  return rows;
}

}  // namespace tandem::bench
