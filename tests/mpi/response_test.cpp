// The response on ranks, compared with one machine.
#include "tandem/mpi/response.h"

#include <array>
#include <bit>

#include "tandem/engine/contact_memory.h"
#include "tandem/mpi/contact_events.h"
#include "world.h"

using namespace tandem;
using mpi::GlobalId;
using mpi::IdPair;

namespace {

std::uint64_t hash_of(GlobalId id, const Scene& scene, std::uint32_t i) {
  std::uint64_t hash = id + 1;
  const auto add = [&](double x) { hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15u; };
  const Pose& pose = scene.poses()[i];
  for (Eigen::Index k = 0; k < 9; ++k) add(pose.rotation.data()[k]);
  for (const Vec3* v : {&pose.translation, &scene.velocities()[i], &scene.angular_velocities()[i]})
    for (Eigen::Index k = 0; k < 3; ++k) add((*v)[k]);
  return hash ^ hash >> 31;
}

/// A hash over all bodies of their owners' data.
std::uint64_t hash_of_motion(const mpi::Pipeline& pipeline) {
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < pipeline.scene().indices(); ++i)
    if (pipeline.owns(i)) sum += hash_of(pipeline.id(i), pipeline.scene(), i);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
  return sum;
}

/// The pairs of all ranks, on all of them.
std::vector<IdPair> all_of(std::span<const IdPair> own) {
  const int count = static_cast<int>(2 * own.size());
  std::vector<int> counts(static_cast<std::size_t>(world::ranks())), places(counts.size());
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
  int total = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) places[i] = total, total += counts[i];
  std::vector<IdPair> all(static_cast<std::size_t>(total / 2));
  MPI_Allgatherv(own.data(), count, MPI_UINT64_T, all.data(), counts.data(), places.data(), MPI_UINT64_T,
                 MPI_COMM_WORLD);
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<IdPair> ids_of(std::span<const BodyPair> pairs) {
  std::vector<IdPair> out;
  for (const BodyPair& pair : pairs) out.push_back({pair.a.index(), pair.b.index()});
  return out;
}

}  // namespace

TEST_CASE("with the response of all ranks the motion is that of one, and so are the events") {
  for (const std::string_view name : {"cubes-on-plane", "spheres-on-plane"}) {
    CAPTURE(name);
    Scene scene = make_builtin_scene(name, 30);
    const double margin = recommended_margin(scene);
    tandem::Pipeline alone({.executor = ExecutorKind::sequential, .threads = 1, .answer = {.margin = margin}});
    tandem::Response response({.threads = 1});
    tandem::ContactEvents events;
    mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(1, margin));
    world::add_all(pipeline, scene);
    pipeline.set_dt(scene.dt);
    pipeline.set_gravity(scene.gravity);
    mpi::Response together(pipeline, {.threads = 1});
    mpi::ContactEvents told;
    const auto ids = world::all_indices(scene);
    std::size_t began = 0, ended = 0;
    for (int step = 0; step < 24; ++step) {
      CAPTURE(step);
      alone.step(scene);
      events.update(scene, alone.contacts());
      if (step % 5 == 4) pipeline.rebalance();
      const mpi::Report report = pipeline.step();
      CHECK(report.contact_hash == mpi::hash(world::gathered(alone.contacts(), ids)));
      told.update(pipeline);
      CHECK(all_of(told.began()) == ids_of(events.began()));
      CHECK(all_of(told.ended()) == ids_of(events.ended()));
      CHECK(all_of(told.touching()) == ids_of(events.touching()));
      began += events.began().size();
      ended += events.ended().size();
      const ResponseReport moved = response.step(scene, alone.contacts());
      const mpi::RankResponseReport all_moved = together.step();
      CHECK(all_moved.response.kinetic_energy == moved.kinetic_energy);
      std::uint64_t expected = 0;
      for (std::uint32_t i = 0; i < scene.indices(); ++i) expected += hash_of(i, scene, i);
      CHECK(hash_of_motion(pipeline) == expected);
      if (step == 20) {  // a change by the host
        scene.set_pose(scene.id(5), Pose::at(0, 0, 4));
        if (world::rank() == world::ranks() - 1) pipeline.set_pose(5, Pose::at(0, 0, 4));
      }
    }
    CHECK(began > 10);
    CHECK(ended > 0);
  }
}

