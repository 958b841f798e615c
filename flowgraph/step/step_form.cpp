// Chooses the form of the next step from the times of the steps before it.
#include "step/step_form.h"

#include <algorithm>

namespace tandem {
namespace {

constexpr double most_on_caller_ms = 2;   // of work: above it sharing with another thread always pays
constexpr double most_for_two_ms = 10;    // the same with two threads: cores without a common cache may do twice the
                                          // caller's work, and a trial of the caller takes at most a step's time more
constexpr double little_shared = 1.5;     // work over time: a step with more will not be faster on one thread
constexpr double joining_to_gain = 0.03;  // fraction of a step: what joining must take for sorting first to pay
constexpr double mostly_heavy = 0.5;      // fraction of the narrow phase: beyond it answers are few, little is joined
constexpr double better = 0.97;           // a smaller gain is within the noise of a step, or not worth another core
constexpr double hopeless = 1.5;          // times the current form's: such a trial ends without its second step
constexpr double most_lost = 0.01;        // fraction of all steps' time that trials of slower forms may cost
constexpr double changed_load = 1.5;      // times that at the last trial of a form: what it showed holds no more
constexpr int gains_to_change = 2;        // steps in a row: one alone is often the noise of short steps
constexpr int longest_period = 512;
constexpr int longest_off_caller = 64;  // short, so that a core that does not help is given back soon

/// True if a step has too much work for the caller alone.
bool is_much(const ExecutionReport& report, double work_ms) {
  return work_ms >= (report.threads == 2 ? most_for_two_ms : most_on_caller_ms);
}

}  // namespace

FormChooser::FormChooser(StepForm wanted, double small_step_ms, bool can_order)
    : wanted_(wanted), can_order_(can_order), small_step_ms_(small_step_ms) {
  if (wanted_ != StepForm::automatic) next_ = wanted_;
}

bool FormChooser::may_be(StepForm form, const ExecutionReport& report, double work_ms) const {
  // The work of a shared step exceeds that of the caller alone, by about as much as a small step takes.
  if (form == StepForm::caller)
    return small_step_ms_ > 0 && !is_much(report, work_ms) &&
           (report.threads == 2 ||
            work_ms < std::max(little_shared * report.detect_ms, report.detect_ms + small_step_ms_));
  return form == StepForm::overlapped || (form == StepForm::ordered && can_order_);
}

/// Once the current form has run twice, only its own steps tell whether it stays, unless there is much more to do.
bool FormChooser::may_stay(const ExecutionReport& report, double work_ms) {
  const bool has_own_measurements = report.form != current_ && of(current_).has_two();
  return has_own_measurements ? current_ != StepForm::caller || !is_much(report, work_ms)
                              : may_be(current_, report, work_ms);
}

bool FormChooser::may_pay(StepForm form, const ExecutionReport& report) const {
  return form != StepForm::ordered || report.form != StepForm::overlapped ||
         (report.join_ms > joining_to_gain * report.detect_ms && report.heavy_ms < mostly_heavy * report.narrow_ms);
}

void FormChooser::go_to(StepForm form) {
  of(current_).wait = of(current_).period = 16;
  current_ = form;
}

void FormChooser::learn(const ExecutionReport& report, double work_ms, double load) {
  const bool is_small = work_ms < small_step_ms_;
  if (wanted_ != StepForm::automatic) next_ = is_small ? StepForm::caller : wanted_;
  if (wanted_ != StepForm::automatic || (report.issues & bit(StepIssue::ended_early)) != 0) return;
  Form& ran = of(report.form);
  const double cost = report.detect_ms / std::max(load, 1.0);
  ran.costs = {ran.costs[1], cost};
  total_ms_ += report.detect_ms;
  const bool on_trial = tried_ != current_ && report.form == tried_;
  if (on_trial) lost_ms_ += std::max(0.0, report.detect_ms - of(current_).cost() * std::max(load, 1.0));
  for (Form& form : all_) form.wait = std::max(0, form.wait - 1);

  if (is_small) {
    current_ = tried_ = next_ = StepForm::caller;
    return;
  }
  if (tried_ != current_) {
    if (!may_be(tried_, report, work_ms))
      end_trial(false);
    else if (!may_stay(report, work_ms))
      end_trial(true);
    else if (on_trial && cost > hopeless * of(current_).most())
      end_trial(false);
    else if (of(next_).has_two())
      go_on_trying();
    if (tried_ != current_) return;
  }
  if (!may_stay(report, work_ms)) go_to(StepForm::overlapped);
  tried_ = next_ = current_;
  plan_trial(report, work_ms, load);
}

/// The tried form and the current form have run for two steps each, one of the two just now.
void FormChooser::go_on_trying() {
  if (next_ == tried_) {
    // Sharing must be worth it: at equal times the caller alone is chosen.
    const double at_least = tried_ == StepForm::caller ? 1 / better : better;
    const bool gained = of(tried_).cost() < at_least * of(current_).cost();
    if (!gained || ++gains_ == gains_to_change) {
      end_trial(gained);
      return;
    }
  }
  next_ = next_ == tried_ ? current_ : tried_;
  of(next_).forget();
}

void FormChooser::end_trial(bool gained) {
  Form& tried = of(tried_);
  if (gained) {
    go_to(tried_);
    return;
  }
  tried.wait = tried.period;
  tried.period = std::min(2 * tried.period, tried_ == StepForm::caller ? longest_off_caller : longest_period);
  tried_ = current_;
}

void FormChooser::plan_trial(const ExecutionReport& report, double work_ms, double load) {
  // Beyond that fraction one step's time may be lost, so that a form of about equal time is tried soon.
  if (!of(current_).has_two() || lost_ms_ > most_lost * total_ms_ + report.detect_ms) return;
  for (const StepForm form : {StepForm::ordered, StepForm::overlapped, StepForm::caller}) {
    Form& other = of(form);
    if (form == current_ || !may_be(form, report, work_ms) || !may_pay(form, report)) continue;
    const bool other_load = load > changed_load * other.load || changed_load * load < other.load;
    if (other.wait > 0 && !other_load) continue;
    other.load = load;
    other.forget();
    tried_ = next_ = form;
    gains_ = 0;
    return;
  }
}

}  // namespace tandem
