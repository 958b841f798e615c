// Checkpoints: all bodies in one file, for any number of ranks.
#pragma once
#include <string>

#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// A pipeline's bodies in one file, written and read by all ranks at once (MPI-IO), from which any number of ranks can
/// continue. Shapes are not in it: the reader must first add the same ones. The byte order is the machine's.
class Checkpoint {
 public:
  /// Collective. Writes the state after the last step, without changes since. The file gets its name when it is
  /// complete. Throws StepError on all ranks, with the same text.
  static void write(const Pipeline& pipeline, const std::string& path);
  /// Collective. Adds the bodies to a pipeline without bodies, from the next step on, and continues counting steps from
  /// the one returned. Throws on all ranks, with the same text, and adds none: std::invalid_argument for a file that is
  /// truncated, altered, not a checkpoint, or of other shapes; StepError if it cannot be read.
  static std::uint64_t read(Pipeline& pipeline, const std::string& path);
};

}  // namespace tandem::mpi
