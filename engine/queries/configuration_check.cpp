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

/// What the body finds; `unknown` where the limit was reached within a pair.
template <class Result, class Body>
Result or_unknown(const Result& unknown, const Body& body) {
  try {
    return body();
  } catch (const WorkStopped&) {
    return unknown;
  }
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

ConfigurationCheck::ConfigurationCheck(const QueryWorld& world, const NarrowPhaseOptions& narrow,
                                       std::span<const Shape> links, std::span<const Pose> poses, const PairTable& self,
                                       const BatchOptions& options)
    : world_(world),
      limit_(limit_of(options, narrow.limit)),
      narrow_(limited(narrow, limit_)),
      links_(links),
      poses_(poses),
      options_(options) {
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
  for (const Shape& link : links) link_boxes_.emplace_back(link);
  if (options.continuous && a_motion < 2) refuse("configurations_a_motion", a_motion, ">= 2 where motions are continuous");
  if (options.continuous)
    for (const Shape& link : links) grown_.push_back(options.margin > 0 ? link.rounded(link.rounding() + options.margin) : link);
}

WorkLimit ConfigurationCheck::limit_of(const BatchOptions& options, const WorkLimit* of_all) {
  WorkLimit limit{options.stop, options.deadline, {}};
  if (of_all != nullptr) limit.ended = [of_all] { return of_all->reached(); };
  return limit;
}

NarrowPhaseOptions ConfigurationCheck::limited(NarrowPhaseOptions options, const WorkLimit& limit) {
  options.limit = &limit;
  return options;
}

/// Boxes of all links in `count` configurations from `first` on, link j's in configuration k at place j * count + k; the
/// first one's poses.
const Pose* ConfigurationCheck::take_boxes(std::size_t first, std::size_t count, double margin, Workspace& work) const {
  const std::size_t n = links_.size();
  const Pose* poses = poses_.data() + first * n;
  if (work.boxes.size() < count * n) work.boxes.resize(count * n);
  work.swept.resize(n);
  bool valid = true;
  // Poses lie where they are only read once: those of the next block are on their way from memory meanwhile.
  const Pose* next = first + 2 * count <= configurations_ ? poses + count * n : nullptr;
  for (std::size_t link = 0; link < n; ++link)
    valid = link_boxes(LinkBox(link_boxes_[link], margin), poses + link, n, count, work.boxes, link * count,
                       next != nullptr ? next + link * count : nullptr, work.swept[link]) &&
            valid;
  for (std::size_t i = 0; !valid && i < count * n; ++i)
    require_valid(poses[i], "configuration " + std::to_string(first + i / n) + ", link " + std::to_string(i % n));
  return poses;
}

/// block(first, last, workspace) for all of `items`, on the threads of the caller's arena.
template <class Block>
void ConfigurationCheck::each_block(std::size_t items, std::size_t most, const Block& block) const {
  tbb::enumerable_thread_specific<Workspace> workspaces;
  std::atomic<std::size_t> done{0};
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t a_block = std::clamp<std::size_t>(items / (16 * threads), 1, most);
  const std::size_t blocks = (items + a_block - 1) / a_block;
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t i) {
    const std::size_t first = i * a_block, last = std::min(items, first + a_block);
    // A filter or a shared pair may wait for tasks of its own; another block must not come in then and take the workspace.
    tbb::this_task_arena::isolate([&] { block(first, last, workspaces.local()); });
    if (options_.progress) options_.progress(done += last - first, items);
  });
}

bool ConfigurationCheck::touch(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) const {
  return options_.margin == 0 ? unless_stopped(narrow_.solve(a, pose_a, b, pose_b, Request::collide)).collide
                              : !unless_stopped(narrow_.distance_within(a, pose_a, b, pose_b, options_.margin)).farther;
}

bool ConfigurationCheck::is_checked(std::uint32_t link, std::uint32_t body) const {
  if (options_.world != nullptr && body < options_.world->columns() && !options_.world->checked(link, body)) return false;
  return world_.admits(options_.filter, body);
}

