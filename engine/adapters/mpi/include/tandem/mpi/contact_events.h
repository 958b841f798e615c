// Begin and end of contacts on ranks.
#pragma once
#include <compare>
#include <memory>
#include <span>
#include <vector>

#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// Two bodies by their ids, a < b.
struct IdPair {
  GlobalId a = 0, b = 0;
  friend auto operator<=>(const IdPair&, const IdPair&) = default;
};

/// The pairs that began to touch and that ceased to touch from one step to the next, on whichever rank they are
/// reported: a begin and an end for each contact, each reported on one rank. A pair that only moved to another rank's
/// region is neither.
class ContactEvents {
 public:
  /// Collective, after a step of the pipeline. Ranks exchange messages only about pairs that they did not report
  /// before, or no longer report.
  void update(const Pipeline& pipeline);

  std::span<const IdPair> began() const { return began_; }        ///< reported here, ascending
  std::span<const IdPair> ended() const { return ended_; }        ///< reported here, ascending
  std::span<const IdPair> touching() const { return touching_; }  ///< reported here, ascending

 private:
  std::vector<IdPair> touching_, before_, began_, ended_;
};

}  // namespace tandem::mpi
