// The recording of a run on ranks: the same file as `tandem run --record` writes, byte for byte, written by all ranks
// in parallel.
#pragma once
#include <mpi.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tandem/engine/scene.h"
#include "tandem/mpi/pipeline.h"

namespace tandem {

/// Writes a recording. Ids are the scene's indices. Each rank writes the poses and contacts of a range of ids to its
/// place in the file (MPI-IO). The file gets its name when it is complete. All calls are collective; a failure on one
/// rank makes all throw mpi::StepError.
class RankRecord {
 public:
  /// `scene`: as before the first step.
  RankRecord(MPI_Comm communicator, const std::string& path, const Scene& scene);
  ~RankRecord();
  RankRecord(const RankRecord&) = delete;
  RankRecord& operator=(const RankRecord&) = delete;

  /// Writes a step of the pipeline, before anything moves. Returns its contact hash, mpi::Pipeline::list_hash.
  std::uint64_t step(const mpi::Pipeline& pipeline, std::uint64_t step);
  void commit();

 private:
  RankRecord(MPI_Comm communicator, const std::string& path);  // opens nothing yet
  bool can_write(const mpi::Pipeline& pipeline) const;
  std::string poses(const mpi::Pipeline& pipeline) const;
  void write(std::uint64_t place, const std::string& bytes);
  void require_all(const char* what);

  MPI_Comm communicator_ = MPI_COMM_NULL;
  int rank_ = 0, ranks_ = 1;
  std::string path_, temporary_;
  MPI_File file_ = MPI_FILE_NULL;
  std::uint64_t end_ = 0;  // the end of the data written
  std::uint64_t ids_ = 0;
  std::uint32_t ids_a_rank_ = 1;
  bool good_ = true;
};

}  // namespace tandem
