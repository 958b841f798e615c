#include "queries/configuration_check.h"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>

#include "scene/tolerances.h"

namespace tandem {
namespace {

[[noreturn]] void refuse(const std::string& what, std::size_t found, const std::string& allowed) {
  throw std::invalid_argument("configurations: " + what + " is " + std::to_string(found) + ", allowed: " + allowed);
}

/// Bisection order: the configurations of a motion that lie farthest from all that were looked at come first.
std::vector<std::size_t> bisection_order(std::size_t n) {
  std::vector<std::size_t> order;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, n}}, next;
  while (!open.empty()) {
    next.clear();
    for (const auto& [first, last] : open) {
      if (first == last) continue;
      const std::size_t middle = first + (last - first) / 2;
      order.push_back(middle);
      next.push_back({first, middle});
      next.push_back({middle + 1, last});
    }
    open.swap(next);
  }
  return order;
}

double box_distance(const Aabb& a, const Aabb& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double off = std::max({double{b.lo[k]} - a.hi[k], double{a.lo[k]} - b.hi[k], 0.0});
    sum += off * off;
  }
  return std::sqrt(sum);
}

}  // namespace

ConfigurationCheck::ConfigurationCheck(const QueryWorld& world, const NarrowPhase& narrow,
                                       std::span<const Shape> links, std::span<const Pose> poses,
                                       const PairTable& self, const BatchOptions& options)
    : world_(world), narrow_(narrow), links_(links), poses_(poses), options_(options) {
  const std::size_t n = links.size(), a_motion = options.configurations_a_motion;
  if (n == 0) refuse("the number of links", 0, ">= 1");
  if (poses.size() % n != 0) refuse("the number of poses", poses.size(), "a multiple of " + std::to_string(n) + " links");
  configurations_ = poses.size() / n;
  if (a_motion == 0 || configurations_ % a_motion != 0)
    refuse("configurations_a_motion", a_motion, "a divisor of " + std::to_string(configurations_));
  if (self.rows() != 0 && (self.rows() != n || self.columns() < n))
    refuse("the number of rows of the table of links", self.rows(), "0 or " + std::to_string(n) + ", and as many columns");
  if (options.world != nullptr && options.world->rows() != n)
    refuse("the number of rows of the table of bodies", options.world->rows(), std::to_string(n));
  for (std::size_t i = 0; i < n; ++i)
    if (!links[i].is_bounded())
      throw std::invalid_argument("configurations: link " + std::to_string(i) + " is a half-space, allowed: bounded shapes");
  for (std::uint32_t i = 0; i < self.rows(); ++i)
    for (std::uint32_t j = i + 1; j < n; ++j)
      if (self.checked(i, j)) self_.push_back({i, j});
  order_ = bisection_order(a_motion);
}

bool ConfigurationCheck::out_of_time() const {
  if (options_.stop.stop_requested()) return true;
  return options_.deadline != std::chrono::steady_clock::time_point::max() &&
         std::chrono::steady_clock::now() >= options_.deadline;
}

const Pose* ConfigurationCheck::configuration(std::size_t i) const {
  const Pose* poses = poses_.data() + i * links_.size();
  for (std::size_t link = 0; link < links_.size(); ++link)
    if (!is_valid(poses[link]))
      require_valid(poses[link], "configuration " + std::to_string(i) + ", link " + std::to_string(link));
  return poses;
}

/// one(item, workspace) for all items, in blocks on the threads of the caller's arena.
template <class One>
void ConfigurationCheck::each(std::size_t items, const One& one) const {
  tbb::enumerable_thread_specific<Workspace> workspaces([&] {
    Workspace work;
    work.boxes.resize(links_.size());
    return work;
  });
  std::atomic<std::size_t> done{0};
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t a_block = std::clamp<std::size_t>(items / (16 * threads), 1, 64);
  const std::size_t blocks = (items + a_block - 1) / a_block;
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    Workspace& work = workspaces.local();
    const std::size_t first = block * a_block, last = std::min(items, first + a_block);
    for (std::size_t i = first; i < last; ++i) one(i, work);
    if (options_.progress) options_.progress(done += last - first, items);
  });
}

bool ConfigurationCheck::touch(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) const {
  return options_.margin == 0
             ? narrow_.solve(a, pose_a, b, pose_b, Request::collide).collide
             : narrow_.solve(a, pose_a, b, pose_b, Request::distance).signed_distance <= options_.margin;
}

bool ConfigurationCheck::is_checked(std::uint32_t link, std::uint32_t body) const {
  if (options_.world != nullptr && body < options_.world->columns() && !options_.world->checked(link, body)) return false;
  return world_.admits(options_.filter, body);
}

