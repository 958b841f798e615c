#pragma once
#include <memory>

#include "tandem/engine/response.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// What a response of all ranks did and cost.
struct RankResponseReport {
  ResponseReport response;  ///< of all bodies, the same on all ranks; ms: this rank's
  double gather_ms = 0;     ///< wall: contacts and changes sent to all ranks, waiting included
  std::uint64_t bytes_sent = 0;
};

/// Moves the bodies of all ranks by one `dt`, the same bits on any number of ranks: every rank is told all contacts,
/// and all of them solve all, each with a replica of every body. That is exact and simple, and takes as long as on one
/// rank and that memory on each: it is for scenes that one machine could respond to. A host with a response of its own
/// does not make one, and pays nothing. One response a pipeline.
///
/// With ids that were given in the order of a scene's indices, and no body removed, it is the motion of
/// tandem::Response.
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
