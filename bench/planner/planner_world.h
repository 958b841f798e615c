// A planner's questions: arms of seven links among obstacles, random configurations and motions.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "tandem/engine/pair_table.h"
#include "tandem/engine/scene.h"

namespace tandem::bench {

enum class LinkKind : std::uint8_t { capsules, hulls, meshes };

struct PlannerWorld {
  std::string name;
  Scene obstacles;  ///< static bodies
  std::vector<Shape> links;
  PairTable self;            ///< pairs of links that are tested: those that are not neighbours in an arm
  std::vector<Pose> random;  ///< configurations x links
  std::vector<Pose> motions; ///< configurations x links; `a_motion` that follow one another are a motion
  static constexpr std::size_t a_motion = 64;

  std::size_t configurations() const { return random.size() / links.size(); }
};

/// `arms`: 1 or 2. As many boxes, cylinders, hulls of 16 points and meshes of 80 triangles among the obstacles.
PlannerWorld planner_world(LinkKind kind, int arms, int obstacles, std::size_t configurations);

}  // namespace tandem::bench
