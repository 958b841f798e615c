// The steps from one check of measured costs to the next (Avril, Gouranton, Arnaldi, ICAT 2010, section 4).
#pragma once
#include <algorithm>

namespace tandem {

/// Checks are frequent at first, become rare while nothing changes, and frequent again after a change. Every change is
/// verified at the next check: if what is measured did not become less, it is to be taken back.
class ControlStep {
 public:
  explicit ControlStep(int longest) : longest_(longest) {}

  int steps() const { return steps_; }                ///< from the last check to the next
  bool verifies() const { return verifies_; }         ///< the next check verifies a change
  double measured_before() const { return before_; }  ///< the last change

  /// A check changes nothing.
  void keep() { steps_ = std::min(2 * steps_, longest_); }
  /// A check that measured so much changes something, which is verified after so many steps.
  void change(double measured, int next = 1) {
    steps_before_ = steps_;
    before_ = measured;
    verifies_ = true;
    steps_ = next;
  }
  /// Whether the change stays, by what is measured with it.
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