bool ConfigurationCheck::hits_again(const Pose* poses, const Workspace& work) const {
  if (work.last == Workspace::nothing) return false;
  const Shape& link = links_[work.link];
  if (work.last == Workspace::a_link) return touch(link, poses[work.link], links_[work.other], poses[work.other]);
  return touch(link, poses[work.link], world_.shape(work.other), world_.pose(work.other));
}

bool ConfigurationCheck::hits_link(const Pose* poses, Workspace& work) const {
  for (const auto& [i, j] : self_)
    if (overlap(work.boxes[i], work.boxes[j]) && touch(links_[i], poses[i], links_[j], poses[j])) {
      work.link = i, work.other = j, work.last = Workspace::a_link;
      return true;
    }
  return false;
}

bool ConfigurationCheck::hits_body(const Pose* poses, Workspace& work) const {
  struct First final : BoxVisitor {
    const ConfigurationCheck& check;
    const Pose* poses;
    std::uint32_t link = 0, body = 0;
    First(const ConfigurationCheck& c, const Pose* p) : check(c), poses(p) {}
    bool visit(std::uint32_t index) override {
      body = index;
      return !(check.is_checked(link, index) &&
               check.touch(check.links_[link], poses[link], check.world_.shape(index), check.world_.pose(index)));
    }
  } first(*this, poses);
  for (; first.link < links_.size(); ++first.link) {
    const std::span<const std::uint32_t> unbounded = world_.unbounded();
    if (std::all_of(unbounded.begin(), unbounded.end(), [&](std::uint32_t index) { return first.visit(index); }) &&
        world_.tree().visit_overlapping(work.boxes[first.link], first))
      continue;
    work.link = first.link, work.other = first.body, work.last = Workspace::a_body;
    return true;
  }
  return false;
}

bool ConfigurationCheck::hit(std::size_t index, Workspace& work) const {
  const Pose* poses = configuration(index);
  if (hits_again(poses, work)) return true;
  for (std::size_t link = 0; link < links_.size(); ++link)
    work.boxes[link] = outward_box(links_[link], poses[link], options_.margin);
  return hits_link(poses, work) || hits_body(poses, work);
}

Verdict ConfigurationCheck::motion(std::size_t first, Workspace& work) const {
  for (const std::size_t i : order_) {
    if (out_of_time()) return Verdict::unknown;
    if (hit(first + i, work)) return Verdict::hit;
  }
  return Verdict::free;
}

void ConfigurationCheck::verdicts(std::span<Verdict> out) const {
  const std::size_t a_motion = order_.size(), motions = configurations_ / a_motion;
  if (out.size() != motions) refuse("the number of verdicts", out.size(), std::to_string(motions));
  each(motions, [&](std::size_t i, Workspace& work) { out[i] = motion(i * a_motion, work); });
}

double ConfigurationCheck::clearance(std::size_t index, double cutoff, Workspace& work) const {
  const Pose* poses = configuration(index);
  struct Least final : NearVisitor {
    const ConfigurationCheck& check;
    const Pose* poses;
    double least;
    std::uint32_t link = 0;
    Least(const ConfigurationCheck& c, const Pose* p, double cutoff) : check(c), poses(p), least(cutoff) {}
    // What overlaps may be deeper than the least known: it is never left out.
    double farthest_wanted() const { return std::max(0.0, least) * (1 + tolerance::distance_rounding); }
    void take(const Shape& other, const Pose& pose) {
      const PairAnswer answer =
          check.narrow_.solve(check.links_[link], poses[link], other, pose, Request::distance);
      least = std::min(least, answer.signed_distance);
    }
    double visit(std::uint32_t body, double) override {
      if (check.is_checked(link, body)) take(check.world_.shape(body), check.world_.pose(body));
      return farthest_wanted();
    }
  } least(*this, poses, cutoff);
  for (std::size_t link = 0; link < links_.size(); ++link)
    work.boxes[link] = outward_box(links_[link], poses[link], 0);
  for (; least.link < links_.size(); ++least.link) {
    for (const std::uint32_t body : world_.unbounded()) least.visit(body, 0);
    world_.tree().visit_near(work.boxes[least.link], least.farthest_wanted(), least);
  }
  for (const auto& [i, j] : self_)
    if (box_distance(work.boxes[i], work.boxes[j]) <= least.farthest_wanted()) {
      least.link = i;
      least.take(links_[j], poses[j]);
    }
  return least.least;
}

void ConfigurationCheck::clearances(std::span<double> out, double cutoff) const {
  if (out.size() != configurations_) refuse("the number of distances", out.size(), std::to_string(configurations_));
  each(configurations_, [&](std::size_t i, Workspace& work) {
    out[i] = out_of_time() ? -std::numeric_limits<double>::infinity() : clearance(i, cutoff, work);
  });
}

}  // namespace tandem
