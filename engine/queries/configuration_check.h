// Many configurations of a robot's links against a world and against one another.
#pragma once
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "queries/limit_watch.h"
#include "queries/link_boxes.h"
#include "queries/query_world.h"
#include "tandem/broadphase/scratch_pool.h"
#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Data prepared for a batch.
struct CheckSetup {
  std::vector<Shape> grown;                 // the links with the margin about them, where motions are continuous
  std::vector<LinkBox> boxes, grown_boxes;  // of the links; the second enlarged by the margin
  std::vector<std::pair<std::uint32_t, std::uint32_t>> self;  // pairs of links

  std::size_t memory() const;  // bytes beside itself, shapes not counted
};

/// The working memory of one thread in a batch.
struct CheckWorkspace {
  std::vector<Pose> poses;             // of one configuration
  LinkBoxes boxes;                     // grown by the margin
  IntervalBits::EndsOfBoxes ends;      // of the boxes, if the world keeps bits
  std::vector<std::uint64_t> meeting;  // configurations in which the boxes of two links meet, by pairs of links
  LimitWatch watch;
  std::vector<std::uint32_t> bodies;  // whose boxes overlap a link's swept box
  std::vector<Aabb> stretches;        // each link's swept boxes between neighbouring configurations of a motion
  struct Suspects {
    std::uint32_t link, other;
    bool is_body;
    std::uint32_t first, last;  // indices into `near`
  };
  std::vector<Suspects> suspects;                         // pairs whose boxes overlap
  std::vector<std::uint32_t> near;                        // the configurations of these pairs
  std::vector<std::pair<double, std::uint32_t>> nearest;  // by link: its box's distance from the nearest
  // The last pair that touched, a link and a body or two links, is tested first: neighbours mostly touch the same.
  Suspects last_hit{};
  bool has_last_hit = false;

  std::size_t memory() const;  // bytes held beside itself
};

/// Memory that batches leave to the next ones.
struct CheckMemory {
  detail::ScratchPool<CheckSetup> setups;
  detail::ScratchPool<CheckWorkspace> workspaces;

  std::size_t memory() const;  // bytes of what no batch uses
};

class ConfigurationCheck {
 public:
  /// Throws std::invalid_argument that names what does not fit. All arguments must outlive it.
  ConfigurationCheck(const QueryWorld& world, const NarrowPhaseOptions& narrow, std::span<const Shape> links,
                     const BatchPoses& poses, const PairTable& self, const BatchOptions& options, CheckMemory& memory);

  void verdicts(std::span<Verdict> out) const;
  void first_hits(std::span<FirstHit> out) const;
  void clearances(std::span<double> out, double cutoff) const;

 private:
  using Workspace = CheckWorkspace;

  void prepare_links() const;
  bool has_link_boxes() const;
  template <class Block>
  void each_block(std::size_t items, std::size_t most, const Block& block) const;
  static WorkLimit limit_of(const BatchOptions& options, const WorkLimit* of_all);
  static NarrowPhaseOptions limited(NarrowPhaseOptions options, const WorkLimit& limit);
  bool out_of_time() const { return limit_.reached(); }
  /// The number of motions that are tested between two checks of the limit: `some` blocks of 64 configurations.
  std::size_t at_once(std::size_t some) const {
    return std::max<std::size_t>(1, some * PoseNumbers::count / options_.configurations_a_motion);
  }
  bool motion_hits(std::size_t motion, Workspace& work) const;
  PoseList take_boxes(std::size_t first, std::size_t count, std::span<const LinkBox> boxes, Workspace& work) const;
  bool is_near(std::size_t place, std::uint32_t link, const Pose& pose, std::uint32_t body,
               const Workspace& work) const;
  template <class Visit>
  bool visit_bodies(std::uint32_t link, std::size_t place, const Workspace& work, const Visit& visit) const;
  void find_ends(Workspace& work) const;
  void meet_links(Workspace& work) const;
  bool hits_again(const PoseList& poses, std::size_t place, Workspace& work) const;
  bool hits_link(const PoseList& poses, std::size_t place, Workspace& work) const;
  bool hits_body(const PoseList& poses, std::size_t place, Workspace& work) const;
  FirstHit first_hit(const PoseList& poses, std::size_t place, Workspace& work) const;
  bool first_body(const Pose& pose, std::size_t place, std::uint32_t link, Workspace& work, BodyId& body) const;
  void suspect_links(Workspace& work) const;
  void suspect_bodies(Workspace& work) const;
  template <class Meeting>
  void add_suspects(std::uint32_t link, std::uint32_t other, bool is_body, Workspace& work,
                    const Meeting& meeting) const;
  bool hits_between(const PoseList& poses, Workspace& work, const CheckWorkspace::Suspects& pair, std::size_t first,
                    std::size_t last) const;
  double may_move(const CheckWorkspace::Suspects& pair, const PoseList& from, const PoseList& to) const;
  bool hits_in_between(const PoseList& poses, Workspace& work) const;
  bool meets_body(const PoseList& poses, std::uint32_t link, std::uint32_t body, const Workspace& work) const;
  bool meet_links(const PoseList& poses, std::uint32_t a, std::uint32_t b, const Workspace& work) const;
  bool touch(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Workspace& work) const;
  bool is_checked(std::uint32_t link, std::uint32_t body, Workspace& work) const;
  double clearance(const PoseList& poses, std::size_t place, double cutoff, Workspace& work) const;
  void order_links(std::size_t place, double cutoff, Workspace& work) const;

  const QueryWorld& world_;
  const WorkLimit limit_;
  const NarrowPhase narrow_;
  const std::span<const Shape> links_;
  const BatchPoses& poses_;
  const BatchOptions& options_;
  std::size_t configurations_ = 0;
  detail::ScratchPool<CheckWorkspace>& workspaces_;
  const detail::ScratchPool<CheckSetup>::Lease setup_;
};

}  // namespace tandem
