// A program that uses the installed library for MPI.
#include <tandem/mpi/pipeline.h>

#include <cstdio>

// A row of touching balls, added by all ranks in turn: every rank gets all contacts.
int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  bool right = false;
  {
    tandem::mpi::Pipeline pipeline(MPI_COMM_WORLD);
    const auto ball = pipeline.add_shape(tandem::Sphere{0.5});
    for (unsigned id = 0; id < 10; ++id)
      if (static_cast<int>(id) % pipeline.ranks() == pipeline.rank())
        pipeline.add_body(id, {.shape = ball, .pose = tandem::Pose::at(0.9 * id, 0, 0)});
    const tandem::mpi::Report report = pipeline.step();
    right = report.colliding_pairs == 9;
    if (pipeline.rank() == 0)
      std::printf("%d ranks: %llu pairs touch\n", pipeline.ranks(),
                  static_cast<unsigned long long>(report.colliding_pairs));
  }
  MPI_Finalize();
  return right ? 0 : 1;
}
