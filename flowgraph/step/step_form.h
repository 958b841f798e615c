// The choice of a step's form.
#pragma once
#include <array>
#include <cstddef>
#include <limits>

#include "tandem/flowgraph/report.h"

namespace tandem {

/// Chooses the form of the next step from the times of the steps before it. Another form is tried for two steps now and
/// then, and kept if it was faster than the two steps before it, and once more faster after two further steps of the
/// old form: a verified change, like the balance of threads, by a gain that noise does not repeat. A form that did not
/// help is tried again after twice as many steps, or when the load has changed, and only while the cost of trials is a
/// small fraction of all steps' time.
class FormChooser {
 public:
  /// `wanted`: automatic, or the form of all steps that are not too small for it. `small_step_ms`: a step is too small
  /// to be shared if the step before it had less work; 0: no step is. `can_order`: StepForm::ordered may be chosen.
  FormChooser(StepForm wanted, double small_step_ms, bool can_order);
  StepForm next() const { return next_; }
  /// `work_ms`: busy time of the step, all threads; `load`: what its time is proportional to, such as the number of
  /// pairs.
  void learn(const ExecutionReport& report, double work_ms, double load);

 private:
  static constexpr std::size_t forms = 4;
  static constexpr double unknown = std::numeric_limits<double>::infinity();
  struct Form {
    std::array<double, 2> costs{unknown, unknown};  // time over load in the last two steps of this form
    int wait = 0, period = 8;                       // steps to the next trial, and between two trials
    double load = 0;                                // the load at the last trial
    void forget() { costs = {unknown, unknown}; }
    double cost() const { return costs[0] < costs[1] ? costs[0] : costs[1]; }
    double most() const { return costs[0] < costs[1] ? costs[1] : costs[0]; }
    bool has_two() const { return costs[0] != unknown && costs[1] != unknown; }
  };

  Form& of(StepForm form) { return all_[static_cast<std::size_t>(form)]; }
  bool may_be(StepForm form, const ExecutionReport& report, double work_ms) const;
  bool may_stay(const ExecutionReport& report, double work_ms);
  bool may_pay(StepForm form, const ExecutionReport& report) const;
  void go_to(StepForm form);
  void go_on_trying();
  void end_trial(bool gained);
  void plan_trial(const ExecutionReport& report, double work_ms, double load);

  // The first step is shared, as nothing is known of it; afterwards a step that the caller could run alone is shared
  // only once sharing has helped.
  StepForm wanted_, current_ = StepForm::caller, next_ = StepForm::overlapped;
  StepForm tried_ = StepForm::caller;  // the form on trial, if another than the current one
  int gains_ = 0;                      // comparisons in a row that the form on trial has won
  double total_ms_ = 0, lost_ms_ = 0;  // time of all steps, and of trials of a form that was slower
  bool can_order_;
  double small_step_ms_;
  std::array<Form, forms> all_;
};

}  // namespace tandem