TEST_CASE("with the response of all ranks a body with more pairs than colours moves as on one") {
  Scene scene;
  const ShapeId ground = scene.add_shape(HalfSpace{Vec3::UnitZ(), 0}), ball = scene.add_shape(Sphere{0.25}),
                plate = scene.add_shape(Box{Vec3(6.4, 6.4, 0.1)});
  scene.add_body({.shape = ground, .is_static = true});
  const auto add_balls = [&](double height) {
    for (int i = 0; i < 144; ++i)
      scene.add_body({.shape = ball, .pose = Pose::at(0.55 * (i % 12), 0.55 * (i / 12), height + 0.0003 * (i % 7))});
  };
  add_balls(0.249);
  scene.add_body({.shape = plate, .pose = Pose::at(3, 3, 0.549), .density = 300});
  add_balls(0.849);
  for (const int threads : {1, 2}) {
    if (world::ranks() > 4 && threads > 1) continue;  // a colour has too few pairs on a rank to be shared by threads
    Scene one = scene;
    tandem::Pipeline alone({.executor = ExecutorKind::sequential, .threads = 1, .answer = {.margin = 0.01}});
    tandem::Response response({.threads = 1});
    mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(threads, 0.01));
    world::add_all(pipeline, scene);
    mpi::Response together(pipeline, {.threads = threads});
    for (int step = 0; step < 4; ++step) {
      CAPTURE(threads, step);
      pipeline.rebalance();
      alone.step(one);
      CHECK(alone.contacts().contacts.size() > 400);
      CHECK(pipeline.step().contact_hash == mpi::hash(world::gathered(alone.contacts(), world::all_indices(one))));
      const mpi::RankResponseReport moved = together.step();
      CHECK(moved.response.kinetic_energy == response.step(one, alone.contacts()).kinetic_energy);
      std::uint64_t expected = 0;
      for (std::uint32_t i = 0; i < one.indices(); ++i) expected += hash_of(i, one, i);
      CHECK(hash_of_motion(pipeline) == expected);
      if (world::ranks() > 1) CHECK(moved.bytes_sent > 0);
    }
  }
}

TEST_CASE("a response of a scene to which bodies come and from which they go: the same motion on any number of ranks") {
  const double keep = GENERATE(0.0, 0.02);
  CAPTURE(keep);
  // One rank in a communicator of its own, beside all.
  mpi::Options options = world::options(1, 0.02);
  options.rank.answer.keep_contacts = keep;
  mpi::Pipeline all(MPI_COMM_WORLD, options), alone(MPI_COMM_SELF, options);
  mpi::Response together(all, {.threads = 1}), single(alone, {.threads = 1});
  std::vector<ShapeId> shapes;
  for (const Shape& shape : {Shape(HalfSpace{Vec3::UnitZ(), 0}), Shape(Sphere{0.4}), Shape(Box{Vec3(1, 0.5, 0.7)})}) {
    shapes.push_back(all.add_shape(shape));
    alone.add_shape(shape);
  }
  std::mt19937_64 random(5);
  std::vector<GlobalId> ids;
  std::size_t stops = 0;
  const auto turn = [&](const auto& what) {
    what(alone);
    if (static_cast<int>(random() % static_cast<std::uint64_t>(world::ranks())) == world::rank()) what(all);
  };
  turn([&](mpi::Pipeline& p) { p.add_body(1u << 20, {.shape = shapes[0], .is_static = true}); });
  for (int step = 0; step < 24; ++step) {
    CAPTURE(step);
    for (int k = 0; k < 2; ++k) {
      const GlobalId id = random() >> 40;
      if (std::find(ids.begin(), ids.end(), id) != ids.end()) continue;
      ids.push_back(id);
      const auto number = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
      const Pose pose{Mat3::Identity(), {number(-2, 2), number(-1, 1), number(0.5, 2)}};
      const ShapeId shape = shapes[1 + random() % 2];
      const bool is_fast = random() % 3 == 0, is_sensor = random() % 8 == 0;
      const Vec3 velocity = is_fast ? Vec3{number(-200, 200), number(-20, 20), number(-90, 0)} : Vec3(Vec3::Zero());
      turn([&](mpi::Pipeline& p) {
        p.add_body(id, {.shape = shape,
                        .pose = pose,
                        .velocity = velocity,
                        .is_sensor = is_sensor,
                        .continuous = is_fast || is_sensor});
      });
    }
    if (ids.size() > 6) {
      const GlobalId id = ids[random() % 4];
      const auto what = random() % 3;
      const bool flag = random() % 3 == 0;
      const double density = 200 + static_cast<double>(random() % 5000);
      turn([&](mpi::Pipeline& p) {
        if (what == 0) p.set_density(id, density);
        if (what == 1) p.set_sensor(id, flag);
        if (what == 2) p.set_continuous(id, !flag);
      });
    }
    if (ids.size() > 12) {
      const std::size_t at = 4 + random() % (ids.size() - 6);
      const GlobalId id = ids[at];
      ids.erase(ids.begin() + static_cast<std::ptrdiff_t>(at));
      turn([&](mpi::Pipeline& p) { p.remove_body(id); });
    }
    const mpi::Report report = all.step(), expected = alone.step();
    CHECK(report.contact_hash == expected.contact_hash);
    if (step == 17) {  // without a response in between: a body is removed, and another one takes its id and place
      const GlobalId id = ids[0];
      turn([&](mpi::Pipeline& p) { p.remove_body(id); });
      all.step();
      alone.step();
      turn([&](mpi::Pipeline& p) { p.add_body(id, {.shape = shapes[2], .pose = Pose::at(0.3, 0.2, 0.4)}); });
      all.step();
      alone.step();
    }
    if (step % 6 == 5)  // a change by the host that only owners know of
      for (mpi::Pipeline* p : {&all, &alone})
        for (std::uint32_t i = 0; i < p->scene().indices(); ++i)
          if (p->owns(i) && p->scene().is_static()[i] == 0)
            p->move(i, p->scene().poses()[i], p->scene().velocities()[i] + Vec3(0.5, 0, 0.1),
                    p->scene().angular_velocities()[i]);
    const ResponseReport moved = single.step().response, all_moved = together.step().response;
    CHECK(all_moved.kinetic_energy == moved.kinetic_energy);
    CHECK(all_moved.stops == moved.stops);
    stops += moved.stops;
    std::uint64_t motion = 0;
    for (std::uint32_t i = 0; i < alone.scene().indices(); ++i)
      if (alone.owns(i)) motion += hash_of(alone.id(i), alone.scene(), i);
    CHECK(hash_of_motion(all) == motion);
  }
  CHECK(stops > 10);
}

