// Exact times of impact of moving features, to judge the library's.
#pragma once
#include <array>
#include <memory>

#include "tandem/narrowphase/pose.h"

namespace tandem::reference {

/// Two features whose vertices move on straight lines: a point (vertex 0) and a triangle, or two edges (0 1 and 2 3).
struct ImpactQuery {
  bool edges = false;
  std::array<Vec3, 4> from, to;  ///< positions at t = 0 and t = 1
};

/// All times at which two such features may begin or cease to intersect, in integers: no rounding for any input.
class ExactImpact {
 public:
  explicit ExactImpact(const ImpactQuery& query);
  ~ExactImpact();
  ExactImpact(ExactImpact&&) noexcept;

  bool hit() const;                 ///< they intersect at some t in [0, 1]
  bool hit_before(double t) const;  ///< they intersect at some time in [0, t)

 private:
  struct Insides;
  std::unique_ptr<Insides> insides_;
};

}  // namespace tandem::reference
