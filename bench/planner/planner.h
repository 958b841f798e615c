// Libraries that answer a planner's questions.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planner/planner_world.h"

namespace tandem::bench {

/// A library set up for a world as a careful user would: obstacles in a hierarchy built once, links placed for each
/// configuration. Ends a configuration at its first hit.
class Planner {
 public:
  virtual ~Planner() = default;
  virtual std::string name() const = 0;
  virtual int threads() const { return 1; }
  /// Whether each configuration is free (0) or hits (1). Poses: configurations x links.
  virtual void check(std::span<const Pose> poses, std::span<std::uint8_t> hits) = 0;
  /// The same of motions, each so many configurations that follow one another: is all of it free?
  virtual void check_motions(std::span<const Pose> poses, std::span<std::uint8_t> hits) = 0;
  /// The least distance of each configuration, 0 where it hits. Not asked of Bullet, which has none.
  virtual void clearance(std::span<const Pose> poses, std::span<double> distances) = 0;
};

using Planners = std::vector<std::unique_ptr<Planner>>;

// The world outlives them.
std::unique_ptr<Planner> tandem_planner(const PlannerWorld& world, int threads);
std::unique_ptr<Planner> fcl_planner(const PlannerWorld& world);
std::unique_ptr<Planner> bullet_planner(const PlannerWorld& world);  ///< where it is installed

}  // namespace tandem::bench
