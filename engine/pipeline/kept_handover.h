#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/kept_contacts.h"
#include "tandem/engine/pipeline.h"

namespace tandem {

/// What a pipeline keeps of pairs and bodies, for whoever divides a scene among several pipelines: a pair that another
/// one detects from now on goes there with all that is kept of it. Between two steps, of pipelines that all have made
/// the same number of them.
class detail::KeptHandover {
 public:
  /// The pipeline must outlive it.
  explicit KeptHandover(Pipeline& pipeline) : pipeline_(pipeline) {}

  /// False: nothing is kept, and nothing else here is to be called but begin_anew().
  bool keeps() const;
  /// What is known of a body that the last step saw.
  std::optional<KeptRest> rest(const Scene& scene, std::uint32_t body) const;
  /// The last step's candidates of which `leaves` is true.
  std::vector<KeptRecord> leaving(const std::function<bool(Pair)>& leaves) const;
  /// Bodies that have come to the scene, or have taken another one's place there, and candidates of the last step.
  void take_in(const Scene& scene, std::span<const KeptBody> bodies, std::vector<KeptRecord> pairs);
  /// The next step computes all.
  void begin_anew();

 private:
  Pipeline& pipeline_;
};

using detail::KeptHandover;

}  // namespace tandem
