#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tandem/engine/pipeline.h"
#include "tandem/engine/scene.h"

namespace tandem::bench {

/// One way to detect, by name.
struct Contestant {
  std::string name;
  PipelineOptions options;
  Timeline* timeline = nullptr;  ///< what it records to
  /// More than one: so many pipelines of these options, each on a thread of its own, detect the same step at once, and
  /// the time is what one of them took over their number: what this machine's cores give when nothing is shared.
  int copies = 1;
};

/// What one contestant did in one step.
struct Turn {
  std::size_t contestant;
  int step;
  const StepReport& report;
  const Scene& scene;  ///< as it was detected on
};

/// Simulates a scene and lets every contestant detect on each step's poses in turn, in one process; the order
/// rotates; `repeat` rounds a step. The first contestant's contacts move the bodies. Between turns the caller works for
/// a moment, as a simulation would, so that no contestant starts on the threads that the one before left spinning.
/// The margin is the one that the response needs. Throws std::runtime_error when two contestants disagree on the
/// contacts of a step.
void contest(Scene scene, const std::vector<Contestant>& contestants, int steps, int repeat,
             const std::function<void(const Turn&)>& on_turn, const std::function<void(int)>& on_step);

/// The executors on `threads` threads (0: the cores), and sequential copies on as many; all else as in `base`.
std::vector<Contestant> executors(int threads, const PipelineOptions& base);

}  // namespace tandem::bench
