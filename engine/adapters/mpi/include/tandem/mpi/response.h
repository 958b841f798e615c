#pragma once
#include <memory>

#include "tandem/engine/response.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// What a response of all ranks did and cost.
struct RankResponseReport {
  ResponseReport response;  ///< of all bodies, the same on all ranks; ms: this rank's
  double gather_ms = 0;     ///< wall: which rank solves what and in which order, and impulses that pairs left elsewhere
  double wait_ms = 0;       ///< wall: for other ranks' velocities
  std::uint64_t bytes_sent = 0, messages_sent = 0;  ///< by this rank
};

/// Moves the bodies of all ranks by one `dt`, the same bits on any number of ranks. Each solves the pairs that it
/// reports, colour by colour, and sends the velocities of bodies that others' pairs move as well; it knows of others'
/// pairs only how many such a body has, where, and their colours. A host with a response of its own does not make one,
/// and pays nothing. One response a pipeline.
///
/// Pairs are ordered by their ids: with ids that are a scene's indices it is the motion of tandem::Response.
class Response {
 public:
  /// Collective. Throws std::invalid_argument that names the option, its value and what is allowed.
  explicit Response(Pipeline& pipeline, ResponseOptions options = {});
  ~Response();
  Response(Response&&) noexcept;
  Response& operator=(Response&&) noexcept;

  /// Collective, after a step of the pipeline. `with_contacts` false: bodies fly.
  RankResponseReport step(bool with_contacts = true);
  /// Forgets the last step's impulses, as a new one has none: what a run does that writes a Checkpoint, so that it goes
  /// on as one that reads it.
  void begin_anew();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::mpi
