#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bodies.h"
#include "communicator.h"
#include "response/contact_solver.h"
#include "tandem/mpi/contact_events.h"

namespace tandem::mpi {

/// A pair that this rank reports and that moves a body.
struct OwnPair {
  IdPair ids;
  std::uint32_t found = 0;              // its place in the rank's list
  std::array<std::uint32_t, 2> body{};  // local indices
  std::array<bool, 2> moves{};
};

/// A moving body with pairs that other ranks report than its owner alone. All of its pairs in the order of their ids:
/// who reports each, and the colours that are known, which are the first ones.
struct SharedBody {
  GlobalId id = 0;
  std::uint32_t index = 0;
  int owner = 0;
  std::vector<int> ranks;
  std::vector<std::uint32_t> colours;
};

/// Gives pairs the colours that one rank would give them in the order of all ids, each rank its own pairs, and knows
/// of others only where they have a body in common. A pair's colour waits for those before it that have a body of its:
/// what is taken goes with the body from rank to rank, in the order of its pairs. Nobody waits for anything else.
class SharedBodies {
 public:
  SharedBodies(Communicator& communicator, const Bodies& bodies) : communicator_(communicator), bodies_(bodies) {}

  /// `pairs`: ascending by ids. They must outlive the step.
  void begin(std::span<const OwnPair> pairs);
  /// To the owners: which pairs move copies here.
  void write_uses(Outbox& outbox) const;
  void read_use(Message& message, int rank);
  /// Once all owners know: whose pairs move their bodies, to those who asked. One's own do not go through a message.
  void write_orders(Outbox& outbox);
  void read_order(Message& message, int owner);
  /// Collective. `colours`: one a pair of the rank's list.
  void give_colours(std::vector<std::uint32_t>& colours);

  /// Those of this rank, ascending by ids; all colours are known after give_colours.
  std::span<const SharedBody> shared() const { return shared_; }
  std::uint64_t bytes_sent() const { return bytes_; }
  std::uint64_t messages_sent() const { return messages_; }

 private:
  static constexpr std::uint32_t none = 0xffffffffu;
  struct Use {
    std::uint32_t body = 0;
    IdPair ids;
    int rank = 0;
    friend auto operator<=>(const Use&, const Use&) = default;
  };

  void link_pairs();
  void let_go(std::uint32_t side);
  void colour_ready(std::vector<std::uint32_t>& colours);
  void pass_on(SharedBody& body);
  void take(Message& message);

  Communicator& communicator_;
  const Bodies& bodies_;
  std::span<const OwnPair> pairs_;
  std::vector<Use> uses_;  // of own bodies, by others
  std::vector<SharedBody> shared_;
  // Sides are 2 * pair + (0 or 1).
  std::vector<std::uint32_t> next_side_;  // a side: the body's next one here
  std::vector<std::uint32_t> next_of_;    // an index: the side of the body's next pair here that has no colour
  std::vector<std::uint32_t> shared_of_;  // an index: in shared_
  std::vector<std::uint8_t> waits_;       // a pair: for how many bodies
  std::vector<std::uint32_t> ready_;
  std::vector<TakenColours> taken_;  // an index
  std::vector<Message> outgoing_;    // a rank
  std::size_t coloured_ = 0, complete_ = 0;
  std::uint64_t bytes_ = 0, messages_ = 0;
};

}  // namespace tandem::mpi
