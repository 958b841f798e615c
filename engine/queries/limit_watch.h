// How often a query asks whether its time is over.
#pragma once
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Checks the limit before the first piece of work and then after some microseconds of it: a pair may take one, a
/// body that is left out a few dozen nanoseconds. Pairs with meshes check it themselves while they are worked on.
class LimitWatch {
 public:
  static constexpr unsigned a_candidate = 1, a_pair = 16, between_checks = 64;
  /// Of a pair whose hulls have many vertices: each may take dozens of microseconds.
  static unsigned of_pair(const Shape& a, const Shape& b) {
    constexpr std::size_t many = 256;
    return a.vertices().size() + b.vertices().size() < many ? a_pair : between_checks;
  }

  /// Null: no limit.
  explicit LimitWatch(const WorkLimit* limit = nullptr) : limit_(limit) {}

  /// Before work of so many units; throws WorkStopped once the limit is reached.
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
