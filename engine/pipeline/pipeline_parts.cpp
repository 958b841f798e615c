// Makes the parts of a pipeline, and checks the options and what a user's parts did.
#include "pipeline/pipeline_parts.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>

#include "pipeline/checked_broad_phase.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

PipelineOptions checked(PipelineOptions options) {
  const AnswerOptions& answer = options.answer;
  try {
    const NarrowPhase narrow_phase({.tolerance = answer.tolerance, .margin = answer.margin});
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("answer.") + error.what());
  }
  if (!(answer.keep_contacts >= 0 && answer.keep_contacts <= 0.1)) {
    char text[32];
    const std::string found(text, std::to_chars(text, text + sizeof text, answer.keep_contacts).ptr);
    throw std::invalid_argument("answer.keep_contacts: " + found + " is not in [0, 0.1]");
  }
  return options;
}

std::unique_ptr<BroadPhase> broad_phase_of(const PipelineOptions& options) {
  if (options.own_broad_phase) {
    return std::make_unique<CheckedBroadPhase>(options.own_broad_phase(), keeps_answers(options));
  }
  return make_broad_phase(options.broad_phase);
}

std::unique_ptr<CostModel> costs_of(const PipelineOptions& options) {
  if (!options.own_costs) return {};
  std::unique_ptr<CostModel> own = options.own_costs();
  if (own == nullptr) throw std::invalid_argument("own_costs: made none, allowed: a cost model");
  return own;
}

std::unique_ptr<Executor> executor_of(const PipelineOptions& options) {
  const ExecutorOptions wanted{.kind = options.executor,
                               .threads = options.threads,
                               .balance = options.balance,
                               .batches = options.batches,
                               .sharing = options.sharing,
                               .stay_awake = options.stay_awake};
  std::unique_ptr<Executor> made = make_executor(wanted);  // refuses invalid options
  if (!options.own_executor) return made;
  made = options.own_executor(wanted);
  if (made == nullptr) throw std::invalid_argument("own_executor: made none, allowed: an executor");
  return made;
}

std::size_t count_kept(const PairPredicate& predicate, std::span<Pair> pairs) {
  const std::size_t kept = predicate(pairs);
  if (kept > pairs.size())
    throw std::out_of_range("predicate: kept " + std::to_string(kept) + " pairs of " + std::to_string(pairs.size()));
  return kept;
}

std::size_t kept_by(const PairPredicate& predicate, std::span<Pair> pairs, const Scene& scene) {
  const std::size_t kept = count_kept(predicate, pairs);
  const auto is_body = [&](std::uint32_t index) { return index < scene.indices() && scene.alive(index); };
  for (const auto [a, b] : pairs.first(kept))
    if (a == b || !is_body(a) || !is_body(b))
      throw std::invalid_argument("predicate: kept the pair (" + std::to_string(a) + ", " + std::to_string(b) +
                                  "), allowed: two different bodies of the scene");
  return kept;
}

void require_canonical(const PipelineOptions& options, std::size_t bodies, ContactList& contacts) {
  const auto is_outside = [&](const PairResult& pair) {
    return pair.a >= bodies || pair.b >= bodies ||
           std::uint64_t{pair.first_contact} + pair.contact_count > contacts.contacts.size();
  };
  if (std::ranges::any_of(contacts.pairs, is_outside)) {
    contacts.pairs.clear();
    contacts.contacts.clear();
    throw std::invalid_argument(
        "own_executor: its list has a pair of no bodies, or with contacts that it does not have, "
        "allowed: what narrow() gave");
  }
  const auto key = [](const PairResult& pair) { return Pair{pair.a, pair.b}; };
  const auto wrong = std::ranges::adjacent_find(contacts.pairs, std::ranges::greater_equal{}, key);
  if (wrong == contacts.pairs.end()) return;
  const Pair one = key(*wrong), next = key(*std::next(wrong));
  contacts.pairs.clear();
  contacts.contacts.clear();
  const auto text = [](Pair pair) { return "(" + std::to_string(pair.a) + ", " + std::to_string(pair.b) + ")"; };
  if (one == next && options.own_broad_phase)
    throw std::invalid_argument("own_broad_phase: put the pair " + text(one) + " twice, allowed: each pair once");
  throw std::invalid_argument("own_executor: its list has the pair " + text(next) + " after " + text(one) +
                              ", allowed: ascending, each pair once");
}

}  // namespace tandem
