// The distributed directory of bodies' owners.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "communicator.h"
#include "tandem/mpi/pipeline.h"

struct Zoltan_DD_Struct;

namespace tandem::mpi {

/// The distributed directory of bodies' owners, by Zoltan (Pinar and Hendrickson 2001): each rank holds the entries of
/// a share of all ids. It is made at the first query, and updated before each later one with the bodies that arrived
/// and left, so that steps without queries pay nothing.
class Directory {
 public:
  explicit Directory(const Communicator& communicator) : communicator_(communicator) {}
  ~Directory();
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;

  /// Notes bodies that this rank has come to own, or that were removed everywhere; before the next query.
  void arrived(GlobalId id) { arrivals_.push_back(id); }
  void removed(GlobalId id) { removals_.push_back(id); }
  /// Collective: updates the directory. `owned`: tells whether a body that arrived is still on this rank.
  void update(const std::function<bool(GlobalId)>& owned);
  /// Collective: the owners, -1 for unknown ids.
  std::vector<int> owners(std::span<const GlobalId> ids);

 private:
  const Communicator& communicator_;
  Zoltan_DD_Struct* directory_ = nullptr;
  std::vector<GlobalId> arrivals_, removals_;
};

}  // namespace tandem::mpi
