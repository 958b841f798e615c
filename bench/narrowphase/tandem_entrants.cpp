// tandem as a contestant of the narrow-phase bench.
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

/// Follows pairs over time: begins each track without, then continues with the cache that the time step before left.
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

std::vector<PlacedPair> placed(const Question& question) {
  std::vector<PlacedPair> out;
  out.reserve(question.pairs.size());
  for (const reference::PosedPair& p : question.pairs) out.push_back({&p.a, &p.pose_a, &p.b, &p.pose_b});
  return out;
}

/// Contacts of all pairs, given together.
class SeveralContacts final : public PairSolver, private AnswerSink {
 public:
  explicit SeveralContacts(const Question& question) : placed_(placed(question)) {}
  void answer(std::span<Found> out) override {
    out_ = out;
    std::fill(out.begin(), out.end(), Found());  // separated pairs are skipped
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

/// Verdicts of all pairs: pairs not separated by the quick test are asked for one by one.
class SeveralVerdicts final : public PairSolver {
 public:
  explicit SeveralVerdicts(const Question& question) : placed_(placed(question)), apart_(placed_.size()) {}
  void answer(std::span<Found> out) override {
    solver_.mark_apart(placed_, apart_);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = {.collide = apart_[i] == 0 && collide(placed_[i])};
  }
  void answer_one(std::size_t pair) override { collide(placed_[pair]); }

 private:
  bool collide(const PlacedPair& p) const {
    return solver_.solve(*p.a, *p.pose_a, *p.b, *p.pose_b, Request::collide).collide;
  }

  NarrowPhase solver_;
  std::vector<PlacedPair> placed_;
  std::vector<std::uint8_t> apart_;
};

/// For kinds that can be solved several at once.
std::unique_ptr<PairSolver> several(const Question& question) {
  const reference::PosedPair& p = question.pairs.front();
  const auto are = [&](ShapeKind a, ShapeKind b) { return p.a.kind() == a && p.b.kind() == b; };
  const bool boxes = are(ShapeKind::box, ShapeKind::box), halfspace_box = are(ShapeKind::halfspace, ShapeKind::box);
  if (question.request == Request::contacts && (boxes || halfspace_box))
    return std::make_unique<SeveralContacts>(question);
  if (question.request == Request::collide && boxes) return std::make_unique<SeveralVerdicts>(question);
  return nullptr;
}

}  // namespace

std::vector<Entrant> tandem_entrants() {
  const auto with = [](NarrowPhaseOptions options) {
    return [options](const Question& question) { return cold(question, options); };
  };
  return {{"tandem", with({})},
          {std::string(several_at_once), several},
          {"tandem, warm", warm},
          {"tandem, gjk", with({.solver = "gjk"})},
          {"tandem, tolerance 1e-3", with({.tolerance = 1e-3})}};
}

}  // namespace tandem::bench
