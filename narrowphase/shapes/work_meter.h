// Counts the work of a query since its limit was last checked.
#pragma once
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// The work meter of one thread. Checks the limit at the first work of all, so that searches of many short queries end,
/// too, and then every `between` units with a deadline, four times that without. A unit is about 100 ns, the time of a
/// node of a hierarchy, but may take several times that; a check takes some 50 ns.
class WorkMeter {
 public:
  /// Null: no limit. `unchecked`: units before the first check, for work that is usually done within few.
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