bool ConfigurationCheck::hits_again(const Pose* poses, const Workspace& work) const {
  if (!work.has_last_hit) return false;
  const auto& [link, other, is_body, first, last] = work.last_hit;
  return is_body ? touch(links_[link], poses[link], world_.shape(other), world_.pose(other))
                 : touch(links_[link], poses[link], links_[other], poses[other]);
}

// Of configuration `place` of the `count` whose boxes were taken.
bool ConfigurationCheck::hits_link(const Pose* poses, std::size_t place, std::size_t count, Workspace& work) const {
  for (const auto& [i, j] : self_)
    if (overlap(work.boxes[i * count + place], work.boxes[j * count + place]) &&
        touch(links_[i], poses[i], links_[j], poses[j])) {
      work.last_hit = {i, j, false, 0, 0};
      return work.has_last_hit = true;
    }
  return false;
}

bool ConfigurationCheck::hits_body(const Pose* poses, std::size_t place, std::size_t count, Workspace& work) const {
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
        world_.tree().visit_overlapping(work.boxes[first.link * count + place], first))
      continue;
    work.last_hit = {first.link, first.body, true, 0, 0};
    return work.has_last_hit = true;
  }
  return false;
}

/// Notes in which configurations the boxes of a pair overlap, if in any.
template <class Overlaps>
void ConfigurationCheck::add_suspects(std::uint32_t link, std::uint32_t other, bool is_body, Workspace& work,
                                      const Overlaps& overlaps) const {
  const auto first = static_cast<std::uint32_t>(work.near.size());
  const auto count = static_cast<std::uint32_t>(options_.configurations_a_motion);
  for (std::uint32_t k = 0; k < count; ++k)
    if (overlaps(k)) work.near.push_back(k);
  const auto last = static_cast<std::uint32_t>(work.near.size());
  if (first < last) work.suspects.push_back({link, other, is_body, first, last});
}

void ConfigurationCheck::suspect_links(Workspace& work) const {
  const std::size_t count = options_.configurations_a_motion;
  for (const auto& pair : self_) {
    const std::uint32_t i = pair.first, j = pair.second;
    if (overlap(work.swept[i], work.swept[j]))
      add_suspects(i, j, false, work, [&](std::size_t k) {
        return overlap(work.boxes[i * count + k], work.boxes[j * count + k]);
      });
  }
}

void ConfigurationCheck::suspect_bodies(Workspace& work) const {
  const std::size_t count = options_.configurations_a_motion;
  for (std::uint32_t link = 0; link < links_.size(); ++link) {
    work.bodies.clear();
    world_.tree().overlapping(work.swept[link], work.bodies);
    for (const std::uint32_t body : work.bodies) {
      if (!is_checked(link, body)) continue;
      const Aabb box = world_.box(body);
      add_suspects(link, body, true, work, [&](std::size_t k) { return overlap(work.boxes[link * count + k], box); });
    }
    for (const std::uint32_t body : world_.unbounded())
      if (is_checked(link, body)) add_suspects(link, body, true, work, [](std::size_t) { return true; });
  }
}

/// The most that the gap of the two can have changed from one configuration to another.
double ConfigurationCheck::may_move(const CheckWorkspace::Suspects& pair, const Pose* from, const Pose* to) const {
  const auto moved = [&](std::uint32_t link) {
    return (to[link].translation - from[link].translation).norm() +
           (to[link].rotation - from[link].rotation).norm() * link_boxes_[link].reach();
  };
  return moved(pair.link) + (pair.is_body ? 0 : moved(pair.other));
}

