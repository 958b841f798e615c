// Many configurations of a robot's links against a world and against one another.
#pragma once
#include <span>
#include <utility>
#include <vector>

#include "queries/query_world.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// Numbers of a batch that one thread works with.
struct CheckWorkspace {
  std::vector<Aabb> boxes;  // of the links, grown by the margin
  // What was hit last is looked at first: neighbours on a motion mostly hit the same. A link and a body, or two links.
  std::uint32_t link = 0, other = 0;
  enum : std::uint8_t { nothing, a_body, a_link } last = nothing;
};

class ConfigurationCheck {
 public:
  /// Throws std::invalid_argument that names what does not fit. All arguments must outlive it.
  ConfigurationCheck(const QueryWorld& world, const NarrowPhase& narrow, std::span<const Shape> links,
                     std::span<const Pose> poses, const PairTable& self, const BatchOptions& options);

  void verdicts(std::span<Verdict> out) const;
  void clearances(std::span<double> out, double cutoff) const;

 private:
  using Workspace = CheckWorkspace;

  template <class One>
  void each(std::size_t items, const One& one) const;
  bool out_of_time() const;
  const Pose* configuration(std::size_t i) const;
  Verdict motion(std::size_t first, Workspace& work) const;
  bool hit(std::size_t configuration, Workspace& work) const;
  bool hits_again(const Pose* poses, const Workspace& work) const;
  bool hits_link(const Pose* poses, Workspace& work) const;
  bool hits_body(const Pose* poses, Workspace& work) const;
  bool touch(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) const;
  bool is_checked(std::uint32_t link, std::uint32_t body) const;
  double clearance(std::size_t configuration, double cutoff, Workspace& work) const;

  const QueryWorld& world_;
  const NarrowPhase& narrow_;
  const std::span<const Shape> links_;
  const std::span<const Pose> poses_;
  const BatchOptions& options_;
  std::size_t configurations_ = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> self_;  // pairs of links
  std::vector<std::size_t> order_;                             // of a motion's configurations: the middle first
};

}  // namespace tandem
