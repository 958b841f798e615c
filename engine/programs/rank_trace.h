// The timeline of a run on ranks: one file, in which each rank is a process.
#pragma once
#include <mpi.h>

#include <string>

#include "formats/output_file.h"
#include "tandem/flowgraph/timeline.h"
#include "tandem/mpi/pipeline.h"

namespace tandem {

/// Records the steps of all ranks, up to the number of slices that a viewer opens easily. All calls are collective.
class RankTrace {
 public:
  /// Begins to count time on all ranks, synchronised by a barrier.
  RankTrace(MPI_Comm communicator, mpi::Pipeline& pipeline);

  /// Records a step, after it.
  void record(mpi::Pipeline& pipeline);
  std::uint64_t steps() const { return steps_; }
  bool is_full() const { return full_; }
  /// Writes the file; `file`: that of rank 0, null on the others; compressed if the path ends in .gz.
  void write(OutputFile* file, const std::string& path) const;

 private:
  MPI_Comm communicator_;
  int rank_ = 0, ranks_ = 1;
  Timeline timeline_;
  std::uint64_t steps_ = 0;
  bool full_ = false;
};

}  // namespace tandem
