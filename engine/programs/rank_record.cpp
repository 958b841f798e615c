// Recordings of runs on ranks, written in parallel by MPI-IO.
#include "rank_record.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <numeric>

#include "formats/record_file.h"

namespace tandem {
namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 30;  // of one write: MPI counts in int

std::uint32_t index_at(const std::string& poses, std::size_t at) {
  std::uint32_t index = 0;
  std::memcpy(&index, poses.data() + at, sizeof index);
  return index;
}

/// The poses in the order of their indices.
std::string sorted(const std::string& poses) {
  std::vector<std::size_t> places(poses.size() / record::pose_bytes);
  for (std::size_t k = 0; k < places.size(); ++k) places[k] = k * record::pose_bytes;
  std::sort(places.begin(), places.end(),
            [&](std::size_t x, std::size_t y) { return index_at(poses, x) < index_at(poses, y); });
  std::string out;
  out.reserve(poses.size());
  for (const std::size_t at : places) out.append(poses, at, record::pose_bytes);
  return out;
}

std::vector<int> sums_before(const std::vector<int>& counts) {
  std::vector<int> out(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), out.begin(), 0);
  return out;
}

}  // namespace

RankRecord::RankRecord(MPI_Comm communicator, const std::string& path)
    : path_(std::filesystem::absolute(path).string()), temporary_(path_ + ".part") {
  MPI_Comm_dup(communicator, &communicator_);
  MPI_Comm_rank(communicator_, &rank_);
  MPI_Comm_size(communicator_, &ranks_);
}

// After an exception here, the destructor closes the file on all ranks.
RankRecord::RankRecord(MPI_Comm communicator, const std::string& path, const Scene& scene)
    : RankRecord(communicator, path) {
  const std::string header = record::header(scene);
  ids_ = scene.indices();
  ids_a_rank_ = static_cast<std::uint32_t>(ids_) / static_cast<std::uint32_t>(ranks_) + 1;
  if (rank_ == 0) std::remove(temporary_.c_str());
  MPI_Barrier(communicator_);
  good_ = MPI_File_open(communicator_, temporary_.c_str(), MPI_MODE_CREATE | MPI_MODE_WRONLY, MPI_INFO_NULL, &file_) ==
          MPI_SUCCESS;
  if (!good_) file_ = MPI_FILE_NULL;
  require_all("cannot be opened");
  if (rank_ == 0) write(0, header);
  end_ = header.size();
  require_all("cannot be written");
}

RankRecord::~RankRecord() {
  if (file_ != MPI_FILE_NULL) {  // not complete
    MPI_File_close(&file_);
    if (rank_ == 0) std::remove(temporary_.c_str());
  }
  MPI_Comm_free(&communicator_);
}

void RankRecord::require_all(const char* what) {
  int bad = good_ ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPI_INT, MPI_MAX, communicator_);
  if (bad != 0) throw mpi::StepError("--record: '" + path_ + "' " + what);
}

void RankRecord::write(std::uint64_t place, const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size() && good_; at += most_bytes)
    good_ = MPI_File_write_at(file_, static_cast<MPI_Offset>(place + at), bytes.data() + at,
                              static_cast<int>(std::min(most_bytes, bytes.size() - at)), MPI_BYTE,
                              MPI_STATUS_IGNORE) == MPI_SUCCESS;
}

/// True if this rank's bodies are the scene's, which those of a checkpoint need not be, and the number of poses that it
/// sends and receives fits MPI's int.
bool RankRecord::can_write(const mpi::Pipeline& pipeline) const {
  const Scene& scene = pipeline.scene();
  std::uint64_t owned = 0;
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!pipeline.owns(i)) continue;
    if (pipeline.id(i) >= ids_) return false;
    ++owned;
  }
  return std::max<std::uint64_t>(owned, ids_a_rank_) * record::pose_bytes <= std::uint64_t{INT_MAX};
}

/// The poses of the bodies, other than static ones, in this rank's range of ids, collected from their owners.
std::string RankRecord::poses(const mpi::Pipeline& pipeline) const {
  const Scene& scene = pipeline.scene();
  std::vector<std::string> own(static_cast<std::size_t>(ranks_));
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (!pipeline.owns(i) || scene.is_static()[i] != 0) continue;
    const auto id = static_cast<std::uint32_t>(pipeline.id(i));
    record::append_pose(own[id / ids_a_rank_], id, scene.poses()[i]);
  }
  std::vector<int> sent, got(own.size());
  std::string all;
  for (const std::string& one : own) {
    sent.push_back(static_cast<int>(one.size()));
    all += one;
  }
  MPI_Alltoall(sent.data(), 1, MPI_INT, got.data(), 1, MPI_INT, communicator_);
  const std::vector<int> sent_at = sums_before(sent), got_at = sums_before(got);
  std::string mixed(static_cast<std::size_t>(got_at.back() + got.back()), 0);
  MPI_Alltoallv(all.data(), sent.data(), sent_at.data(), MPI_BYTE, mixed.data(), got.data(), got_at.data(), MPI_BYTE,
                communicator_);
  return sorted(mixed);
}

std::uint64_t RankRecord::step(const mpi::Pipeline& pipeline, std::uint64_t step) {
  good_ = good_ && can_write(pipeline);
  require_all("cannot hold these bodies: of ids below the scene's number of bodies, at most 2 GiB of poses a rank");
  const mpi::GatheredContacts share = pipeline.share();
  const std::uint64_t hash = pipeline.list_hash(share);
  const std::string moving = poses(pipeline);
  std::string contacts;
  for (const mpi::GatheredPair& pair : share.pairs)
    for (std::uint64_t k = pair.first_contact; k < pair.first_contact + pair.contact_count; ++k)
      record::append_contact(contacts, static_cast<std::uint32_t>(pair.a), static_cast<std::uint32_t>(pair.b),
                             share.contacts[k]);
  const std::array<std::uint64_t, 2> own{moving.size(), contacts.size()};
  std::array<std::uint64_t, 2> before{}, all{};
  MPI_Exscan(own.data(), before.data(), 2, MPI_UINT64_T, MPI_SUM, communicator_);
  if (rank_ == 0) before = {};
  MPI_Allreduce(own.data(), all.data(), 2, MPI_UINT64_T, MPI_SUM, communicator_);
  if (rank_ == 0) {
    std::string head;
    record::append_step_head(head, step, hash, static_cast<std::uint32_t>(all[0] / record::pose_bytes),
                             static_cast<std::uint32_t>(all[1] / record::contact_bytes));
    write(end_, head);
  }
  end_ += record::step_head_bytes;
  write(end_ + before[0], moving);
  end_ += all[0];
  write(end_ + before[1], contacts);
  end_ += all[1];
  require_all("cannot be written");
  return hash;
}

void RankRecord::commit() {
  good_ = MPI_File_sync(file_) == MPI_SUCCESS && good_;
  good_ = MPI_File_close(&file_) == MPI_SUCCESS && good_;
  file_ = MPI_FILE_NULL;
  if (rank_ == 0 && good_) good_ = std::rename(temporary_.c_str(), path_.c_str()) == 0;
  if (rank_ == 0 && !good_) std::remove(temporary_.c_str());
  require_all("cannot be written");
}

}  // namespace tandem
