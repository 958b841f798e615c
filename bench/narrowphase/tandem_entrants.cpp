#include "pair_solver.h"
#include "tandem/narrowphase/several_pairs.h"

namespace tandem::bench {
namespace {

Found deepest(std::span<const Contact> contacts) {
  Found out{.collide = !contacts.empty()};
  for (const Contact& c : contacts)
    if (!out.measured || -c.depth < out.signed_distance)
      out.measured = true, out.signed_distance = -c.depth, out.normal = c.normal;
  return out;
}

Found found(const PairAnswer& answer, Request request, const std::vector<Contact>& contacts) {
  if (request == Request::collide) return {.collide = answer.collide};
  if (request == Request::distance)
    return {.collide = answer.collide,
            .measured = true,
            .signed_distance = answer.signed_distance,
            .normal = answer.normal};
  return deepest(contacts);
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

/// All pairs handed over at once.
class Several final : public PairSolver, private AnswerSink {
 public:
  explicit Several(const Question& question) {
    placed_.reserve(question.pairs.size());
    for (const reference::PosedPair& p : question.pairs) placed_.push_back({&p.a, &p.pose_a, &p.b, &p.pose_b});
  }
  void answer(std::span<Found> out) override {
    out_ = out;
    std::fill(out.begin(), out.end(), Found());  // who is apart is passed over
    solve(placed_);
  }
  void answer_one(std::size_t pair) override {
    Found found;
    out_ = {&found, 1};
    solve(std::span(placed_).subspan(pair, 1));
  }

 private:
  void solve(std::span<const PlacedPair> pairs) {
    contacts_.clear();
    first_ = 0;
    solver_.solve(pairs, contacts_, *this);
  }
  PairAnswer& begin(std::size_t pair) override {
    at_ = pair;
    return answer_ = {};
  }
  void end() override {
    out_[at_] = deepest(std::span(contacts_).subspan(first_));
    first_ = contacts_.size();
  }

  SeveralPairs solver_;
  std::vector<PlacedPair> placed_;
  std::vector<Contact> contacts_;
  std::size_t first_ = 0, at_ = 0;
  PairAnswer answer_;
  std::span<Found> out_;
};

/// Of the kinds that it does not solve one by one.
std::unique_ptr<PairSolver> several(const Question& question) {
  const auto is_together = [](ShapeKind kind) { return kind == ShapeKind::box || kind == ShapeKind::halfspace; };
  const reference::PosedPair& p = question.pairs.front();
  if (question.request != Request::contacts || !is_together(p.a.kind()) || !is_together(p.b.kind())) return nullptr;
  return std::make_unique<Several>(question);
}

}  // namespace

std::vector<Entrant> tandem_entrants() {
  const auto with = [](NarrowPhaseOptions options) {
    return [options](const Question& question) { return cold(question, options); };
  };
  return {{"tandem", with({})},
          {"tandem, several at once", several},
          {"tandem, warm", warm},
          {"tandem, gjk", with({.solver = "gjk"})},
          {"tandem, tolerance 1e-3", with({.tolerance = 1e-3})}};
}

}  // namespace tandem::bench
