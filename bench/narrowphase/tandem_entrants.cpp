#include "pair_solver.h"

namespace tandem::bench {
namespace {

Found found(const PairAnswer& answer, Request request, const std::vector<Contact>& contacts) {
  if (request == Request::collide) return {.collide = answer.collide};
  if (request == Request::distance)
    return {.collide = answer.collide,
            .measured = true,
            .signed_distance = answer.signed_distance,
            .normal = answer.normal};
  Found out{.collide = !contacts.empty()};
  for (const Contact& c : contacts)
    if (!out.measured || -c.depth < out.signed_distance)
      out.measured = true, out.signed_distance = -c.depth, out.normal = c.normal;
  return out;
}

std::unique_ptr<PairSolver> cold(const Question& question, const NarrowPhaseOptions& options) {
  return each_pair([solver = NarrowPhase(options), pairs = question.pairs, request = question.request,
                    contacts = std::vector<Contact>()](std::size_t i) mutable {
    const reference::PosedPair& p = pairs[i];
    contacts.clear();
    const PairAnswer answer = solver.solve(p.a, p.pose_a, p.b, p.pose_b, request, &contacts);
    return found(answer, request, contacts);
  });
}

/// Begins each track anew, and then with what the step before left.
std::unique_ptr<PairSolver> warm(const Question& question) {
  if (question.tracks == 0) return nullptr;
  return each_pair([solver = NarrowPhase(), pairs = question.pairs, request = question.request,
                    contacts = std::vector<Contact>(),
                    starts = std::vector<WarmStart>(question.tracks)](std::size_t i) mutable {
    const reference::PosedPair& p = pairs[i];
    WarmStart& start = starts[i % starts.size()];
    if (i < starts.size()) start = {};
    contacts.clear();
    const PairAnswer answer = solver.solve(p.a, p.pose_a, p.b, p.pose_b, request, &contacts, &start);
    return found(answer, request, contacts);
  });
}

}  // namespace

std::vector<Entrant> tandem_entrants() {
  const auto with = [](NarrowPhaseOptions options) {
    return [options](const Question& question) { return cold(question, options); };
  };
  return {{"tandem", with({})},
          {"tandem, warm", warm},
          {"tandem, gjk", with({.solver = "gjk"})},
          {"tandem, tolerance 1e-3", with({.tolerance = 1e-3})}};
}

}  // namespace tandem::bench
