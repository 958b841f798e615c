// Runs the tests on all ranks: a failure on one is a failure.
#define CATCH_CONFIG_RUNNER
#include <mpi.h>
#include <oneapi/tbb/global_control.h>

#include <iostream>
#include <sstream>

#include "catch.h"
#if __has_include(<catch2/catch_session.hpp>)
#include <catch2/catch_session.hpp>
#endif

int main(int argc, char* argv[]) {
  int provided = 0, rank = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  int failed = 0;
  {
    // A small machine limits oneTBB to its number of cores; without this the cases of more threads would test nothing
    // new.
    const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
    std::ostringstream quiet;
    std::streambuf* const out = std::cout.rdbuf();
    if (rank != 0) std::cout.rdbuf(quiet.rdbuf());
    failed = Catch::Session().run(argc, argv);
    std::cout.rdbuf(out);
    if (rank != 0 && failed != 0) std::cout << "rank " << rank << ":\n" << quiet.str() << std::flush;
  }
  int any = 0;
  MPI_Allreduce(&failed, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return any != 0 ? 1 : 0;
}
