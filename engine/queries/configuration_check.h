// Many configurations of a robot's links against a world and against one another.
#pragma once
#include <span>
#include <utility>
#include <vector>

#include "queries/link_boxes.h"
#include "queries/query_world.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Numbers of a batch that one thread works with.
struct CheckWorkspace {
  BoxArray boxes;                     // of the links, grown by the margin: one link's in all configurations, then the next's
  std::vector<Aabb> swept;            // of each link, in all of them
  std::vector<std::uint32_t> bodies;  // whose boxes a link's swept box meets
  std::vector<Aabb> stretches;        // of each link's way from one configuration of a motion to the next
  struct Suspects {
    std::uint32_t link, other;
    bool is_body;
    std::uint32_t first, last;  // of `near`
  };
  std::vector<Suspects> suspects;  // pairs whose boxes overlap
  std::vector<std::uint32_t> near;  // in which configurations
  // What was hit last is looked at first: neighbours mostly hit the same. A link and a body, or two links.
  Suspects last_hit{};
  bool has_last_hit = false;
};

class ConfigurationCheck {
 public:
  /// Throws std::invalid_argument that names what does not fit. All arguments must outlive it.
  ConfigurationCheck(const QueryWorld& world, const NarrowPhaseOptions& narrow, std::span<const Shape> links,
                     std::span<const Pose> poses, const PairTable& self, const BatchOptions& options);

  void verdicts(std::span<Verdict> out) const;
  void first_hits(std::span<FirstHit> out) const;
  void clearances(std::span<double> out, double cutoff) const;

 private:
  using Workspace = CheckWorkspace;

  template <class Block>
  void each_block(std::size_t items, std::size_t most, const Block& block) const;
  static WorkLimit limit_of(const BatchOptions& options, const WorkLimit* of_all);
  static NarrowPhaseOptions limited(NarrowPhaseOptions options, const WorkLimit& limit);
  bool out_of_time() const { return limit_.reached(); }
  Verdict motion(std::size_t motion, Workspace& work) const;
  const Pose* take_boxes(std::size_t first, std::size_t count, double margin, Workspace& work) const;
  bool hits_again(const Pose* poses, const Workspace& work) const;
  bool hits_link(const Pose* poses, std::size_t place, std::size_t count, Workspace& work) const;
  bool hits_body(const Pose* poses, std::size_t place, std::size_t count, Workspace& work) const;
  FirstHit first_hit(std::size_t motion, Workspace& work) const;
  bool first_body(const Pose* pose, std::uint32_t link, const Aabb& box, Workspace& work, BodyId& body) const;
  void suspect_links(Workspace& work) const;
  void suspect_bodies(Workspace& work) const;
  template <class Overlaps>
  void add_suspects(std::uint32_t link, std::uint32_t other, bool is_body, Workspace& work, const Overlaps& overlaps) const;
  bool hits_between(const Pose* poses, const Workspace& work, const CheckWorkspace::Suspects& pair, std::size_t first,
                    std::size_t last) const;
  double may_move(const CheckWorkspace::Suspects& pair, const Pose* from, const Pose* to) const;
  bool hits_on_the_way(const Pose* poses, Workspace& work) const;
  bool meets_body(const Pose* poses, std::uint32_t link, std::uint32_t body, const Workspace& work) const;
  bool meet_links(const Pose* poses, std::uint32_t a, std::uint32_t b, const Workspace& work) const;
  bool touch(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) const;
  bool is_checked(std::uint32_t link, std::uint32_t body) const;
  double clearance(const Pose* poses, std::size_t place, std::size_t count, double cutoff, const Workspace& work) const;

  const QueryWorld& world_;
  const WorkLimit limit_;
  const NarrowPhase narrow_;
  const std::span<const Shape> links_;
  const std::span<const Pose> poses_;
  const BatchOptions& options_;
  std::size_t configurations_ = 0;
  std::vector<Shape> grown_;  // the links with the margin about them, where motions are continuous
  std::vector<LinkBox> link_boxes_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> self_;  // pairs of links
};

}  // namespace tandem
