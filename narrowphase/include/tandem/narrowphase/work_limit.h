// Limits that end queries early.
#pragma once
#include <chrono>
#include <functional>
#include <stdexcept>
#include <stop_token>

#include "tandem/narrowphase/answer.h"

namespace tandem {

/// A limit that ends work on a pair with a mesh, or on a time of impact, before it is done. It is checked when the pair
/// is begun and then every few hundred boxes or triangles, by every thread that works on the pair, and while a mesh's
/// hull is built; two convex shapes at rest check it only where large hulls are deep in each other. Stopped work is
/// marked (Status::stopped) or thrown (WorkStopped), none of its results are kept, and the next query is not affected.
/// May be changed between queries, not during one.
struct WorkLimit {
  std::stop_token stop{};
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  std::function<bool()>
      ended{};  ///< A user's condition, called from all threads that work; once true it must stay true

  bool reached() const;
};

/// Thrown when the limit is reached by a function whose result cannot be marked.
struct WorkStopped : std::runtime_error {
  WorkStopped() : std::runtime_error("stopped: the work limit was reached before the answer was there") {}
};

/// The answer, unless it was stopped: then throws WorkStopped.
inline const PairAnswer& unless_stopped(const PairAnswer& answer) {
  if (answer.status == Status::stopped) throw WorkStopped();
  return answer;
}

}  // namespace tandem
