// Bodies on ranks: owners, copies, changes.
#include "adapters/mpi/bodies.h"

#include <array>

#include "world.h"

using namespace tandem;
using mpi::GlobalId;

TEST_CASE("messages that were let go of before they were sent are written anew") {
  if (world::ranks() == 1) return;
  mpi::Communicator communicator(MPI_COMM_WORLD, 60);
  mpi::Regions regions(communicator);
  mpi::Bodies bodies(communicator, regions, 0.01, 1);
  const ShapeId ball = bodies.add_shape(Sphere{0.4}, {});
  const auto place = [](GlobalId id, int step) {
    return Vec3(0.7 * static_cast<double>(id % 12), 0.7 * static_cast<double>(id / 12), 0.004 * step);
  };
  std::vector<Vec3> points;
  for (GlobalId id = 0; id < 144; ++id) {
    if (static_cast<int>(id) % world::ranks() != world::rank()) continue;
    BodyOptions options;
    options.shape = ball;
    options.pose.translation = place(id, 0);
    bodies.apply({mpi::Change::Kind::add, 0, bodies.checked(id, options)});
    points.push_back(place(id, 0));
  }
  regions.cut(points, std::vector<float>(points.size(), 1));
  bodies.exchange(true, false);
  for (int step = 1; step <= 6; ++step) {
    CAPTURE(step);
    const Scene& scene = bodies.scene();
    for (std::uint32_t i = 0; i < scene.indices(); ++i)
      if (scene.alive(i) && bodies.owns(i))
        bodies.move(i, {Mat3::Identity(), place(bodies.id(i), step)}, Vec3::Zero(), Vec3::Zero());
    bodies.check_ahead();
    if (step % 2 == 0) bodies.check_again();
    bodies.exchange(false, false);
    std::size_t copies = 0;
    bool right = true;
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      if (!scene.alive(i)) continue;
      right = right && scene.poses()[i].translation == place(bodies.id(i), step);
      copies += bodies.owns(i) ? 0 : 1;
    }
    CHECK(right);
    CHECK(copies > 0);
  }
}

TEST_CASE("what changes of a body reaches its copies: density, sensor and continuous, too") {
  if (world::ranks() == 1) return;
  mpi::Pipeline pipeline(MPI_COMM_WORLD, world::options(1, 0.01));
  const ShapeId plate = pipeline.add_shape(Box{Vec3(40, 40, 1)}), ball = pipeline.add_shape(Sphere{0.5});
  if (world::rank() == 0) {
    pipeline.add_body(1, {.shape = plate, .is_static = true});  // on all ranks
    pipeline.add_body(2, {.shape = plate, .pose = Pose::at(0, 0, 3)});
    for (GlobalId id = 10; id < 50; ++id)
      pipeline.add_body(
          id, {.shape = ball, .pose = Pose::at(static_cast<double>(id) - 30, static_cast<double>(id % 7) - 3, 8)});
  }
  pipeline.step();
  int change = 0;
  const auto seen = [&](const auto& holds) {
    std::array<int, 2> here{};
    const Scene& scene = pipeline.scene();
    if (pipeline.has(2)) {
      const std::uint32_t index = pipeline.local(2).index();
      here = {1, holds(scene, index) ? 1 : 0};
    }
    MPI_Allreduce(MPI_IN_PLACE, here.data(), 2, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    CAPTURE(++change);
    CHECK(here[0] > 1);
    CHECK(here[1] == here[0]);
  };
  const auto by_last = [&](const auto& what) {
    if (world::rank() == world::ranks() - 1) what();
    pipeline.step();
  };
  by_last([&] { pipeline.set_density(2, 77); });
  seen([](const Scene& scene, std::uint32_t i) { return scene.densities()[i] == 77; });
  by_last([&] { pipeline.set_sensor(2, true); });
  seen([](const Scene& scene, std::uint32_t i) { return scene.is_sensor()[i] == 1; });
  by_last([&] { pipeline.set_continuous(2, true); });
  seen([](const Scene& scene, std::uint32_t i) { return scene.continuous()[i] == 1; });
  by_last([&] { pipeline.set_sensor(2, false); });
  seen([](const Scene& scene, std::uint32_t i) { return scene.is_sensor()[i] == 0 && scene.densities()[i] == 77; });
}

TEST_CASE("a message that is cut off is found out") {
  mpi::Message message;
  message.put(std::uint32_t{17});
  message.put(std::uint16_t{4});
  CHECK(message.take<std::uint32_t>() == 17);
  CHECK_THROWS_AS(message.take<std::uint32_t>(), std::out_of_range);
  CHECK(message.take<std::uint16_t>() == 4);
  CHECK(message.done());
  CHECK_THROWS_AS(message.take<std::uint8_t>(), std::out_of_range);
}
