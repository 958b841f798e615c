// Continuous check of links that move between configurations: certified free, or a first contact.
#include <algorithm>

#include "queries/configuration_check.h"
#include "scene/swept_boxes.h"

namespace tandem {
namespace {

/// The box of all shapes between two boxes whose points deviate from straight lines by at most `bulge`.
Aabb between(const Aabb& a, const Aabb& b, double bulge) {
  Aabb box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.lo[k] = round_down(std::min(a.lo[k], b.lo[k]) - bulge);
    box.hi[k] = round_up(std::max(a.hi[k], b.hi[k]) + bulge);
  }
  return box;
}

}  // namespace

bool ConfigurationCheck::meets_body(const PoseList& poses, std::uint32_t link, std::uint32_t body,
                                    const Workspace& work) const {
  const std::size_t n = links_.size(), stretches = options_.configurations_a_motion - 1;
  const Motion still{world_.pose(body), world_.pose(body)};
  const bool bounded = world_.shape(body).is_bounded();
  for (std::size_t k = 0; k < stretches; ++k) {
    if (bounded && !overlap(work.stretches[link * stretches + k], world_.box(body))) continue;
    const Motion motion{poses[k * n + link], poses[(k + 1) * n + link]};
    if (narrow_.time_of_impact(setup_->grown[link], motion, world_.shape(body), still)) return true;
  }
  return false;
}

bool ConfigurationCheck::meet_links(const PoseList& poses, std::uint32_t a, std::uint32_t b,
                                    const Workspace& work) const {
  const std::size_t n = links_.size(), stretches = options_.configurations_a_motion - 1;
  for (std::size_t k = 0; k < stretches; ++k) {
    if (!overlap(work.stretches[a * stretches + k], work.stretches[b * stretches + k])) continue;
    const Motion motion_a{poses[k * n + a], poses[(k + 1) * n + a]}, motion_b{poses[k * n + b], poses[(k + 1) * n + b]};
    // One of the two shapes is grown by the margin.
    if (narrow_.time_of_impact(setup_->grown[a], motion_a, links_[b], motion_b)) return true;
  }
  return false;
}

/// True if the motion between two configurations touches, given that neither configuration does.
bool ConfigurationCheck::hits_in_between(const PoseList& poses, Workspace& work) const {
  const std::size_t n = links_.size(), count = options_.configurations_a_motion, stretches = count - 1;
  work.stretches.resize(n * stretches);
  for (std::uint32_t link = 0; link < n; ++link) {
    const double reach = setup_->boxes[link].reach();
    Aabb swept = work.boxes.swept(link);
    for (std::size_t k = 0; k < stretches; ++k) {
      const double off = bulge({poses[k * n + link], poses[(k + 1) * n + link]}, reach);
      const Aabb box = between(work.boxes.box(link, k), work.boxes.box(link, k + 1), off);
      work.stretches[link * stretches + k] = box;
      swept = between(swept, box, 0);
    }
    work.bodies.assign(world_.unbounded().begin(), world_.unbounded().end());
    world_.tree().overlapping(swept, work.bodies);
    for (const std::uint32_t body : work.bodies)
      if (is_checked(link, body, work) && meets_body(poses, link, body, work)) return true;
  }
  return std::any_of(setup_->self.begin(), setup_->self.end(),
                     [&](const auto& pair) { return meet_links(poses, pair.first, pair.second, work); });
}

}  // namespace tandem
