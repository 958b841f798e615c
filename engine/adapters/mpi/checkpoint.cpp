// Checkpoints of a pipeline, written and read by all ranks in one file.
#include "tandem/mpi/checkpoint.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <span>
#include <vector>

#include "communicator.h"
#include "pipeline_impl.h"
#include "records.h"

namespace tandem::mpi {
namespace {

constexpr std::array<char, 24> magic{"tandem-mpi checkpoint 1"};
constexpr std::size_t records_a_piece = std::size_t{1} << 20;  // MPI counts bytes in int

struct Header {
  std::array<char, 24> magic{};
  std::uint64_t steps = 0, bodies = 0, record_bytes = 0, shapes = 0;
  std::array<double, 3> gravity{};
  double dt = 0;
  std::uint64_t sum = 0;  // sum of the records' hashes
  std::uint64_t own = 0;  // hash of all members above
};

std::uint64_t hash_of(const void* data, std::size_t bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u, word = 0;
  for (std::size_t at = 0; at < bytes; at += sizeof word) {
    word = 0;
    std::memcpy(&word, static_cast<const char*>(data) + at, std::min(sizeof word, bytes - at));
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

std::uint64_t own_hash(Header header) {
  header.own = 0;
  return hash_of(&header, sizeof header);
}

std::uint64_t sum_of(std::span<const BodyRecord> records) {
  std::uint64_t sum = 0;
  for (const BodyRecord& record : records) sum += hash_of(&record, sizeof record);
  return sum;
}

/// A file opened by all ranks. MPI's file functions return their errors, where other MPI errors end the job.
class SharedFile {
 public:
  SharedFile(MPI_Comm communicator, const std::string& path, int mode)
      // Open MPI does not open a path without a folder, hence the absolute path.
      : status_(MPI_File_open(communicator, std::filesystem::absolute(path).c_str(), mode, MPI_INFO_NULL, &file_)) {}
  ~SharedFile() { close(); }
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;

  bool good() const { return status_ == MPI_SUCCESS; }
  std::uint64_t size() {
    MPI_Offset bytes = 0;
    note(MPI_File_get_size(file_, &bytes));
    return static_cast<std::uint64_t>(bytes);
  }
  /// Reads or writes records in pieces. Not collective.
  template <class T>
  void write_at(std::uint64_t place, std::span<const T> values) {
    for (std::size_t at = 0; at < values.size() && good(); at += records_a_piece) {
      const auto piece = values.subspan(at, std::min(records_a_piece, values.size() - at));
      note(MPI_File_write_at(file_, static_cast<MPI_Offset>(place + at * sizeof(T)), piece.data(),
                             static_cast<int>(piece.size_bytes()), MPI_BYTE, MPI_STATUS_IGNORE));
    }
  }
  template <class T>
  void read_at(std::uint64_t place, std::span<T> values) {
    for (std::size_t at = 0; at < values.size() && good(); at += records_a_piece) {
      const auto piece = values.subspan(at, std::min(records_a_piece, values.size() - at));
      MPI_Status status;
      note(MPI_File_read_at(file_, static_cast<MPI_Offset>(place + at * sizeof(T)), piece.data(),
                            static_cast<int>(piece.size_bytes()), MPI_BYTE, &status));
      int bytes = 0;
      MPI_Get_count(&status, MPI_BYTE, &bytes);
      if (good() && bytes != static_cast<int>(piece.size_bytes())) status_ = MPI_ERR_IO;
    }
  }
  void sync() { note(MPI_File_sync(file_)); }
  void close() {
    if (file_ != MPI_FILE_NULL) note(MPI_File_close(&file_));
  }

 private:
  void note(int status) {
    if (good()) status_ = status;
  }
  MPI_File file_ = MPI_FILE_NULL;
  int status_;
};

/// True if the condition holds on some rank.
bool any(const Communicator& communicator, bool here) {
  std::uint64_t flag[] = {here ? 1u : 0u};
  communicator.largest(std::span<std::uint64_t>(flag));
  return flag[0] != 0;
}

/// The reason why a file with this header cannot be read; empty if it can.
std::string fault(const Header& header, std::uint64_t bytes, std::uint64_t shapes) {
  if (bytes < sizeof header) return "is cut off, or no checkpoint: it has " + std::to_string(bytes) + " bytes";
  if (header.magic != magic) return "is no checkpoint of tandem-mpi";
  if (header.own != own_hash(header)) return "is altered: its header's checksum is another";
  if (header.record_bytes != sizeof(BodyRecord)) return "is of another version";
  const std::uint64_t whole = sizeof header + header.bodies * sizeof(BodyRecord);
  if (bytes != whole)
    return std::string(bytes < whole ? "is cut off" : "is altered") + ": it has " + std::to_string(bytes) +
           " bytes instead of " + std::to_string(whole);
  if (header.shapes != shapes) return "is of a scene with other shapes";
  return {};
}

}  // namespace

void Checkpoint::write(const Pipeline& pipeline, const std::string& path) {
  const Pipeline::Impl& impl = *pipeline.impl_;
  const Communicator& communicator = impl.communicator;
  std::vector<BodyRecord> records;
  const Scene& scene = impl.bodies.scene();
  for (std::uint32_t i = 0; i < scene.indices(); ++i)
    if (scene.alive(i) && impl.bodies.owns(i)) records.push_back(BodyRecord::of(impl.bodies.id(i), scene, i));
  std::array<std::uint64_t, 2> sums{records.size(), sum_of(records)};
  std::uint64_t before = 0;
  const std::uint64_t own = records.size();
  MPI_Exscan(&own, &before, 1, MPI_UINT64_T, MPI_SUM, communicator.comm());
  if (communicator.rank() == 0) before = 0;
  communicator.sum(std::span<std::uint64_t>(sums));
  const std::string temporary = path + ".part";
  bool failed = false;
  {
    if (communicator.rank() == 0) std::remove(temporary.c_str());
    MPI_Barrier(communicator.comm());
    SharedFile file(communicator.comm(), temporary, MPI_MODE_CREATE | MPI_MODE_WRONLY);
    failed = any(communicator, !file.good());
    if (!failed) {
      if (communicator.rank() == 0) {
        Header header;
        header.magic = magic;
        header.steps = impl.steps;
        header.bodies = sums[0];
        header.record_bytes = sizeof(BodyRecord);
        header.shapes = impl.bodies.shapes_hash();
        Eigen::Map<Vec3>(header.gravity.data()) = scene.gravity;
        header.dt = scene.dt;
        header.sum = sums[1];
        header.own = own_hash(header);
        file.write_at(0, std::span<const Header>(&header, 1));
      }
      file.write_at(sizeof(Header) + before * sizeof(BodyRecord), std::span<const BodyRecord>(records));
      file.sync();
      file.close();
      failed = any(communicator, !file.good());
    }
  }
  if (!failed)
    failed = any(communicator, communicator.rank() == 0 && std::rename(temporary.c_str(), path.c_str()) != 0);
  if (!failed) return;
  if (communicator.rank() == 0) std::remove(temporary.c_str());
  throw StepError("checkpoint '" + path + "': cannot be written");
}

std::uint64_t Checkpoint::read(Pipeline& pipeline, const std::string& path) {
  Pipeline::Impl& impl = *pipeline.impl_;
  const Communicator& communicator = impl.communicator;
  const std::string name = "checkpoint '" + path + "' ";
  SharedFile file(communicator.comm(), path, MPI_MODE_RDONLY);
  if (any(communicator, !file.good())) throw StepError(name + "cannot be opened");
  Header header;
  const std::uint64_t bytes = file.size();
  if (bytes >= sizeof header) file.read_at(0, std::span<Header>(&header, 1));
  if (any(communicator, !file.good())) throw StepError(name + "cannot be read");
  const std::string why = fault(header, bytes, impl.bodies.shapes_hash());
  if (!why.empty()) throw std::invalid_argument(name + why);
  if (any(communicator, impl.bodies.owned() != 0))
    throw std::invalid_argument(name + "is to be read into a pipeline without bodies; this one has some");
  const auto ranks = static_cast<std::uint64_t>(communicator.ranks()),
             rank = static_cast<std::uint64_t>(communicator.rank());
  const std::uint64_t first = header.bodies * rank / ranks, end = header.bodies * (rank + 1) / ranks;
  std::vector<BodyRecord> records(end - first);
  file.read_at(sizeof header + first * sizeof(BodyRecord), std::span<BodyRecord>(records));
  if (any(communicator, !file.good())) throw StepError(name + "cannot be read");
  std::uint64_t sum[] = {sum_of(records)};
  communicator.sum(std::span<std::uint64_t>(sum));
  if (sum[0] != header.sum) throw std::invalid_argument(name + "is altered: its bodies' checksum is another");
  pipeline.set_gravity(Eigen::Map<const Vec3>(header.gravity.data()));  // these two may refuse, so they come first
  pipeline.set_dt(header.dt);
  for (const BodyRecord& record : records) impl.changes.push_back({Change::Kind::add, 0, record});
  impl.steps = header.steps;
  return header.steps;
}

}  // namespace tandem::mpi
