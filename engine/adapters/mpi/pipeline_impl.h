// The private part of the pipeline on ranks.
#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bodies.h"
#include "communicator.h"
#include "costs.h"
#include "pipeline/kept_handover.h"
#include "rebalancer.h"
#include "regions.h"
#include "tandem/engine/pipeline.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

using Clock = std::chrono::steady_clock;

/// The members of a Pipeline on one rank.
struct Pipeline::Impl {
  Impl(MPI_Comm of, Options wanted);

  Report step();
  /// Collective: sends each pair to the rank that `to` returns for its first body.
  GatheredContacts gather(const std::function<int(GlobalId)>& to) const;
  GatheredContacts share() const;
  std::uint64_t list_hash(const GatheredContacts& share) const;
  void record(std::string_view slice, Clock::time_point begin, Clock::time_point end);
  const ContactList& contacts() const;

  PipelineOptions detecting();
  std::size_t take_own(std::span<Pair> candidates);
  void note_failure(const std::string& cause);
  [[noreturn]] void throw_failure();
  /// Requests a change of a body for the next step; returns its data, of which those of this kind are to be set.
  BodyRecord& change(Change::Kind kind, GlobalId id) {
    Change& one = changes.emplace_back();
    one.kind = kind;
    one.body.motion.id = id;
    return one.body;
  }
  void apply(const Change& change);
  bool check_ahead();
  void apply_changes(Report& report);
  void add_bodies(std::span<const Change> own);
  void send_changes(std::span<const Change> own);
  void cut(std::span<const float> weights);
  void exchange(Report& report);
  void hand_over(Report& report);
  void begin_anew();
  void detect(Report& report);
  void put_together(Report& report);
  void rebalance(Report& report);
  void rebalance_now();

  Options options;
  mutable Communicator communicator;
  Regions regions;
  Bodies bodies;
  Rebalancer rebalancer;
  Costs costs;
  ExecutionReport last;
  bool counts_costs = false;  // in the present step
  std::atomic<std::uint64_t> pairs{0};
  std::vector<Change> changes;
  std::string failure;    // of the present step, on this rank
  bool found = false;     // contacts() are those of the last step
  bool expected = false;  // in the present step no rank gets a message that it does not expect
  bool recut = false;     // the regions have changed since the last exchange
  bool learns_cost = false;
  double cut_ms = 0;
  bool has_continuous = false;  // some rank has a continuous body, as of the last step
  std::uint64_t steps = 0;
  Timeline* timeline = nullptr;
  tandem::Pipeline detection;
  KeptHandover kept;
};

}  // namespace tandem::mpi
