// Stops of continuous bodies on ranks.
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

/// ContinuousMotion for the bodies of all ranks, with the same bits as on one rank.
///
/// Watched bodies with overlapping boxes may change each other's motion, in chains of any length. Each such group is
/// solved by one rank, the owner of its smallest id, which receives all bodies near the group and sends back their end
/// poses. All ranks know the boxes of all watched bodies, but no bodies that are not near one. If a body is carried out
/// of the boxes, its new box is sent to all ranks, and the process is repeated.
class MotionStops {
 public:
  MotionStops(Communicator& communicator, Bodies& bodies, PairOfIds allows);

  /// Collective. Moves the end poses (one an index) of owned bodies back as far as needed; returns the number of stops
  /// on all ranks.
  std::size_t limit(std::span<Pose> ends);

  /// True if some rank stopped a body in the last limit().
  bool any() const { return !stops_.empty(); }
  /// Collective, if any(), before the next response: gives each stopped pair, on one rank that then has both bodies,
  /// the contacts of ContinuousMotion::add_contacts. `found`: the contacts that this rank reports.
  const ContactList& with_contacts(const ContactList& found);
  /// True if another rank has a stopped pair that none reports; after with_contacts.
  bool is_elsewhere(const IdPair& ids) const;
  /// Forgets the stops of the last limit().
  void forget() { stops_.clear(); }
  template <class IsGone>
  void forget(const IsGone& is_gone) {
    std::erase_if(stops_, [&](const IdPair& ids) { return is_gone(ids.a) || is_gone(ids.b); });
  }

  /// Adds the traffic since the last call.
  void count_sent(std::uint64_t& bytes, std::uint64_t& messages) {
    bytes += std::exchange(bytes_, 0);
    messages += std::exchange(messages_, 0);
  }

 private:
  /// The box of a watched body's motion, or one that it searched after it was stopped.
  struct Zone {
    GlobalId id = 0;
    int rank = 0;  // rank of the body's owner
    Aabb box{};
  };
  struct Near {
    BodyRecord body;
    MotionRecord end;
  };

  PairPredicate predicate() const;
  FastestTwo fastest_of_all(FastestTwo own) const;
  void send_zones(std::span<const Zone> own);
  void group();
  void send_near(std::span<const Pose> ends);
  void share_scene(std::vector<Near>& near);
  std::vector<Zone> new_zones() const;
  void answer(std::span<Pose> ends);
  void send_stops();
  std::vector<std::uint64_t> owners_and_reporters(const ContactList& found) const;
  void send_missing_copies(std::span<const std::uint64_t> who);

  Communicator& communicator_;
  Bodies& bodies_;
  PairOfIds allows_;
  FirstStops own_, shared_;  // stops of this rank's bodies; of those that it solves
  std::vector<Zone> zones_;  // zones of all ranks
  std::vector<int> homes_;   // one a zone: the rank that solves its group
  BoxQueries tree_;
  Scene scene_;  // bodies near the groups that this rank solves, in the order of their ids
  std::vector<GlobalId> ids_;
  std::vector<int> owners_;
  std::vector<Pose> ends_;
  std::unordered_map<std::uint32_t, ShapeId> shapes_;  // in scene_, by place among the pipeline's shapes
  std::vector<IdPair> stops_;                          // pairs stopped on all ranks, ascending
  std::vector<IdPair> elsewhere_;
  ContactList with_stopped_;
  std::uint64_t bytes_ = 0, messages_ = 0;
};

}  // namespace tandem::mpi