namespace {

/// Fast continuous bodies among thin plates, some of which carry them along, across all regions: bullets hit plates,
/// each other and heaps of balls.
Scene shooting_range(std::mt19937_64& random) {
  const auto number = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  Scene scene;
  const ShapeId ground = scene.add_shape(HalfSpace{Vec3::UnitZ(), 0}), bullet = scene.add_shape(Sphere{0.05}),
                stick = scene.add_shape(Capsule{0.04, 0.3}), plate = scene.add_shape(Box{Vec3(0.02, 2, 2)}),
                ball = scene.add_shape(Sphere{0.25}), truck = scene.add_shape(Box{Vec3(2, 1, 0.5)});
  scene.add_body({.shape = ground, .is_static = true});
  for (int i = 0; i < 9; ++i)
    scene.add_body({.shape = plate,
                    .pose = Pose::at(2.0 * i, number(-1, 1), 1),
                    .velocity = Vec3(i % 3 == 0 ? number(-20, 20) : 0, 0, 0),
                    .is_static = true});
  for (int i = 0; i < 60; ++i)
    scene.add_body({.shape = ball, .pose = Pose::at(0.55 * (i % 20) + 0.2, 0.55 * (i / 20) - 0.6, 0.249)});
  for (int i = 0; i < 40; ++i)
    scene.add_body({.shape = i % 3 == 0 ? stick : bullet,
                    .pose = Pose{Mat3::Identity(), {number(-2, 18), number(-2, 2), number(0.3, 2.5)}},
                    .velocity = Vec3{number(-300, 300), number(-30, 30), number(-60, 20)},
                    .angular_velocity = Vec3{number(-20, 20), number(-20, 20), number(-20, 20)},
                    .density = 500 + 100.0 * (i % 7),
                    .is_sensor = i % 13 == 5,
                    .continuous = true});
  for (int i = 0; i < 6; ++i)
    scene.add_body({.shape = truck,
                    .pose = Pose{Mat3::Identity(), {number(-4, 20), number(-2, 2), 1.5 + i}},
                    .velocity = Vec3{number(-80, 80), 0, number(-20, 0)},
                    .continuous = i % 2 == 0});
  return scene;
}

}  // namespace

