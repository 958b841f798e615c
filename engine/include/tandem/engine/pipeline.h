// The pipeline of a collision detection step: options, report and result.
#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string_view>

#include "tandem/broadphase/broad_phase.h"
#include "tandem/engine/cost_model.h"
#include "tandem/engine/scene.h"
#include "tandem/flowgraph/contact_list.h"
#include "tandem/flowgraph/executor.h"
#include "tandem/flowgraph/options.h"
#include "tandem/flowgraph/report.h"

namespace tandem {

class Timeline;
namespace detail {
class KeptHandover;
}

/// Options of the answer.
struct AnswerOptions {
  /// The request for each pair: a verdict, the distance, or the contacts.
  Request request = Request::contacts;
  /// The accepted error, relative to the bodies' size, [0, 0.1]; 0: to rounding. A larger one may be faster.
  double tolerance = 0;
  /// Metres, finite, >= 0: contacts up to this distance are reported, too, with negative depth; between two meshes only
  /// if mesh_margin is set, and only if they are separated.
  double margin = 0;
  /// As NarrowPhaseOptions::mesh_margin. Meshes then come to rest less deep in each other; measured steps took four to
  /// sixteen times as long.
  bool mesh_margin = false;
  /// Answers of the last step may stand for this one's, within this error relative to the smaller body's size, [0,
  /// 0.1]; 0: all are computed. A body rests while no point of it leaves its place by more than a thousandth of that;
  /// the answer of two at rest stays as it is. Else, for pairs that moved so little, one body seen from the other, that
  /// no point moved farther and nothing turned by more than this angle (radians), the answer is moved along; closed
  /// forms are cheaper to compute. PairAnswer::error_bound says how far either may be off. Between convex bodies
  /// distance and depth are right within it and verdicts exact. An overlap with a mesh (Status::unproven), whose depth
  /// may jump from one pose to the next, is not moved along; of two at rest it is that of the poses for which it was
  /// computed. Request::collide is always computed.
  double keep_contacts = 0;
  bool contact_hash = false;  ///< fill StepReport::contact_hash (some 10 ns a contact, outside detect_ms)
};

/// Receives the answers of a batch when they are computed, while others are still being computed: in any order, from
/// many threads at once. Every answer that the step computes and reports comes once; kept answers
/// (AnswerOptions::keep_contacts) are only in the list. A pair's contacts are contacts[first_contact, first_contact +
/// contact_count). Both spans are valid only during the call. An exception ends the step and is thrown by it.
using AnswerListener = std::function<void(std::span<const PairResult> pairs, std::span<const Contact> contacts)>;

/// Options of the answer, and of how steps are run. The answer depends only on `answer` and `predicate`.
struct PipelineOptions {
  ExecutorKind executor = ExecutorKind::flowgraph;
  /// In all, the caller counted, [0, 1024]; 0 asks oneTBB. Limited by the process's limit.
  int threads = 0;
  BroadPhaseKind broad_phase = BroadPhaseKind::automatic;
  AnswerOptions answer{};
  BalanceOptions balance{};
  PairBatchOptions batches{};
  SharingOptions sharing{};
  /// A user's filter of pairs, by batches; empty: none. It may reverse a pair, which is then answered, and listed, as
  /// (a, b) with a > b.
  PairPredicate predicate{};
  AnswerListener on_answers{};  ///< empty: answers are only in the list
  /// Microseconds, [0, longest_awake]; 0: never. For executor flowgraph: its workers stay awake after a step for at
  /// most so long, so that a second thread speeds up short steps; the cost is ExecutionReport::awake_ms. Other work of
  /// the process on oneTBB between two steps, such as a response on several threads, has to do without them meanwhile.
  double stay_awake = 0;

  // User-defined parts. Each factory is called once, by the pipeline's constructor; empty: tandem's own part.

  /// Replaces `broad_phase`. Its pairs are checked: bodies that do not exist, and pairs that occur twice in the answer,
  /// end the step with std::invalid_argument. Missing pairs are not detected.
  BroadPhaseFactory own_broad_phase{};
  /// Replaces `executor`. A list that is not in canonical order ends the step with std::invalid_argument.
  ExecutorFactory own_executor{};
  /// Costly pairs are begun first, by this estimate instead of the times of pairs of meshes in the step before.
  CostModelFactory own_costs{};
};

/// The results and measurements of one step.
struct StepReport {
  std::uint64_t step = 0;  ///< counted from 0 by the pipeline
  std::size_t bodies = 0;
  std::uint64_t colliding_pairs = 0;
  std::uint64_t contacts = 0;        ///< contacts that touch or overlap
  std::uint64_t gaps = 0;            ///< contacts of negative depth, within the margin
  std::uint64_t contact_hash = 0;    ///< of pairs and contacts, in order; 0 unless asked for
  double max_depth = 0;              ///< metres, 0 without contacts
  std::uint64_t kept_pairs = 0;      ///< candidates whose answer was kept, with or without contacts; 0 unless asked for
  std::uint64_t computed_pairs = 0;  ///< candidates that were computed although keeping was asked for
  double kept_error_bound = 0;       ///< metres, the largest error_bound of a kept answer with contacts
  BroadPhaseKind broad_phase = BroadPhaseKind::brute;  ///< the method that ran
  std::string_view broad_phase_reason;
  ExecutionReport execution;
};

/// Memory of a pipeline between steps, in bytes, including unused capacity of its lists.
struct PipelineMemory {
  std::size_t bodies = 0;        ///< boxes, and the last seen state of each body
  std::size_t broad_phase = 0;   ///< BroadPhase::memory
  std::size_t executor = 0;      ///< Executor::memory
  std::size_t kept_answers = 0;  ///< for AnswerOptions::keep_contacts
  std::size_t contacts = 0;      ///< the list

  std::size_t total() const { return bodies + broad_phase + executor + kept_answers + contacts; }
};

/// Detects collisions in a scene, step by step. Starts no thread of its own (except with ExecutorKind::threads) and
/// runs in the calling thread's arena and limits. A pipeline runs one step at a time; pipelines are independent of each
/// other.
class Pipeline {
 public:
  /// Throws std::invalid_argument that names the option, its value and what is allowed.
  explicit Pipeline(PipelineOptions options = {});
  ~Pipeline();
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;

  /// Throws only what the predicate, the listener or a part of one's own throws or does wrong, or std::bad_alloc; the
  /// pipeline is ready for the next step then. When `stop` is requested, or the task group of the calling oneTBB task
  /// is cancelled (executors barrier, fused and flowgraph), the step ends early with an empty answer; both reach into
  /// pairs with a mesh, and into the building of a mesh's hull.
  ///
  /// When the deadline passes, the answer has the completed pairs, and those that were found but not completed, with
  /// Status::stopped and without contacts; boxes that were not tested yet have no pairs. If any is incomplete, the
  /// report has StepIssue::incomplete; kept answers (AnswerOptions::keep_contacts) are not in such a list, and the next
  /// step computes all.
  StepReport step(const Scene& scene, std::stop_token stop = {},
                  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max());

  /// The last step's answer; valid until the next step.
  const ContactList& contacts() const;
  const PipelineOptions& options() const;
  PipelineMemory memory() const;  ///< not during a step

  /// Records slices and counters of the following steps, until called with null; `timeline` must outlive them.
  void record_to(Timeline* timeline);

 private:
  friend class detail::KeptHandover;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
