#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "communicator.h"
#include "tandem/mpi/pipeline.h"

struct Zoltan_DD_Struct;

namespace tandem::mpi {

/// Which rank owns a body: Zoltan's distributed directory (Pinar and Hendrickson 2001), in which each rank keeps the
/// entries of a share of all ids. Made when it is first asked; from then on told of who arrived and left before each
/// question, so that steps without questions pay nothing.
class Directory {
 public:
  explicit Directory(const Communicator& communicator) : communicator_(communicator) {}
  ~Directory();
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;

  /// Bodies that this rank has come to own, or that are gone everywhere; to be told before the next question.
  void arrived(GlobalId id) { arrivals_.push_back(id); }
  void gone(GlobalId id) { gone_.push_back(id); }
  /// Collective. `owned`: whether a body that arrived is still here.
  void tell(const std::function<bool(GlobalId)>& owned);
  /// Collective: the owners, -1 where there is none.
  std::vector<int> owners(std::span<const GlobalId> ids);

 private:
  const Communicator& communicator_;
  Zoltan_DD_Struct* directory_ = nullptr;
  std::vector<GlobalId> arrivals_, gone_;
};

}  // namespace tandem::mpi
