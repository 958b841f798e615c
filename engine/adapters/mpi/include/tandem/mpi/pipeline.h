// The pipeline of a step on MPI ranks.
#pragma once
#include <mpi.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "tandem/engine/pipeline.h"
#include "tandem/engine/scene.h"

/// Collision detection by any number of MPI ranks, each with its own threads: the same contacts as on one. Space is
/// divided into one region per rank; a body is owned by the rank whose region contains the centre of its box (or did
/// before the body moved by a tenth of its radius), and copied to the ranks whose regions its box overlaps. See
/// docs/mpi.md.
namespace tandem::mpi {

/// A body's id on all ranks, chosen by the rank that adds it; the id of a removed body may be reused from the next step
/// on.
using GlobalId = std::uint64_t;

/// Parameters of the decision when regions are recomputed from measured costs.
struct RebalanceOptions {
  bool enabled = true;
  /// The largest number of steps between two measurements, [1, 1024]; they are frequent at first and after changes.
  int longest_control_step = 64;
  /// A cut is considered when the slowest rank's load exceeds this multiple of the mean, [1, 100].
  double tolerated = 1.05;
};

struct Options {
  /// Options of each rank's detection: threads, executor, answers.
  PipelineOptions rank{};
  RebalanceOptions rebalance{};
  /// Seconds, finite, >= 0: a rank that waits longer for another ends the job (MPI_Abort) with one line on stderr; 0:
  /// no limit.
  double patience = 0;
};

/// The measurements and the action of a rebalance, after a step; the same on all ranks.
struct RebalanceDecision {
  BalanceAction action = BalanceAction::none;
  int control_step = 0;     ///< steps until the next measurement
  double imbalance = 1;     ///< the largest load of a rank over the mean, since the last measurement
  double gain_ms = 0;       ///< time a step that equal loads would save at most
  double migration_ms = 0;  ///< the cost of the last cut on the slowest rank: the cut itself, migration, new copies
  std::string_view reason;
};

/// The results and measurements of one rank in a step.
struct RankReport {
  StepReport detection;          ///< of this rank's detection; candidate_pairs includes pairs that another rank reports
  std::uint64_t owned = 0;       ///< bodies
  std::uint64_t copies = 0;      ///< of others' bodies
  std::uint64_t moved_away = 0;  ///< owned bodies that went to another owner
  std::uint64_t bytes_sent = 0;  ///< to other ranks, only in exchanges
  std::uint64_t messages_sent = 0;
  double exchange_ms = 0;       ///< wall: changes, bodies and copies sent and received, waiting included
  double exchange_wait_ms = 0;  ///< of exchange_ms, in MPI: messages under way, and ranks that come later
  double wait_ms = 0;           ///< wall: waiting for other ranks at the end of the step
  double step_ms = 0;           ///< wall, the whole step
  double exchange_cpu_ms = 0;   ///< of the calling thread, without waiting
  double detect_cpu_ms = 0;     ///< of the calling thread alone
};

/// The results of a step over all ranks; the same on each of them.
struct Report {
  std::uint64_t step = 0;
  std::uint64_t bodies = 0;
  std::uint64_t pairs = 0;  ///< candidates, each counted once
  std::uint64_t colliding_pairs = 0;
  std::uint64_t contacts = 0;      ///< contacts that touch or overlap
  std::uint64_t gaps = 0;          ///< contacts of negative depth, within the margin
  std::uint64_t kept_pairs = 0;    ///< candidates whose answers were kept (AnswerOptions::keep_contacts)
  std::uint64_t contact_hash = 0;  ///< hash(GatheredContacts) of all ranks' answers; 0 unless asked for
  double max_depth = 0;            ///< metres, the deepest contact
  double kept_error_bound = 0;     ///< metres, the largest error bound of a kept answer that is reported
  std::uint64_t moved_away = 0, copies = 0, bytes_sent = 0, messages_sent = 0;  ///< sums over ranks
  double slowest_load_ms = 0, mean_load_ms = 0;                                 ///< busy time a thread
  /// CPU time of the calling threads without waiting, of the slowest ranks: time that other programs use is not in it.
  double slowest_exchange_cpu_ms = 0, slowest_detect_cpu_ms = 0;
  RebalanceDecision rebalance;
  RankReport rank;
};

/// A pair by its bodies' ids, a < b; its answer is of (a, b).
struct GatheredPair {
  GlobalId a = 0, b = 0;
  std::uint64_t first_contact = 0;
  std::uint32_t contact_count = 0;
  PairAnswer answer;
};

/// The answers of all ranks in canonical order: pairs by (a, b), a pair's contacts by feature.
struct GatheredContacts {
  std::vector<GatheredPair> pairs;
  std::vector<Contact> contacts;
};

/// A sum over pairs, each hashed with its contacts: it does not depend on the pairs' order or rank.
std::uint64_t hash(const GatheredContacts& contacts);

/// A failure of a step or a checkpoint on some rank; every rank throws it, with the same text, and is ready for the
/// next step.
struct StepError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Bodies on all ranks of a communicator, and their detection step by step. Calls are made by one thread a rank, the
/// one that MPI_Init_thread allows to call MPI (MPI_THREAD_FUNNELED is enough). Those said to be collective are made by
/// all ranks, in the same order.
///
/// Every pair is reported by one rank, the one whose region contains the lower corner of the intersection of the two
/// boxes. This rank has both bodies, and every rank that has both computes the same corner, so no message is needed.
class Pipeline {
 public:
  /// Collective. Throws std::invalid_argument that names the option, its value and what is allowed. Takes a duplicate
  /// of the communicator.
  explicit Pipeline(MPI_Comm communicator, Options options = {});
  /// Collective, before MPI_Finalize.
  ~Pipeline();
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;

