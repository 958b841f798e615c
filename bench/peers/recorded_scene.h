#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/engine/scene.h"

namespace tandem::bench {

/// Poses of all bodies in successive steps. Contestants that keep something from step to step see the first few without
/// being timed.
struct Stretch {
  std::size_t first_step = 0;
  std::vector<std::vector<Pose>> poses;  ///< [step][body index]
};

/// A scene and the poses it went through, from the fall over the impact into the pile.
struct RecordedScene {
  std::string name;
  Scene scene;
  std::size_t steps = 0;  ///< simulated
  std::vector<Stretch> stretches;
};

struct PeersScene {
  std::string_view name;
  std::string_view text;
  std::string_view builtin;
  std::size_t bodies;
  bool hulls;         ///< the meshes that move are replaced by their convex hulls
  std::size_t timed;  ///< steps of 400 that are timed
};

/// The paper's seven.
std::span<const PeersScene> peers_scenes();

inline constexpr std::size_t untimed_steps = 2;  ///< at the start of each stretch
inline constexpr std::size_t stretch_steps = 8;  ///< that are timed

/// Simulates the scene (all steps exact) and keeps stretches spread evenly over the steps, all of them where so many
/// steps are to be timed. `bodies` 0: the paper's number.
RecordedScene simulate(const PeersScene& scene, std::size_t bodies, std::size_t steps, std::size_t timed);

/// From a file of `tandem run --record`; at most `steps` of it. Throws InputError.
RecordedScene read_recorded(const std::string& file, std::size_t steps, std::size_t timed);

}  // namespace tandem::bench
