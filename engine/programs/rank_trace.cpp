// Timelines of runs on ranks.
#include "rank_trace.h"

#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "gzip.h"

namespace tandem {
namespace {

constexpr std::size_t most_slices = 200'000;  // of all ranks: some 40 MB

MPI_Comm together(MPI_Comm communicator) {
  MPI_Barrier(communicator);
  return communicator;
}

/// The events of a rank's timeline, changed from one process to this rank, separated by commas.
std::string events_of(const Timeline& timeline, int rank) {
  std::ostringstream text;
  timeline.write(text);
  nlohmann::json document = nlohmann::json::parse(std::move(text).str());
  std::string out;
  for (nlohmann::json& event : document.at("traceEvents")) {
    event["pid"] = rank + 1;
    if (event.at("name") == "process_name") event["args"]["name"] = "rank " + std::to_string(rank);
    out += (out.empty() ? "\n" : ",\n") + event.dump();
  }
  return out;
}

}  // namespace

RankTrace::RankTrace(MPI_Comm communicator, mpi::Pipeline& pipeline) : communicator_(together(communicator)) {
  MPI_Comm_rank(communicator_, &rank_);
  MPI_Comm_size(communicator_, &ranks_);
  pipeline.record_to(&timeline_);
}

void RankTrace::record(mpi::Pipeline& pipeline) {
  if (full_) return;
  ++steps_;
  int full = timeline_.slices() >= most_slices / static_cast<std::size_t>(ranks_) ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &full, 1, MPI_INT, MPI_MAX, communicator_);
  full_ = full != 0;
  if (full_) pipeline.record_to(nullptr);
}

void RankTrace::write(OutputFile* file, const std::string& path) const {
  const std::string own = events_of(timeline_, rank_);
  const int size = static_cast<int>(own.size());
  if (rank_ != 0) {
    MPI_Send(&size, 1, MPI_INT, 0, 0, communicator_);
    MPI_Send(own.data(), size, MPI_CHAR, 0, 0, communicator_);
    return;
  }
  std::string text = "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[" + own;
  for (int rank = 1; rank < ranks_; ++rank) {
    int bytes = 0;
    MPI_Recv(&bytes, 1, MPI_INT, rank, 0, communicator_, MPI_STATUS_IGNORE);
    std::string one(static_cast<std::size_t>(bytes), 0);
    MPI_Recv(one.data(), bytes, MPI_CHAR, rank, 0, communicator_, MPI_STATUS_IGNORE);
    text += "," + one;
  }
  text += "\n]}\n";
  file->append(path.ends_with(".gz") ? gzipped(text) : text);
}

}  // namespace tandem