/// Does the pair touch in one of the configurations near[first .. last)? The middle is looked at, what is too near to it
/// to have closed the gap is passed over, then what is left on either side.
bool ConfigurationCheck::hits_between(const Pose* poses, const Workspace& work, const CheckWorkspace::Suspects& pair,
                                      std::size_t first, std::size_t last) const {
  if (first >= last) return false;
  const std::size_t middle = first + (last - first) / 2;
  const auto at = [&](std::size_t i) { return poses + work.near[i] * links_.size(); };
  const Pose* here = at(middle);
  const Shape &a = links_[pair.link], &b = pair.is_body ? world_.shape(pair.other) : links_[pair.other];
  const Pose &pose_a = here[pair.link], &pose_b = pair.is_body ? world_.pose(pair.other) : here[pair.other];
  std::size_t left = middle, right = middle + 1;
  // A distance from a mesh costs many verdicts.
  if (a.is_convex() && b.is_convex() && last - first > 1) {
    const double gap =
        unless_stopped(narrow_.solve(a, pose_a, b, pose_b, Request::distance)).signed_distance - options_.margin;
    if (gap <= 0) return true;
    const double passed = gap - tolerance::gap_left * link_boxes_[pair.link].reach();
    while (left > first && may_move(pair, here, at(left - 1)) < passed) --left;
    while (right < last && may_move(pair, here, at(right)) < passed) ++right;
  } else if (touch(a, pose_a, b, pose_b)) {
    return true;
  }
  return hits_between(poses, work, pair, first, left) || hits_between(poses, work, pair, right, last);
}

/// All configurations of a motion at once: each link's boxes together are looked for in the hierarchy, and what they meet
/// is compared with the box of each.
Verdict ConfigurationCheck::motion(std::size_t index, Workspace& work) const {
  const std::size_t count = options_.configurations_a_motion;
  if (out_of_time()) return Verdict::unknown;
  const Pose* poses = take_boxes(index * count, count, options_.margin, work);
  work.suspects.clear();
  work.near.clear();
  suspect_bodies(work);
  suspect_links(work);
  // What is near in the most configurations is most likely hit.
  std::sort(work.suspects.begin(), work.suspects.end(), [](const auto& p, const auto& q) {
    return p.last - p.first != q.last - q.first ? p.last - p.first > q.last - q.first : p.first < q.first;
  });
  for (const CheckWorkspace::Suspects& pair : work.suspects) {
    if (out_of_time()) return Verdict::unknown;
    if (hits_between(poses, work, pair, pair.first, pair.last)) return Verdict::hit;
  }
  if (!options_.continuous) return Verdict::free;
  if (out_of_time()) return Verdict::unknown;
  return hits_on_the_way(poses, work) ? Verdict::hit : Verdict::free;
}

void ConfigurationCheck::verdicts(std::span<Verdict> out) const {
  const std::size_t a_motion = options_.configurations_a_motion, motions = configurations_ / a_motion;
  if (out.size() != motions) refuse("the number of verdicts", out.size(), std::to_string(motions));
  if (a_motion != 1)
    return each_block(motions, 1, [&](std::size_t i, std::size_t, Workspace& work) {
      out[i] = or_unknown(Verdict::unknown, [&] { return motion(i, work); });
    });
  each_block(motions, 64, [&](std::size_t first, std::size_t last, Workspace& work) {
    const std::size_t count = last - first;
    const Pose* poses = take_boxes(first, count, options_.margin, work);
    for (std::size_t k = 0; k < count; ++k, poses += links_.size())
      out[first + k] = or_unknown(Verdict::unknown, [&] {
        if (out_of_time()) return Verdict::unknown;
        const bool hits =
            hits_again(poses, work) || hits_link(poses, k, count, work) || hits_body(poses, k, count, work);
        return hits ? Verdict::hit : Verdict::free;
      });
  });
}

/// The first body by index that the link touches.
bool ConfigurationCheck::first_body(const Pose* pose, std::uint32_t link, const Aabb& box, Workspace& work,
                                    BodyId& body) const {
  work.bodies.assign(world_.unbounded().begin(), world_.unbounded().end());
  world_.tree().overlapping(box, work.bodies);
  std::sort(work.bodies.begin(), work.bodies.end());
  const auto hit = std::find_if(work.bodies.begin(), work.bodies.end(), [&](std::uint32_t index) {
    return is_checked(link, index) && touch(links_[link], *pose, world_.shape(index), world_.pose(index));
  });
  if (hit == work.bodies.end()) return false;
  body = world_.id(*hit);
  return true;
}

