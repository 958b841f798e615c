// The contact response on MPI ranks.
#pragma once
#include <functional>
#include <memory>

#include "tandem/engine/response.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// The results and costs of a response over all ranks.
struct RankResponseReport {
  ResponseReport response;  ///< of all bodies, the same on all ranks; times of this rank
  /// Wall: which rank solves which pair in which order, and impulses that pairs left on other ranks.
  double gather_ms = 0;
  double wait_ms = 0;                               ///< wall: waiting for other ranks' velocities
  std::uint64_t bytes_sent = 0, messages_sent = 0;  ///< by this rank
};

/// A predicate: do two bodies, given by their ids, collide at all; called from any thread.
using PairOfIds = std::function<bool(GlobalId a, GlobalId b)>;

/// Moves the bodies of all ranks by one `dt`, with the same bits on any number of ranks. Each rank solves the pairs
/// that it reports, colour by colour, and sends the velocities of bodies that pairs of other ranks move as well; of
/// other ranks' pairs it knows only the number, the ranks and the colours for such a body. A host with its own response
/// does not construct one, and pays nothing. One response per pipeline.
///
/// Pairs are ordered by their ids: if ids are a scene's indices, the motion is that of tandem::Response.
///
/// Continuous bodies (BodyOptions::continuous) are stopped by ContinuousMotion, with the same bits on any number of
/// ranks. The boxes swept by fast ones are sent to all ranks, and bodies near a group of them to one rank, which solves
/// it; without such bodies in the scene this costs nothing.
class Response {
 public:
  /// Collective. `allows`: which pairs a continuous body does not pass through; empty: all. Throws
  /// std::invalid_argument that names the option, its value and what is allowed: `predicate` is refused, as its
  /// indices are those of one rank; `allows` takes its place.
  explicit Response(Pipeline& pipeline, ResponseOptions options = {}, PairOfIds allows = {});
  ~Response();
  Response(Response&&) noexcept;
  Response& operator=(Response&&) noexcept;

  /// Collective, after a step of the pipeline. `with_contacts` false: contacts are ignored, and bodies fly.
  RankResponseReport step(bool with_contacts = true);
  /// Forgets the last step's impulses, like a new object. To be called by a run that writes a Checkpoint, so that it
  /// continues exactly as one that reads it.
  void begin_anew();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::mpi
