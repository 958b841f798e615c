// The directory of bodies' owners, by Zoltan.
#include "directory.h"

#include <zoltan_dd.h>

#include <algorithm>
#include <stdexcept>

namespace tandem::mpi {
namespace {

constexpr int words = sizeof(GlobalId) / sizeof(ZOLTAN_ID_TYPE);

std::vector<ZOLTAN_ID_TYPE> in_words(std::span<const GlobalId> ids) {
  std::vector<ZOLTAN_ID_TYPE> out(ids.size() * words + 1);  // never empty: Zoltan needs a pointer
  if (!ids.empty()) std::memcpy(out.data(), ids.data(), ids.size_bytes());
  return out;
}

void require(int status) {
  if (status != ZOLTAN_OK && status != ZOLTAN_WARN) throw std::runtime_error("Zoltan's directory failed");
}

}  // namespace

Directory::~Directory() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (directory_ != nullptr && finalized == 0) Zoltan_DD_Destroy(&directory_);
}

void Directory::update(const std::function<bool(GlobalId)>& owned) {
  if (directory_ == nullptr) require(Zoltan_DD_Create(&directory_, communicator_.comm(), words, 0, 0, 0, 0));
  const auto by_id = [](std::vector<GlobalId>& ids) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  };
  by_id(removals_);
  auto removals = in_words(removals_);
  require(Zoltan_DD_Remove(directory_, removals.data(), static_cast<int>(removals_.size())));
  by_id(arrivals_);
  std::erase_if(arrivals_, [&](GlobalId id) { return !owned(id); });
  auto arrivals = in_words(arrivals_);
  require(Zoltan_DD_Update(directory_, arrivals.data(), nullptr, nullptr, nullptr, static_cast<int>(arrivals_.size())));
  removals_.clear();
  arrivals_.clear();
}

std::vector<int> Directory::owners(std::span<const GlobalId> ids) {
  auto keys = in_words(ids);
  std::vector<int> owners(ids.size() + 1, -1);
  // Zoltan warns of unknown ids, and leaves their owner at -1.
  require(
      Zoltan_DD_Find(directory_, keys.data(), nullptr, nullptr, nullptr, static_cast<int>(ids.size()), owners.data()));
  owners.pop_back();
  return owners;
}

}  // namespace tandem::mpi