  int rank() const;
  int ranks() const;

  /// Collective: every rank must add the same shapes in the same order, which the next step checks. The id is the same
  /// on all ranks.
  ShapeId add_shape(Shape shape, std::string name = {});

  /// Changes of bodies, by any rank, whichever rank owns the body. They take effect in the next step; changes of one
  /// body are applied in the order of ranks, then of calls. An invalid number is refused at once with
  /// std::invalid_argument; adding an existing id, or changing an unknown one, makes the step throw StepError on all
  /// ranks, and that change is ignored.
  void add_body(GlobalId id, const BodyOptions& body);
  void remove_body(GlobalId id);
  void set_pose(GlobalId id, const Pose& pose);
  void set_velocity(GlobalId id, const Vec3& velocity, const Vec3& angular_velocity);
  void set_shape(GlobalId id, ShapeId shape);
  void set_filter(GlobalId id, std::uint32_t group, std::uint32_t mask);
  void set_static(GlobalId id, bool is_static);
  void set_density(GlobalId id, double density);  ///< kg/m^3, finite, > 0
  void set_sensor(GlobalId id, bool is_sensor);
  void set_continuous(GlobalId id, bool continuous);

  /// Collective: applies changes, sends bodies to their owners and copies where they are needed, then detects on each
  /// rank. Throws StepError on all ranks if one failed. A failure while messages are under way (no memory) ends the
  /// job, with one line on stderr that names rank, step and cause.
  Report step();
  /// Collective: recomputes regions before the next step, independently of control steps, from the last measured costs;
  /// from the number of bodies if there are none, or only of other bodies.
  void rebalance();

  /// This rank's bodies: its own and copies of others'. Indices are local, and change with migration.
  const Scene& scene() const;
  GlobalId id(std::uint32_t index) const;
  bool owns(std::uint32_t index) const;
  /// The local id of a body that is on this rank; else throws std::invalid_argument.
  BodyId local(GlobalId id) const;
  bool has(GlobalId id) const;
  /// Moves a body that this rank owns, at once, as Scene::move does; the next step tells the ranks that have copies.
  void move(std::uint32_t index, const Pose& pose, const Vec3& velocity, const Vec3& angular_velocity);
  /// For a response, the same on all ranks: m/s^2, finite; s, > 0, at most 1000. Other values throw
  /// std::invalid_argument.
  void set_gravity(const Vec3& gravity);
  void set_dt(double dt);

  /// The pairs that this rank reports, of the last step, by local indices: the bodies of a pair in the order of global
  /// ids (id(a) < id(b)), pairs by (a, b). Valid until the next step.
  const ContactList& contacts() const;
  /// Collective: the contacts of all ranks, on rank `root`; empty on the others.
  GatheredContacts gather(int root = 0) const;
  /// Collective: the contacts of all ranks in canonical order, a share on each rank: rank r's come before those of rank
  /// r + 1.
  GatheredContacts share() const;
  /// Collective, with the shares: tandem::hash of the list that one rank would have, where ids are indices. Passes from
  /// rank to rank, so that it takes as long as on one rank.
  std::uint64_t list_hash(const GatheredContacts& share) const;

  /// Collective: the next step reuses no kept answer (AnswerOptions::keep_contacts) of earlier steps. To be called by a
  /// run that writes a Checkpoint, so that it continues exactly as one that reads it.
  void begin_anew();

  /// Records slices and counters of this rank's steps, until called with null; `timeline` must outlive them. In
  /// addition to detection's: "exchange", and "wait" for messages under way and for other ranks.
  void record_to(Timeline* timeline);

 private:
  friend class Response;
  friend class ContactEvents;
  friend class Checkpoint;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::mpi
