// Scenes with recorded poses, for the benches of whole steps.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/engine/scene.h"

namespace tandem::bench {

/// The poses of all bodies in successive steps. The first few steps are not timed, so that contestants that keep
/// results from step to step can begin.
struct Stretch {
  std::size_t first_step = 0;
  std::vector<std::vector<Pose>> poses;  ///< [step][body index]
};

/// A scene and its recorded poses, from the fall over the impact into the pile.
struct RecordedScene {
  std::string name;
  Scene scene;
  std::size_t steps = 0;  ///< simulated in all
  std::vector<Stretch> stretches;
};

struct PeersScene {
  std::string_view name;
  std::string_view text;
  std::string_view builtin;
  std::size_t bodies;
  bool hulls;         ///< the meshes that move are replaced by their convex hulls
  std::size_t timed;  ///< number of steps, of 400, that are timed
};

/// The seven scenes of this bench: the paper's and variants.
std::span<const PeersScene> peers_scenes();

inline constexpr std::size_t untimed_steps = 2;  ///< at the start of each stretch
inline constexpr std::size_t stretch_steps = 8;  ///< timed steps of each stretch

/// Simulates the scene (all steps exact) and keeps stretches spread evenly over the steps, or all steps where as many
/// are to be timed. `bodies` 0: the paper's number.
RecordedScene simulate(const PeersScene& scene, std::size_t bodies, std::size_t steps, std::size_t timed);

/// Reads a file of `tandem run --record`, at most `steps` of it. Throws InputError.
RecordedScene read_recorded(const std::string& file, std::size_t steps, std::size_t timed);

}  // namespace tandem::bench
