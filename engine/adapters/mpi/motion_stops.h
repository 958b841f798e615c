#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "bodies.h"
#include "communicator.h"
#include "response/first_stops.h"
#include "tandem/flowgraph/contact_list.h"
#include "tandem/mpi/contact_events.h"
#include "tandem/mpi/response.h"

namespace tandem::mpi {

/// What ContinuousMotion does, for the bodies of all ranks, the same bits as on one.
///
/// Watched bodies whose boxes overlap may change what becomes of each other, however far the chain goes: each such
/// group is solved by one rank, the owner of its smallest id, which is sent all bodies that come near the group, and
/// answers where its bodies end. All ranks know all boxes of watched bodies, and nothing of bodies that are not near
/// one. Where a body is taken along out of the boxes, its new box is told to all, and all is done again.
class MotionStops {
 public:
  MotionStops(Communicator& communicator, Bodies& bodies, PairOfIds allows);

  /// Collective. Takes back the ends (one an index) of owned bodies as far as needed; returns the stops of all ranks.
  std::size_t limit(std::span<Pose> ends);

  /// Whether some rank stopped a body in the last limit().
  bool any() const { return !stops_.empty(); }
  /// Collective, where any(), before the next response: on one rank a stopped pair without a contact gets the one at
  /// the nearest points. Both bodies are on that rank then. `found`: what the rank reports.
  const ContactList& with_contacts(const ContactList& found);
  /// Whether another rank has a stopped pair that none reports; after with_contacts.
  bool is_elsewhere(const IdPair& ids) const;
  /// As if nothing had been stopped in the last limit().
  void forget() { stops_.clear(); }
  template <class IsGone>
  void forget(const IsGone& is_gone) {
    std::erase_if(stops_, [&](const IdPair& ids) { return is_gone(ids.a) || is_gone(ids.b); });
  }

  /// Adds what was sent since the last call.
  void count_sent(std::uint64_t& bytes, std::uint64_t& messages) {
    bytes += std::exchange(bytes_, 0);
    messages += std::exchange(messages_, 0);
  }

 private:
  /// Where a watched body goes, or looked for others after it was stopped.
  struct Zone {
    GlobalId id = 0;
    int rank = 0;  // its owner
    Aabb box{};
  };
  struct Near {
    BodyRecord body;
    MotionRecord end;
  };

  PairPredicate predicate() const;
  FastestTwo fastest_of_all(FastestTwo own) const;
  void tell(std::span<const Zone> own);
  void group();
  void send_near(std::span<const Pose> ends);
  void share_scene(std::vector<Near>& near);
  std::vector<Zone> new_zones() const;
  void answer(std::span<Pose> ends);
  void tell_stops();
  std::vector<std::uint64_t> who_has(const ContactList& found) const;
  void lend(std::span<const std::uint64_t> who);

  Communicator& communicator_;
  Bodies& bodies_;
  PairOfIds allows_;
  FirstStops own_, shared_;  // of this rank's bodies; of those that it solves
  std::vector<Zone> zones_;  // of all ranks
  std::vector<int> homes_;   // one a zone: who solves its group
  BoxQueries tree_;
  Scene scene_;  // bodies near the groups that this rank solves, in the order of their ids
  std::vector<GlobalId> ids_;
  std::vector<int> owners_;
  std::vector<Pose> ends_;
  std::unordered_map<std::uint32_t, ShapeId> shapes_;  // in scene_, by place among the pipeline's
  std::vector<IdPair> stops_;                          // of all ranks, ascending
  std::vector<IdPair> elsewhere_;
  ContactList with_stopped_;
  std::uint64_t bytes_ = 0, messages_ = 0;
};

}  // namespace tandem::mpi
