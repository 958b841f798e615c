// Contestants of the planner bench: libraries that answer a planner's queries.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <utility>
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
  /// The verdict of each configuration: free (0) or hit (1). Poses: configurations x links.
  virtual void check(std::span<const Pose> poses, std::span<std::uint8_t> hits) = 0;
  /// Checks motions, each so many configurations that follow one another: is all of it free?
  virtual void check_motions(std::span<const Pose> poses, std::span<std::uint8_t> hits) = 0;
  /// The least distance of each configuration, 0 where it hits. Not asked of Bullet, which has none.
  virtual void clearance(std::span<const Pose> poses, std::span<double> distances) = 0;
};

/// One that looks at configurations one by one, at a motion's from its start.
class OneByOnePlanner : public Planner {
 public:
  explicit OneByOnePlanner(const PlannerWorld& world) : links_(world.links.size()) {
    for (std::size_t i = 0; i < links_; ++i)
      for (std::size_t j = i + 1; j < links_; ++j)
        if (world.self.checked(i, j)) self_.push_back({i, j});
  }
  void check(std::span<const Pose> poses, std::span<std::uint8_t> hits) final {
    for (std::size_t i = 0; i < hits.size(); ++i) hits[i] = hit(&poses[i * links_]);
  }
  void check_motions(std::span<const Pose> poses, std::span<std::uint8_t> hits) final {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      hits[i] = 0;
      for (std::size_t k = 0; k < PlannerWorld::a_motion && hits[i] == 0; ++k)
        hits[i] = hit(&poses[(i * PlannerWorld::a_motion + k) * links_]);
    }
  }

 protected:
  virtual bool hit(const Pose* poses) = 0;
  const std::vector<std::pair<std::size_t, std::size_t>>& self() const { return self_; }

 private:
  std::size_t links_;
  std::vector<std::pair<std::size_t, std::size_t>> self_;
};

using Planners = std::vector<std::unique_ptr<Planner>>;

// The world outlives them.
std::unique_ptr<Planner> tandem_planner(const PlannerWorld& world, int threads);
std::unique_ptr<Planner> fcl_planner(const PlannerWorld& world);
std::unique_ptr<Planner> bullet_planner(const PlannerWorld& world);  ///< where it is installed

}  // namespace tandem::bench
