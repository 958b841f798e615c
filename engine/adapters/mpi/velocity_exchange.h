// The exchange of velocities between ranks during a solver iteration.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "communicator.h"
#include "response/contact_solver.h"
#include "shared_bodies.h"

namespace tandem::mpi {

/// Sends velocities between ranks that solve one list of pairs colour by colour. After a colour, each body that one of
/// its pairs has moved goes to the rank of the body's next pair, and after the last pair to all ranks that use it, so
/// that all begin the next pass alike. The schedule of messages follows from the colours alone, and is the same in
/// every pass.
class VelocityExchange {
 public:
  explicit VelocityExchange(Communicator& communicator) : communicator_(communicator) {}

  void plan(std::span<const SharedBody> shared);
  /// After a colour of this rank: sends the velocities that others need next, and receives those that they computed.
  void after(std::uint32_t colour, std::vector<SolverBody>& bodies);
  /// Receives the results of other ranks after this one's last colour.
  void end_pass(std::vector<SolverBody>& bodies);

  std::uint64_t bytes_sent() const { return bytes_; }
  std::uint64_t messages_sent() const { return messages_; }
  double wait_ms() const { return wait_ms_; }

 private:
  /// The velocities of bodies_[first, end), to or from a rank, after a colour.
  struct Parcel {
    std::uint32_t colour = 0;
    int rank = 0;
    std::uint32_t first = 0, end = 0;
  };
  struct Parcels {
    std::vector<Parcel> all;  // by colour, then rank
    std::vector<std::uint32_t> bodies;
    std::size_t next = 0;  // in the present pass
    bool due(std::uint32_t colour) const { return next < all.size() && all[next].colour <= colour; }
  };
  struct Stop {
    std::uint32_t colour = 0;
    int rank = 0;
    GlobalId id = 0;
    std::uint32_t index = 0;
    friend auto operator<=>(const Stop&, const Stop&) = default;
  };
  static void put_together(std::vector<Stop>& stops, Parcels& parcels);
  void send(const Parcel& parcel, const std::vector<SolverBody>& bodies);
  void receive(const Parcel& parcel, std::vector<SolverBody>& bodies);

  Communicator& communicator_;
  Parcels sent_, received_;
  std::uint64_t bytes_ = 0, messages_ = 0;
  double wait_ms_ = 0;
};

}  // namespace tandem::mpi
