// How much a query has worked since its limit was last checked.
#pragma once
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Of one thread. Checked at are the first work of all, so that searches of many short queries end, too, and then every
/// `between` units: a unit is some 100 ns, the time that a node of a hierarchy takes, more or less. A check takes some
/// 50 ns, and what is counted as a unit may take several.
class WorkMeter {
 public:
  /// No limit: null. `unchecked`: the units before the first check, for what is mostly done within few.
  explicit WorkMeter(const WorkLimit* limit, int unchecked = 0) : limit_(limit), left_(unchecked) {}

  /// Before work of so many units. Throws WorkStopped once the limit is reached.
  void spend(int units = 1) {
    if ((left_ -= units) < 0) [[unlikely]]
      check_limit();
  }

  bool has_limit() const { return limit_ != nullptr; }

 private:
  static constexpr int between = 64;

  void check_limit();

  const WorkLimit* limit_;
  int left_;
};

}  // namespace tandem
