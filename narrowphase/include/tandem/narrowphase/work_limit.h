#pragma once
#include <chrono>
#include <functional>
#include <stdexcept>
#include <stop_token>

#include "tandem/narrowphase/answer.h"

namespace tandem {

/// When work on a pair with a mesh, or on a time of impact, ends before it is done. It is looked at when the pair is
/// begun and then every few hundred boxes or triangles, by every thread that works on the pair, and while a mesh's hull
/// is built; two convex shapes that stand still look only where large hulls are deep in each other. What was stopped is
/// marked (Status::stopped) or thrown (WorkStopped), nothing of it is kept, and the next query is not affected. May be
/// changed between queries, not during one.
struct WorkLimit {
  std::stop_token stop{};
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::function<bool()>
      ended{};  ///< a reason of one's own, asked from all threads that work; once true it must stay so

  bool reached() const;
};

/// Thrown where the limit was reached by what returns nothing that could be marked.
struct WorkStopped : std::runtime_error {
  WorkStopped() : std::runtime_error("stopped: the work limit was reached before the answer was there") {}
};

/// The answer, if it is a whole one.
inline const PairAnswer& unless_stopped(const PairAnswer& answer) {
  if (answer.status == Status::stopped) throw WorkStopped();
  return answer;
}

}  // namespace tandem