TEST_CASE("continuous bodies are stopped at their first touches on any number of ranks as on one") {
  std::mt19937_64 random(17);
  for (const double margin : {0.0, 0.02})
    for (const bool keeps : {false, true}) {
      CAPTURE(margin, keeps);
      Scene scene = shooting_range(random);
      const bool filters = margin == 0 && !keeps;
      const auto allows = [](GlobalId a, GlobalId b) { return (a + b) % 5 != 0; };
      const auto drops = [&](std::span<Pair> pairs) {
        return static_cast<std::size_t>(
            std::remove_if(pairs.begin(), pairs.end(), [&](Pair pair) { return !allows(pair.a, pair.b); }) -
            pairs.begin());
      };
      const double keep = keeps ? 0.02 : 0;
      tandem::Pipeline alone(
          {.executor = ExecutorKind::sequential, .threads = 1, .answer = {.margin = margin, .keep_contacts = keep}});
      tandem::Response response({.predicate = filters ? PairPredicate(drops) : PairPredicate{}, .threads = 1});
      mpi::Options options = world::options(keeps ? 2 : 1, margin);
      options.rank.answer.keep_contacts = keep;
      mpi::Pipeline pipeline(MPI_COMM_WORLD, options);
      world::add_all(pipeline, scene);
      pipeline.set_dt(scene.dt);
      mpi::Response together(pipeline, {.threads = 1}, filters ? mpi::PairOfIds(allows) : mpi::PairOfIds{});
      std::size_t stops = 0;
      for (int step = 0; step < 16; ++step) {
        CAPTURE(step);
        if (step % 3 == 1) pipeline.rebalance();
        alone.step(scene);
        const mpi::Report report = pipeline.step();
        CHECK(report.contact_hash == mpi::hash(world::gathered(alone.contacts(), world::all_indices(scene))));
        if (step % 4 == 3)  // a change by the host, after detection: some keep their initial speed, and some change
          for (std::uint32_t i = 70; i < 90; ++i) {
            const Vec3 velocity(i % 2 == 0 ? 250 : -250, 0.1 * i, 3);
            scene.move(i, scene.poses()[i], velocity, scene.angular_velocities()[i]);
            if (pipeline.has(i) && pipeline.owns(pipeline.local(i).index()))
              pipeline.move(pipeline.local(i).index(), scene.poses()[i], velocity, scene.angular_velocities()[i]);
          }
        if (step == 9) {
          scene.set_continuous(scene.id(75), false);
          scene.set_density(scene.id(76), 9000);
          scene.set_sensor(scene.id(77), true);
          if (world::rank() == world::ranks() - 1) {
            pipeline.set_continuous(75, false);
            pipeline.set_density(76, 9000);
            pipeline.set_sensor(77, true);
          }
          alone.step(scene);
          pipeline.step();
        }
        const ResponseReport moved = response.step(scene, alone.contacts());
        const mpi::RankResponseReport all_moved = together.step();
        CHECK(all_moved.response.stops == moved.stops);
        CHECK(all_moved.response.kinetic_energy == moved.kinetic_energy);
        std::uint64_t expected = 0;
        for (std::uint32_t i = 0; i < scene.indices(); ++i) expected += hash_of(i, scene, i);
        CHECK(hash_of_motion(pipeline) == expected);
        stops += moved.stops;
      }
      CHECK(stops > 50);
    }
  mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(1, 0));
  CHECK_THROWS_AS(mpi::Response(pipeline, {.predicate = [](std::span<Pair> pairs) { return pairs.size(); }}),
                  std::invalid_argument);
}

