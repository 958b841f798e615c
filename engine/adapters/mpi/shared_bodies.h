// Bodies with pairs on several ranks, and the colours of their pairs.
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

/// A moving body with pairs reported by other ranks than its owner: all of its pairs in the order of their ids, with
/// the rank that reports each, and the colours that are known, which are the first ones.
struct SharedBody {
  GlobalId id = 0;
  std::uint32_t index = 0;
  int owner = 0;
  std::vector<int> ranks;
  std::vector<std::uint32_t> colours;
};

/// Gives pairs the colours that one rank would give them in the order of all ids. Each rank colours its own pairs, and
/// knows of others' only those that have a body in common. A pair waits for the colours of earlier pairs with one of
/// its bodies, which travel with the body from rank to rank in the order of its pairs, and for nothing else.
class SharedBodies {
 public:
  SharedBodies(Communicator& communicator, const Bodies& bodies) : communicator_(communicator), bodies_(bodies) {}

  /// `pairs`: ascending by ids; they must outlive the step.
  void begin(std::span<const OwnPair> pairs);
  /// Writes to owners which pairs on this rank move copies of their bodies.
  void write_uses(Outbox& outbox) const;
  void read_use(Message& message, int rank);
  /// Once all owners know: writes the pairs that move their bodies to the ranks that asked. Own ones need no message.
  void write_orders(Outbox& outbox);
  void read_order(Message& message, int owner);
  /// Collective. `colours`: one for each pair of the rank's list.
  void give_colours(std::vector<std::uint32_t>& colours);

  /// The shared bodies on this rank, ascending by ids; all colours are known after give_colours.
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
  void release(std::uint32_t side);
  void colour_ready(std::vector<std::uint32_t>& colours);
  void pass_on(SharedBody& body);
  void take(Message& message);

  Communicator& communicator_;
  const Bodies& bodies_;
  std::span<const OwnPair> pairs_;
  std::vector<Use> uses_;  // uses of own bodies by others
  std::vector<SharedBody> shared_;
  // A side is 2 * pair + (0 or 1): one of a pair's two bodies.
  std::vector<std::uint32_t> next_side_;  // for each side: the body's next side on this rank
  // For each index: the side of the body's next pair on this rank without a colour.
  std::vector<std::uint32_t> next_of_;
  std::vector<std::uint32_t> shared_of_;  // for each index: its place in shared_
  std::vector<std::uint8_t> waits_;       // for each pair: the number of bodies it waits for
  std::vector<std::uint32_t> ready_;
  std::vector<TakenColours> taken_;  // one for each index
  std::vector<Message> outgoing_;    // one for each rank
  std::size_t coloured_ = 0, complete_ = 0;
  std::uint64_t bytes_ = 0, messages_ = 0;
};

}  // namespace tandem::mpi