FirstHit ConfigurationCheck::first_hit(std::size_t motion, Workspace& work) const {
  const std::size_t n = links_.size(), count = options_.configurations_a_motion;
  FirstHit hit;
  const Pose* poses = take_boxes(motion * count, count, options_.margin, work);
  for (std::size_t k = 0; k < count; ++k, poses += n) {
    if (out_of_time()) return {};
    hit.configuration = static_cast<std::uint32_t>(k);
    hit.verdict = Verdict::hit;
    if (hits_link(poses, k, count, work)) {
      hit.link = work.last_hit.link, hit.other_link = work.last_hit.other;
      return hit;
    }
    for (hit.link = 0; hit.link < n; ++hit.link)
      if (first_body(poses + hit.link, hit.link, work.boxes[hit.link * count + k], work, hit.body)) return hit;
  }
  hit = {};
  hit.verdict = Verdict::free;
  return hit;
}

void ConfigurationCheck::first_hits(std::span<FirstHit> out) const {
  const std::size_t motions = configurations_ / options_.configurations_a_motion;
  if (out.size() != motions) refuse("the number of hits", out.size(), std::to_string(motions));
  if (options_.continuous) throw std::invalid_argument("configurations: continuous is true, allowed where hits are told: false");
  each_block(motions, 16, [&](std::size_t first, std::size_t last, Workspace& work) {
    for (std::size_t i = first; i < last; ++i) out[i] = or_unknown(FirstHit{}, [&] { return first_hit(i, work); });
  });
}

double ConfigurationCheck::clearance(const Pose* poses, std::size_t place, std::size_t count, double cutoff,
                                     const Workspace& work) const {
  struct Least final : NearVisitor {
    const ConfigurationCheck& check;
    const Pose* poses;
    double least;
    std::uint32_t link = 0;
    Least(const ConfigurationCheck& c, const Pose* p, double cutoff) : check(c), poses(p), least(cutoff) {}
    // What overlaps may be deeper than the least known: it is never left out.
    double farthest_wanted() const { return std::max(0.0, least) * (1 + tolerance::distance_rounding); }
    void take(const Shape& other, const Pose& pose) {
      const PairAnswer answer = unless_stopped(
          check.narrow_.distance_within(check.links_[link], poses[link], other, pose, farthest_wanted()));
      if (!answer.farther) least = std::min(least, answer.signed_distance);
    }
    double visit(std::uint32_t body, double) override {
      if (check.is_checked(link, body)) take(check.world_.shape(body), check.world_.pose(body));
      return farthest_wanted();
    }
  } least(*this, poses, cutoff);
  for (; least.link < links_.size(); ++least.link) {
    for (const std::uint32_t body : world_.unbounded()) least.visit(body, 0);
    world_.tree().visit_near(work.boxes[least.link * count + place], least.farthest_wanted(), least);
  }
  for (const auto& [i, j] : self_)
    if (box_distance(work.boxes[i * count + place], work.boxes[j * count + place]) <= least.farthest_wanted()) {
      least.link = i;
      least.take(links_[j], poses[j]);
    }
  return least.least;
}

void ConfigurationCheck::clearances(std::span<double> out, double cutoff) const {
  if (out.size() != configurations_) refuse("the number of distances", out.size(), std::to_string(configurations_));
  each_block(configurations_, 64, [&](std::size_t first, std::size_t last, Workspace& work) {
    const std::size_t count = last - first;
    const Pose* poses = take_boxes(first, count, 0, work);
    for (std::size_t k = 0; k < count; ++k, poses += links_.size())
      out[first + k] = or_unknown(-std::numeric_limits<double>::infinity(), [&] {
        return out_of_time() ? -std::numeric_limits<double>::infinity() : clearance(poses, k, count, cutoff, work);
      });
  });
}

}  // namespace tandem
