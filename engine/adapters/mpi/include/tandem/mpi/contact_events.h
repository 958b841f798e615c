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

/// Which pairs began to touch and no longer touch, from one step to the next, wherever they are reported: a begin and
/// an end for each touch, each told on one rank. A pair that only went to another rank's region is neither.
class ContactEvents {
 public:
  /// Collective, after a step of the pipeline. Ranks talk of those pairs alone that they did not report before, or do
  /// no longer.
  void update(const Pipeline& pipeline);

  std::span<const IdPair> began() const { return began_; }        ///< told here, ascending
  std::span<const IdPair> ended() const { return ended_; }        ///< told here, ascending
  std::span<const IdPair> touching() const { return touching_; }  ///< reported here, ascending

 private:
  std::vector<IdPair> touching_, before_, began_, ended_;
};

}  // namespace tandem::mpi
