// Regions of ranks.
#include "adapters/mpi/regions.h"

#include "world.h"

using namespace tandem;

TEST_CASE("every place is one rank's, and a box reaches into the regions of all its places") {
  if (world::ranks() == 1) return;  // Zoltan is not used
  mpi::Communicator communicator(MPI_COMM_WORLD, 60);
  mpi::Regions regions(communicator);
  std::mt19937_64 random(7);  // the same on all ranks
  const auto number = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  std::uint64_t reached = 0, insides = 0;
  for (int cut = 0; cut < 60; ++cut) {
    CAPTURE(cut);
    // Few points or many, on a grid so that they share coordinates, some or nearly all with weight 0.
    const std::size_t count = 1 + random() % (cut % 3 == 0 ? 3 : 60);
    const bool on_grid = cut % 2 == 0;
    std::vector<Vec3> points;
    std::vector<float> weights;
    for (std::size_t i = 0; i < count; ++i) {
      Vec3 point{number(-4, 4), number(-4, 4), number(-1, 1)};
      if (on_grid) point = point.array().round();
      const auto weight = static_cast<float>(cut % 5 == 0 ? (random() % 8 == 0 ? 1000 : 0) : number(0, 1));
      if (static_cast<int>(random() % static_cast<std::uint64_t>(world::ranks())) != world::rank()) continue;
      points.push_back(point);
      weights.push_back(weight);
    }
    if (cut % 7 == 6)
      regions.take_back();
    else
      REQUIRE(regions.cut(points, weights));
    int wrong = 0;
    std::vector<int> holders(400, 0), owners(400, 0);
    for (std::size_t i = 0; i < holders.size(); ++i) {
      std::array<double, 3> place{number(-5, 5), number(-5, 5), number(-2, 2)};
      if (i % 2 == 0)
        for (double& x : place) x = std::round(2 * x) / 2;
      mpi::FloatBox box;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lo[axis] = static_cast<float>(place[axis]) - static_cast<float>(number(0, 1));
        box.hi[axis] = static_cast<float>(place[axis]) + static_cast<float>(number(0, 1));
      }
      holders[i] = regions.holds(place) ? 1 : 0;
      owners[i] = regions.owner(place);
      wrong += (owners[i] == world::rank()) != (holders[i] == 1);
      const auto ranks = regions.reached(box);
      reached += ranks.size();
      wrong += std::find(ranks.begin(), ranks.end(), owners[i]) == ranks.end();
      insides += regions.holds(box) ? 1 : 0;
      wrong += regions.holds(box) && (ranks.size() != 1 || ranks[0] != world::rank());
    }
    CHECK(wrong == 0);
    MPI_Allreduce(MPI_IN_PLACE, holders.data(), 400, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    CHECK(std::count(holders.begin(), holders.end(), 1) == 400);
  }
  CHECK(reached > 60 * 400);
  // Every rank recognises boxes that are entirely its own, without a search in Zoltan's tree.
  CHECK(insides > 100);
}
