// Chooses how many threads each phase has, from measured times.
#include "measurement/balancer.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace tandem {
namespace {

constexpr int longest_control_step = 64;
// Phases whose times differ by less than this are in balance: moving one thread would overshoot (rule of the paper).
constexpr double balanced = 1.05;
// A split that lasts as long as this fraction of the present one gains no more than the noise of a step.
constexpr double gained = 0.97;

}  // namespace

Balancer::Balancer(int threads, Split fixed, BalanceRule rule, BalanceFunction own_rule)
    : threads_(threads),
      fixed_(!fixed.dynamic()),
      rule_(rule),
      own_rule_(std::move(own_rule)),
      split_(fixed),
      control_(longest_control_step) {
  if (!fixed_) split_ = {std::max(1, threads / 2), threads - std::max(1, threads / 2)};
}

void Balancer::clear_window() {
  steps_ = 0;
  broad_ = narrow_ = detect_ = 0;
}

int Balancer::wanted_broad() const {
  const int most = threads_ - 1;
  if (rule_ == BalanceRule::paper) {
    const double broad = broad_ / split_.broad, narrow = narrow_ / split_.narrow;
    if (broad > balanced * narrow) return std::min(split_.broad + 1, most);
    if (narrow > balanced * broad) return std::max(split_.broad - 1, 1);
    return split_.broad;
  }
  return best_broad(broad_, narrow_);
}

// A split lasts as long as the phase that it serves worse.
int Balancer::best_broad(double broad, double narrow) const {
  const auto lasts = [&](int x) { return std::max(broad / x, narrow / (threads_ - x)); };
  int best = split_.broad;
  double shortest = gained * lasts(best);
  for (int x = 1; x < threads_; ++x) {
    if (lasts(x) >= shortest) continue;
    shortest = lasts(x);
    best = x;
  }
  return best;
}

void Balancer::apply_user_rule(const ExecutionReport& report, BalanceDecision& decision) {
  const int broad = std::clamp(own_rule_(report), 1, threads_ - 1);
  split_ = {broad, threads_ - broad};
  decision.after = split_;
  decision.action = split_ == decision.before ? BalanceAction::keep : BalanceAction::change;
  decision.broad_ms = report.broad_ms;
  decision.narrow_ms = report.narrow_ms;
  decision.reason = "the caller's own rule";
}

bool Balancer::add_to_window(const ExecutionReport& report, BalanceDecision& decision) {
  const bool paper = rule_ == BalanceRule::paper;
  // If the load changed sides between two measurements, the rule acts at once and without averaging over the earlier
  // steps.
  const bool urgent =
      !paper && !control_.verifies() && steps_ + 1 < control_.steps() &&
      std::abs(best_broad(report.broad_ms, report.narrow_ms) - split_.broad) >= std::max(2, threads_ / 4);
  if (urgent) clear_window();
  ++steps_;
  broad_ += report.broad_ms;
  narrow_ += report.narrow_ms;
  detect_ += report.detect_ms;

  const double work = broad_ + narrow_;
  decision.broad_ms = paper ? broad_ / split_.broad / steps_ : broad_ / steps_;
  decision.narrow_ms = paper ? narrow_ / split_.narrow / steps_ : narrow_ / steps_;
  decision.measure = paper ? detect_ / steps_ : (work > 0 ? detect_ / work : 0);

  return steps_ >= control_.steps() || urgent;
}

void Balancer::verify(BalanceDecision& decision) {
  decision.measure_before = control_.measured_before();
  if (control_.confirm(decision.measure)) {
    decision.action = BalanceAction::confirm;
    decision.reason = "the change made it faster";
  } else {
    decision.action = BalanceAction::revert;
    decision.reason = "the change did not make it faster";
    split_ = before_;
  }
}

void Balancer::choose(BalanceDecision& decision) {
  const int wanted = wanted_broad();
  if (wanted == split_.broad) {
    decision.action = BalanceAction::keep;
    decision.reason = threads_ == 2 ? "two threads have one split" : "the phases are in balance";
    control_.keep();
    return;
  }
  decision.action = BalanceAction::change;
  decision.reason = wanted > split_.broad ? "the broad phase is the longer one" : "the narrow phase is the longer one";
  before_ = split_;
  split_ = {wanted, threads_ - wanted};
  control_.change(decision.measure);
}

BalanceDecision Balancer::after_step(std::uint64_t step, const ExecutionReport& report) {
  BalanceDecision decision;
  decision.step = step;
  decision.before = decision.after = split_;
  decision.control_step = control_.steps();
  if (fixed_) {
    decision.control_step = 0;
    decision.reason = "the split is fixed";
    return decision;
  }
  if ((report.issues & bit(StepIssue::ran_on_caller)) != 0) {
    decision.reason = "the step stayed on the caller";
    return decision;
  }
  if (own_rule_) {
    apply_user_rule(report, decision);
    return decision;
  }
  if (!add_to_window(report, decision)) {
    decision.reason = "between two control steps";
    return decision;
  }
  if (control_.verifies()) {
    verify(decision);
  } else {
    choose(decision);
  }
  clear_window();
  decision.after = split_;
  decision.control_step = control_.steps();
  return decision;
}

}  // namespace tandem
