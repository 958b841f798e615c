// The parts of a pipeline that its options choose: tandem's own, or a user's, whose results are checked.
#pragma once
#include <cstddef>
#include <memory>
#include <span>

#include "tandem/broadphase/broad_phase.h"
#include "tandem/engine/cost_model.h"
#include "tandem/engine/pipeline.h"
#include "tandem/flowgraph/contact_list.h"
#include "tandem/flowgraph/executor.h"

namespace tandem {

/// Validates the options; messages use the names that a user of the pipeline writes. Throws std::invalid_argument, as
/// the functions below.
PipelineOptions checked(PipelineOptions options);

/// True if answers are kept from step to step (KeptContacts).
inline bool keeps_answers(const PipelineOptions& options) {
  return options.answer.keep_contacts != 0 && options.answer.request != Request::collide;
}

std::unique_ptr<BroadPhase> broad_phase_of(const PipelineOptions& options);
/// Null: pairs' costs are estimated from the last step.
std::unique_ptr<CostModel> costs_of(const PipelineOptions& options);
std::unique_ptr<Executor> executor_of(const PipelineOptions& options);

/// The number of pairs that the predicate keeps of a batch. Throws if they are more than it was given.
std::size_t count_kept(const PairPredicate& predicate, std::span<Pair> pairs);
/// The same. Throws also if one is not of two different bodies of the scene: others would be read.
std::size_t kept_by(const PairPredicate& predicate, std::span<Pair> pairs, const Scene& scene);

/// Validates the list of a step by a user's broad phase or executor, before anything relies on its order; empties one
/// that is refused. `bodies`: one past the largest body index.
void require_canonical(const PipelineOptions& options, std::size_t bodies, ContactList& contacts);

}  // namespace tandem
