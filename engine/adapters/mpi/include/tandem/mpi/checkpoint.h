#pragma once
#include <string>

#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// A pipeline's bodies in one file, written and read by all ranks at once (MPI-IO), of which any other number of ranks
/// goes on. Shapes are not in it: whoever reads adds the same ones first. Bytes are those of the machine.
class Checkpoint {
 public:
  /// Collective. What holds after the last step; changes since are not in it. The file gets its name when it is
  /// complete. Throws StepError on all ranks, with the same text.
  static void write(const Pipeline& pipeline, const std::string& path);
  /// Collective. Adds the bodies, which take hold with the next step, to a pipeline that has none, and goes on counting
  /// steps, from the one returned. Throws on all ranks, with the same text, and adds none: std::invalid_argument for a
  /// file that is cut off, altered, none of these, or of other shapes; StepError if it cannot be read.
  static std::uint64_t read(Pipeline& pipeline, const std::string& path);
};

}  // namespace tandem::mpi
