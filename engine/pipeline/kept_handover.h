// The transfer of kept answers between pipelines that share a scene, as the ranks of tandem::mpi do.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/kept_contacts.h"
#include "tandem/engine/pipeline.h"

namespace tandem {

/// The interface by which a distributor of one scene over several pipelines moves kept data: the data of a pair that
/// another pipeline detects from now on goes there. Call it between two steps of pipelines that have made the same
/// number of steps.
class detail::KeptHandover {
 public:
  /// The pipeline must outlive it.
  explicit KeptHandover(Pipeline& pipeline) : pipeline_(pipeline) {}

  /// False: nothing is kept, and only begin_anew() may be called.
  bool keeps() const;
  /// The kept state of a body that was there in the last step.
  std::optional<KeptRest> rest(const Scene& scene, std::uint32_t body) const;
  /// The last step's candidates for which `leaves` is true.
  std::vector<KeptRecord> leaving(const std::function<bool(Pair)>& leaves) const;
  /// Adds bodies that are new in the scene, or have replaced another one at their index, and candidates of the last
  /// step.
  void take_in(const Scene& scene, std::span<const KeptBody> bodies, std::vector<KeptRecord> pairs);
  /// The next step recomputes all answers.
  void begin_anew();

 private:
  Pipeline& pipeline_;
};

using detail::KeptHandover;

}  // namespace tandem
