// The frequency at which a query checks its time limit.
#pragma once
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Checks the limit before the first unit of work and then every few microseconds: a pair takes about one, a skipped
/// body a few dozen nanoseconds. Pairs with meshes check it themselves.
class LimitWatch {
 public:
  static constexpr unsigned a_candidate = 1, a_pair = 16, between_checks = 64;
  /// The units of a pair: one whose hulls have many vertices, or of many cells, may take dozens of microseconds.
  static unsigned of_pair(const Shape& a, const Shape& b) {
    constexpr std::size_t many = 256;
    const auto count = [](const Shape& shape) { return shape.vertices().size() + shape.cells().size(); };
    return count(a) + count(b) < many ? a_pair : between_checks;
  }

  /// Null: no limit.
  explicit LimitWatch(const WorkLimit* limit = nullptr) : limit_(limit) {}

  /// Accounts for the next `units` of work; throws WorkStopped once the limit is reached.
  void spend(unsigned units) {
    if (limit_ == nullptr) return;
    if (units > left_) {
      left_ = between_checks;
      if (limit_->reached()) throw WorkStopped();
    }
    left_ -= units;
  }

 private:
  const WorkLimit* limit_;
  unsigned left_ = 0;
};

}  // namespace tandem
