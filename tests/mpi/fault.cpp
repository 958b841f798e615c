// A rank that fails, in one of several ways, in the middle of a run: fault HOW, on 3 ranks. The job must end at once.
#include <mpi.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "tandem/mpi/pipeline.h"

using namespace tandem;

int main(int count, char* arguments[]) {
  MPI_Init(&count, &arguments);
  const std::string how = count > 1 ? arguments[1] : "";
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  std::uint64_t step = 0;
  mpi::Options options;
  options.patience = how == "hang" ? 2 : 0;
  options.rank.executor = ExecutorKind::sequential;
  options.rank.predicate = [&](std::span<Pair> pairs) -> std::size_t {
    if (step < 3 || rank != 1) return pairs.size();
    if (how == "throw") throw std::runtime_error("no more pairs");
    if (how == "number") throw 7;
    if (how == "memory") throw std::bad_alloc();
    if (how == "kill") std::raise(SIGKILL);
    if (how == "hang") ::sleep(600);
    return pairs.size();
  };
  mpi::Pipeline pipeline(MPI_COMM_WORLD, options);
  const ShapeId sphere = pipeline.add_shape(Shape(Sphere{0.6}));
  if (rank == 0)
    for (mpi::GlobalId i = 0; i < 60; ++i)
      pipeline.add_body(i, {.shape = sphere, .pose = Pose::at(static_cast<double>(i), 0, 0)});
  try {
    for (; step < 1000; ++step) pipeline.step();
  } catch (const mpi::StepError& error) {
    if (rank == 0) std::fprintf(stderr, "ended by %s\n", error.what());
    MPI_Finalize();
    return 1;
  }
  MPI_Finalize();
  return 0;  // not reached
}
