// Sends velocities between ranks after each colour of the solver.
#include "velocity_exchange.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <utility>

namespace tandem::mpi {
namespace {

using Numbers = std::array<double, 3>;

Numbers numbers(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

void VelocityExchange::plan(std::span<const SharedBody> shared) {
  const int own = communicator_.rank();
  std::vector<Stop> sent, received;
  std::vector<std::pair<std::uint32_t, int>> by_colour;
  for (const SharedBody& body : shared) {
    by_colour.clear();
    for (std::size_t k = 0; k < body.ranks.size(); ++k) by_colour.emplace_back(body.colours[k], body.ranks[k]);
    std::sort(by_colour.begin(), by_colour.end());
    std::vector<int> users = body.ranks;
    users.push_back(body.owner);
    std::sort(users.begin(), users.end());
    users.erase(std::unique(users.begin(), users.end()), users.end());
    for (std::size_t k = 0; k < by_colour.size(); ++k) {
      const auto [colour, rank] = by_colour[k];
      const bool last = k + 1 == by_colour.size();
      for (const int to : last ? users : std::vector<int>{by_colour[k + 1].second}) {
        if (to == rank) continue;
        if (rank == own) sent.push_back({colour, to, body.id, body.index});
        if (to == own) received.push_back({colour, rank, body.id, body.index});
      }
    }
  }
  put_together(sent, sent_);
  put_together(received, received_);
  bytes_ = messages_ = 0;
  wait_ms_ = 0;
}

void VelocityExchange::put_together(std::vector<Stop>& stops, Parcels& parcels) {
  std::sort(stops.begin(), stops.end());
  parcels.all.clear();
  parcels.bodies.clear();
  parcels.next = 0;
  for (const Stop& stop : stops) {
    const auto at = static_cast<std::uint32_t>(parcels.bodies.size());
    if (parcels.all.empty() || parcels.all.back().colour != stop.colour || parcels.all.back().rank != stop.rank)
      parcels.all.push_back({stop.colour, stop.rank, at, at});
    parcels.bodies.push_back(stop.index);
    ++parcels.all.back().end;
  }
}

void VelocityExchange::send(const Parcel& parcel, const std::vector<SolverBody>& bodies) {
  Message message;
  for (std::uint32_t k = parcel.first; k < parcel.end; ++k) {
    const SolverBody& body = bodies[sent_.bodies[k]];
    message.put(numbers(body.velocity));
    message.put(numbers(body.angular_velocity));
  }
  bytes_ += message.size();
  ++messages_;
  communicator_.post(Communicator::Topic::velocities, std::move(message), parcel.rank);
}

void VelocityExchange::receive(const Parcel& parcel, std::vector<SolverBody>& bodies) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  RankMessage message = communicator_.await(Communicator::Topic::velocities, parcel.rank);
  wait_ms_ += std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  for (std::uint32_t k = parcel.first; k < parcel.end; ++k) {
    SolverBody& body = bodies[received_.bodies[k]];
    const auto velocity = message.content.take<Numbers>(), angular_velocity = message.content.take<Numbers>();
    body.velocity = Eigen::Map<const Vec3>(velocity.data());
    body.angular_velocity = Eigen::Map<const Vec3>(angular_velocity.data());
  }
}

void VelocityExchange::after(std::uint32_t colour, std::vector<SolverBody>& bodies) {
  for (; sent_.due(colour); ++sent_.next) send(sent_.all[sent_.next], bodies);
  for (; received_.due(colour); ++received_.next) receive(received_.all[received_.next], bodies);
}

void VelocityExchange::end_pass(std::vector<SolverBody>& bodies) {
  after(std::numeric_limits<std::uint32_t>::max(), bodies);
  sent_.next = received_.next = 0;
  communicator_.settle();
}

}  // namespace tandem::mpi