TEST_CASE("continuous bodies at rest are taken along by what comes from other ranks, and take others along") {
  // Fast bodies that are not continuous move along lanes, in which continuous bodies at rest wait. Those carried along
  // reach out of the lane and meet others; one is hit by two at the same time.
  Scene scene;
  scene.gravity = Vec3::Zero();
  const ShapeId ball = scene.add_shape(Sphere{0.25}), truck = scene.add_shape(Box{Vec3(1, 1, 1)});
  const auto lane = [&](double y, double first) {
    for (int k = 0; k < 12; ++k) {
      const double side = k % 2 == 0 ? 1 : -1;
      scene.add_body({.shape = ball, .pose = Pose::at(10 * k, y + 0.6 * side, 0), .continuous = true});
      scene.add_body({.shape = ball, .pose = Pose::at(10 * k + 3, y + 0.85 * side, 0), .continuous = true});
      scene.add_body({.shape = ball, .pose = Pose::at(10 * k + 5, y + 1.1 * side, 0.1), .continuous = true});
    }
    scene.add_body({.shape = truck, .pose = Pose::at(first, y, 0), .velocity = Vec3(480, 0, 0)});
  };
  for (int k = 0; k < 6; ++k) lane(6.0 * k, -2 - 1.4 * k);
  for (int k = 0; k < 4; ++k) {
    const double at = -8.0 * (k + 1);
    const bool first = k % 2 == 0;
    scene.add_body({.shape = ball, .pose = Pose::at(at, at, 0), .continuous = true});
    for (const bool along : {first, !first})
      scene.add_body({.shape = truck,
                      .pose = Pose::at(at - (along ? 4 : 0), at - (along ? 0 : 4), 0),
                      .velocity = Vec3(along ? 400 : 0, along ? 0 : 400, 0)});
  }
  tandem::Pipeline alone({.executor = ExecutorKind::sequential, .threads = 1});
  tandem::Response response({.threads = 1});
  mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(1, 0));
  world::add_all(pipeline, scene);
  pipeline.set_gravity(scene.gravity);
  pipeline.set_dt(scene.dt);
  mpi::Response together(pipeline, {.threads = 1});
  std::size_t stops = 0;
  for (int step = 0; step < 18; ++step) {
    CAPTURE(step);
    alone.step(scene);
    CHECK(pipeline.step().contact_hash == mpi::hash(world::gathered(alone.contacts(), world::all_indices(scene))));
    const ResponseReport moved = response.step(scene, alone.contacts());
    const mpi::RankResponseReport all_moved = together.step();
    CHECK(all_moved.response.stops == moved.stops);
    std::uint64_t expected = 0;
    for (std::uint32_t i = 0; i < scene.indices(); ++i) expected += hash_of(i, scene, i);
    CHECK(hash_of_motion(pipeline) == expected);
    stops += moved.stops;
  }
  CHECK(stops > 20);
}

TEST_CASE("a continuous body at rest is taken along by the one fast body, wherever that comes from") {
  Scene scene;
  scene.gravity = Vec3::Zero();
  const ShapeId ball = scene.add_shape(Sphere{0.25}), truck = scene.add_shape(Box{Vec3(1, 1, 1)});
  constexpr std::uint32_t balls = 24;
  for (std::uint32_t i = 0; i < balls; ++i)
    scene.add_body({.shape = ball, .pose = Pose::at(5.0 * i, 0.1, 0), .continuous = true});
  const BodyId fast = scene.add_body({.shape = truck, .pose = Pose::at(0, 100, 0)});
  tandem::Pipeline alone({.executor = ExecutorKind::sequential, .threads = 1});
  mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(1, 0));
  world::add_all(pipeline, scene);
  pipeline.set_gravity(scene.gravity);
  pipeline.set_dt(scene.dt);
  mpi::Response together(pipeline, {.threads = 1});
  const Vec3 none = Vec3::Zero();
  for (std::uint32_t step = 0; step < balls; ++step) {
    CAPTURE(step);
    const auto place = [&](std::uint32_t i, const Pose& pose, const Vec3& velocity) {
      scene.set_pose(scene.id(i), pose);
      scene.set_velocity(scene.id(i), velocity, none);
      if (world::rank() != 0) return;
      pipeline.set_pose(i, pose);
      pipeline.set_velocity(i, velocity, none);
    };
    if (step > 0) place(step - 1, Pose::at(5.0 * (step - 1), 0.1, 0), none);
    place(fast.index(), Pose::at(5.0 * step - 3, 0, 0), Vec3(300, 0, 0));
    alone.step(scene);
    pipeline.step();
    tandem::Response response({.threads = 1});  // without bodies that were stopped in the step before
    together.begin_anew();
    CHECK(response.step(scene, alone.contacts()).stops == 1);
    CHECK(together.step().response.stops == 1);
    CHECK(scene.poses()[step].translation.x() > 5.0 * step + 1);
    std::uint64_t expected = 0;
    for (std::uint32_t i = 0; i < scene.indices(); ++i) expected += hash_of(i, scene, i);
    CHECK(hash_of_motion(pipeline) == expected);
  }
}
