// How many grains fit in a machine's memory, on ranks: each rank makes its own share of a bed of touching spheres of 64
// sizes, and no rank ever has more of it than that and copies. The scenes of tandem-mpi are made whole on every rank.
//
//   mpirun -n 2 ranks_memory [GRAINS [STEPS]]
//
// Prints what each rank holds (its largest resident set), times and the hash, which is that of any number of ranks.
#include <mpi.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "tandem/mpi/pipeline.h"

namespace {

using namespace tandem;

constexpr int kinds = 64, layers = 12, wide = 100;
constexpr double smallest = 0.3, largest = 0.6, spacing = 0.9;
/// Grains added before a step takes them in: a requested change is kept until then.
constexpr std::uint64_t portion = 500'000;

/// A grain of the whole bed, whichever rank makes it: rows of `wide` times `layers`, one after the other along x.
BodyOptions grain(std::uint64_t id, const std::vector<ShapeId>& shapes) {
  std::minstd_rand random(static_cast<std::uint32_t>(id * 2654435761u >> 8) + 1);
  random.discard(3);
  const std::uint64_t row = id / (wide * layers), in_row = id % (wide * layers);
  const double shift = std::uniform_real_distribution<double>(0, smallest)(random);
  BodyOptions body;
  body.shape = shapes[random() % kinds];
  body.pose.translation =
      spacing * Vec3(static_cast<double>(row), static_cast<double>(in_row % wide), static_cast<double>(in_row / wide)) +
      Vec3(shift, 0, 0);
  return body;
}

double gigabytes() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return static_cast<double>(use.ru_maxrss) / (1 << 20);
}

void run(std::uint64_t grains, int steps) {
  mpi::Options options;
  options.rank = {.executor = ExecutorKind::sequential, .threads = 1, .answer = {.contact_hash = true}};
  mpi::Pipeline pipeline(MPI_COMM_WORLD, options);
  std::vector<ShapeId> shapes;
  for (int k = 0; k < kinds; ++k)
    shapes.push_back(pipeline.add_shape(Sphere{smallest + (largest - smallest) * k / (kinds - 1)}));
  const auto ranks = static_cast<std::uint64_t>(pipeline.ranks()), rank = static_cast<std::uint64_t>(pipeline.rank());
  const std::uint64_t end = grains * (rank + 1) / ranks, all = grains / ranks + 1;
  std::uint64_t next = grains * rank / ranks;
  for (std::uint64_t added = 0; added < all; added += portion) {
    for (const std::uint64_t until = std::min(end, next + portion); next < until; ++next)
      pipeline.add_body(next, grain(next, shapes));
    if (added + portion < all) pipeline.step();
  }
  for (int step = 0; step < steps; ++step) {
    const auto begin = std::chrono::steady_clock::now();
    const mpi::Report report = pipeline.step();
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    if (rank == 0)
      std::printf(
          "step %d: %llu grains, %llu candidates, %llu touch, %llu copies, hash %016llx; %.0f ms, CPU of the "
          "slowest rank: detection %.0f ms, exchange %.1f ms\n",
          step, static_cast<unsigned long long>(report.bodies), static_cast<unsigned long long>(report.pairs),
          static_cast<unsigned long long>(report.colliding_pairs), static_cast<unsigned long long>(report.copies),
          static_cast<unsigned long long>(report.contact_hash), ms, report.slowest_detect_cpu_ms,
          report.slowest_exchange_cpu_ms);
  }
  const double own = gigabytes();
  std::vector<double> held(static_cast<std::size_t>(ranks));
  MPI_Gather(&own, 1, MPI_DOUBLE, held.data(), 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  double sum = 0;
  for (const double one : held) sum += one;
  if (rank == 0)
    std::printf("%llu ranks: %.2f GiB in all, %.0f bytes a grain\n", static_cast<unsigned long long>(ranks), sum,
                sum * (1 << 30) / static_cast<double>(grains));
}

}  // namespace

int main(int count, char** arguments) {
  int provided = 0;
  MPI_Init_thread(&count, &arguments, MPI_THREAD_FUNNELED, &provided);
  run(count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 10'000'000, count > 2 ? std::atoi(arguments[2]) : 3);
  MPI_Finalize();
}
