// Contests of pipelines: several ways to detect the same scene, timed in turn.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tandem/engine/pipeline.h"
#include "tandem/engine/scene.h"

namespace tandem::bench {

/// A way to detect, with a name.
struct Contestant {
  std::string name;
  PipelineOptions options;
  Timeline* timeline = nullptr;  ///< the timeline that it records, if any
  /// Number of copies. With several, as many pipelines of these options, each on a thread of its own, detect the same
  /// step at the same time, and the time is that of one over their number: the most that this machine's cores give when
  /// nothing is shared.
  int copies = 1;
};

/// The result of one contestant in one step.
struct Turn {
  std::size_t contestant;
  int step;
  const StepReport& report;
};

/// The rounds of a contest.
struct Rounds {
  int steps;
  int repeat = 1;  ///< rounds over the same poses
  /// Steps that a contestant detects in a row before the next one takes its turn, as in a simulation, where the caches
  /// of all its threads hold what the step before left. With more than one, the first of them is not reported.
  int stretch = 1;
};

/// Simulates a scene and lets every contestant detect on its poses in turn, in one process, in an order shuffled each
/// round, from another core each round. The first contestant's contacts move the bodies. Before each step the caller
/// works for a moment, as a simulation would, so that no contestant profits from threads that the one before left
/// spinning. The margin is the one that the response needs. Calls `on_turn` as steps are detected, `on_step` after all
/// turns of a stretch, for each of its steps. Throws std::runtime_error when two contestants disagree on the contacts
/// of a step.
void contest(Scene scene, const std::vector<Contestant>& contestants, const Rounds& rounds,
             const std::function<void(const Turn&)>& on_turn, const std::function<void(int)>& on_step);

/// The executors on `threads` threads (0: all cores), and as many sequential copies; other options as in `base`.
std::vector<Contestant> executors(int threads, const PipelineOptions& base);

}  // namespace tandem::bench
