// The timeline of a run on ranks: one file with a process a rank.
#pragma once
#include <mpi.h>

#include <string>

#include "formats/output_file.h"
#include "tandem/flowgraph/timeline.h"
#include "tandem/mpi/pipeline.h"

namespace tandem {

/// Records the steps of all ranks until they have as many slices as a viewer opens with ease. All calls are collective.
class RankTrace {
 public:
  /// All ranks begin to count time here: a barrier is what sets their clocks.
  RankTrace(MPI_Comm communicator, mpi::Pipeline& pipeline);

  /// After each step.
  void record(mpi::Pipeline& pipeline);
  std::uint64_t steps() const { return steps_; }
  bool is_full() const { return full_; }
  /// `file` of rank 0, null on the others; compressed if the path ends in .gz.
  void write(OutputFile* file, const std::string& path) const;

 private:
  MPI_Comm communicator_;
  int rank_ = 0, ranks_ = 1;
  Timeline timeline_;
  std::uint64_t steps_ = 0;
  bool full_ = false;
};

}  // namespace tandem
