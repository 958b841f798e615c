// Control steps, at which measured costs are checked: how many steps lie between two checks (Avril, Gouranton, Arnaldi,
// ICAT 2010, section 4).
#pragma once
#include <algorithm>

namespace tandem {

/// The interval between checks: short at first, longer while nothing changes, short again after a change. Every change
/// is verified at the next check: if the measured cost has not become less, the change is to be taken back.
class ControlStep {
 public:
  explicit ControlStep(int longest) : longest_(longest) {}

  int steps() const { return steps_; }                ///< steps from the last check to the next
  bool verifies() const { return verifies_; }         ///< true: the next check verifies a change
  double measured_before() const { return before_; }  ///< the last change

  /// Notes that a check changed nothing.
  void keep() { steps_ = std::min(2 * steps_, longest_); }
  /// Notes that a check, at this measured cost, changed something, which is verified after so many steps.
  void change(double measured, int next = 1) {
    steps_before_ = steps_;
    before_ = measured;
    verifies_ = true;
    steps_ = next;
  }
  /// True if the change stays, given the cost measured with it.
  bool confirm(double measured) {
    verifies_ = false;
    const bool stays = measured < before_;
    steps_ = stays ? 1 : std::min(2 * steps_before_, longest_);
    return stays;
  }

 private:
  int longest_;
  int steps_ = 1, steps_before_ = 1;
  bool verifies_ = false;
  double before_ = 0;
};

}  // namespace tandem
