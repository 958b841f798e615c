// Verdicts, clearances and motions of many configurations of links against a world.
#include "queries/configuration_check.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "scene/tolerances.h"
#include "tandem/narrowphase/prepare.h"

namespace tandem {
namespace {

[[noreturn]] void refuse(const std::string& what, std::size_t found, const std::string& allowed) {
  throw std::invalid_argument("configurations: " + what + " is " + std::to_string(found) + ", allowed: " + allowed);
}

double box_distance(const Aabb& a, const Aabb& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double off = std::max({double{b.lo[k]} - a.hi[k], double{a.lo[k]} - b.hi[k], 0.0});
    sum += off * off;
  }
  return std::sqrt(sum);
}

std::size_t bytes(const auto&... list) { return (std::size_t{0} + ... + (list.capacity() * sizeof(list[0]))); }

}  // namespace

std::size_t CheckSetup::memory() const { return bytes(grown, boxes, grown_boxes, self); }

std::size_t CheckWorkspace::memory() const {
  return boxes.memory() + ends.memory() + bytes(poses, meeting, bodies, stretches, suspects, near, nearest);
}

std::size_t CheckMemory::memory() const { return setups.memory() + workspaces.memory(); }

ConfigurationCheck::ConfigurationCheck(const QueryWorld& world, const NarrowPhaseOptions& narrow,
                                       std::span<const Shape> links, const BatchPoses& poses, const PairTable& self,
                                       const BatchOptions& options, CheckMemory& memory)
    : world_(world),
      limit_(limit_of(options, narrow.limit)),
      narrow_(limited(narrow, limit_)),
      links_(links),
      poses_(poses),
      options_(options),
      workspaces_(memory.workspaces),
      setup_(memory.setups) {
  const std::size_t n = links.size(), a_motion = options.configurations_a_motion;
  if (n == 0) refuse("the number of links", 0, ">= 1");
  if (poses.size() % n != 0)
    refuse("the number of poses", poses.size(), "a multiple of " + std::to_string(n) + " links");
  configurations_ = poses.size() / n;
  if (a_motion == 0 || configurations_ % a_motion != 0)
    refuse("configurations_a_motion", a_motion, "a divisor of " + std::to_string(configurations_));
  if (self.rows() != 0 && (self.rows() != n || self.columns() < n))
    refuse("the number of rows of the table of links", self.rows(),
           "0 or " + std::to_string(n) + ", and as many columns");
  if (options.world != nullptr && options.world->rows() != n)
    refuse("the number of rows of the table of bodies", options.world->rows(), std::to_string(n));
  for (std::size_t i = 0; i < n; ++i)
    if (!links[i].is_bounded())
      throw std::invalid_argument("configurations: link " + std::to_string(i) + " is a " +
                                  std::string(name(links[i].kind())) + ", allowed: bounded shapes");
  setup_->self.clear(), setup_->boxes.clear(), setup_->grown_boxes.clear(), setup_->grown.clear();
  for (std::uint32_t i = 0; i < self.rows(); ++i)
    for (std::uint32_t j = i + 1; j < n; ++j)
      if (self.checked(i, j)) setup_->self.push_back({i, j});
  if (options.continuous && a_motion < 2)
    refuse("configurations_a_motion", a_motion, ">= 2 where motions are continuous");
  if (options.continuous)
    for (const Shape& link : links)
      setup_->grown.push_back(options.margin > 0 ? link.rounded(link.rounding() + options.margin) : link);
}

WorkLimit ConfigurationCheck::limit_of(const BatchOptions& options, const WorkLimit* of_all) {
  WorkLimit limit{options.stop, options.deadline, {}};
  if (of_all == nullptr) return limit;
  limit.deadline = std::min(limit.deadline, of_all->deadline);
  limit.ended = [of_all] { return of_all->reached(); };
  return limit;
}

NarrowPhaseOptions ConfigurationCheck::limited(NarrowPhaseOptions options, const WorkLimit& limit) {
  options.limit = &limit;
  return options;
}

/// Computes the boxes of all links in `count` configurations from `first` on, and in which of these the boxes of two
/// links overlap; makes the poses of the first one.
PoseList ConfigurationCheck::take_boxes(std::size_t first, std::size_t count, std::span<const LinkBox> boxes,
                                        Workspace& work) const {
  const std::size_t n = links_.size();
  PoseList poses;
  if (poses_.make()) {
    work.poses.resize(count * n);
    poses_.make()(first * n, work.poses);
    poses = std::span<const Pose>(work.poses);
  } else {
    poses = poses_.matrices().empty() ? PoseList(poses_.lying()) : PoseList::of_matrices(poses_.matrices());
    poses = poses.from(first * n);
  }
  if (!work.boxes.take(boxes, poses, 0, count, limit_))
    for (std::size_t i = 0; i < count * n; ++i) {
      const std::string what =
          "poses: configuration " + std::to_string(first + i / n) + ", link " + std::to_string(i % n);
      if (!poses.has_last_row(i)) throw std::invalid_argument(what + ": the last row of its matrix is not 0, 0, 0, 1");
      require_valid(poses[i], what);
    }
  return poses;
}

/// Returns false if the limit was reached, as building the hull of a mesh takes long.
bool ConfigurationCheck::has_link_boxes() const {
  try {
    for (const Shape& link : links_) {
      setup_->boxes.emplace_back(link, &limit_);
      setup_->grown_boxes.emplace_back(setup_->boxes.back(), options_.margin);
    }
  } catch (const WorkStopped&) {
    return false;
  }
  return true;
}

/// Prepares the links' meshes for verdicts, unless there is a limit, which could end it: verdicts are right without.
void ConfigurationCheck::prepare_links() const {
  if (options_.margin > 0 || limit_.deadline != WorkLimit().deadline || limit_.ended || limit_.stop.stop_possible())
    return;
  for (const Shape& link : links_) prepare(link);
}

/// Calls block(first, last, workspace) for all of `items`, on the threads of the caller's arena; leaves out those after
/// the limit was reached.
template <class Block>
void ConfigurationCheck::each_block(std::size_t items, std::size_t most, const Block& block) const {
  if (!has_link_boxes()) return;
  std::atomic<std::size_t> done{0};
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t a_block = std::clamp<std::size_t>(items / (16 * threads), 1, most);
  const std::size_t blocks = (items + a_block - 1) / a_block;
  tbb::task_group_context context;
  const auto run = [&](std::size_t i) {
    if (out_of_time()) {
      context.cancel_group_execution();
      return;
    }
    const std::size_t first = i * a_block, last = std::min(items, first + a_block);
    {
      const detail::ScratchPool<Workspace>::Lease work(workspaces_);
      work->has_last_hit = false;  // that was another batch's
      work->watch = LimitWatch(&limit_);
      try {
        block(first, last, *work);
      } catch (const WorkStopped&) {
        if (!limit_.reached()) throw;  // an exception of the filter itself
        context.cancel_group_execution();
        return;
      }
    }
    if (options_.progress) options_.progress(done += last - first, items);
  };
  tbb::parallel_for(std::size_t{0}, blocks, run, context);
}

bool ConfigurationCheck::touch(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                               Workspace& work) const {
  work.watch.spend(LimitWatch::of_pair(a, b));
  return options_.margin == 0 ? unless_stopped(narrow_.solve(a, pose_a, b, pose_b, Request::collide)).collide
                              : !unless_stopped(narrow_.distance_within(a, pose_a, b, pose_b, options_.margin)).farther;
}

bool ConfigurationCheck::is_checked(std::uint32_t link, std::uint32_t body, Workspace& work) const {
  work.watch.spend(LimitWatch::a_candidate);
  if (options_.world != nullptr && body < options_.world->columns() && !options_.world->checked(link, body))
    return false;
  return world_.admits(options_.filter, body);
}

/// True if the boxes of the link and the body do not separate them.
bool ConfigurationCheck::is_near(std::size_t place, std::uint32_t link, const Pose& pose, std::uint32_t body,
                                 const Workspace& work) const {
  return !world_.shape(body).is_bounded() ||
         (overlap(work.boxes.box(link, place), world_.box(body)) &&
          !known_apart(setup_->grown_boxes[link], pose, world_.own_box(body), world_.pose(body)));
}

void ConfigurationCheck::find_ends(Workspace& work) const {
  if (world_.bits().is_built()) world_.bits().find_ends(work.boxes.boxes(), work.boxes.places(), work.ends);
}

/// Calls visit(body) for bodies without boxes, then for those whose boxes overlap the link's, until it returns false,
/// and returns that.
template <class Visit>
bool ConfigurationCheck::visit_bodies(std::uint32_t link, std::size_t place, const Workspace& work,
                                      const Visit& visit) const {
  for (const std::uint32_t body : world_.unbounded())
    if (!visit(body)) return false;
  if (!world_.bits().is_built()) return world_.visit_overlapping(work.boxes.box(link, place), visit);
  return world_.bits().visit_near(work.ends[work.boxes.place(link, place)], [&](std::uint32_t body) {
    return !overlap(work.boxes.box(link, place), world_.box(body)) || visit(body);
  });
}

bool ConfigurationCheck::hits_again(const PoseList& poses, std::size_t place, Workspace& work) const {
  if (!work.has_last_hit) return false;
  const auto& [link, other, is_body, first, last] = work.last_hit;
  const Pose pose = poses[link];
  if (is_body)
    return is_near(place, link, pose, other, work) &&
           touch(links_[link], pose, world_.shape(other), world_.pose(other), work);
  return overlap(work.boxes.box(link, place), work.boxes.box(other, place)) &&
         touch(links_[link], pose, links_[other], poses[other], work);
}

/// Records the configurations in which the boxes of two links overlap.
void ConfigurationCheck::meet_links(Workspace& work) const {
  const std::size_t parts = work.boxes.parts();
  work.meeting.resize(setup_->self.size() * parts);
  std::uint64_t* bits = work.meeting.data();
  for (std::size_t part = 0; part < parts; ++part)
    for (const auto& [i, j] : setup_->self) *bits++ = work.boxes.meeting(part, i, j);
}

// `place`: the configuration's number among those whose boxes were computed.
bool ConfigurationCheck::hits_link(const PoseList& poses, std::size_t place, Workspace& work) const {
  const std::uint64_t* meeting = work.meeting.data() + place / PoseNumbers::count * setup_->self.size();
  const std::uint64_t bit = std::uint64_t{1} << place % PoseNumbers::count;
  for (std::size_t p = 0; p < setup_->self.size(); ++p) {
    if ((meeting[p] & bit) == 0) continue;
    const auto [i, j] = setup_->self[p];
    if (!touch(links_[i], poses[i], links_[j], poses[j], work)) continue;
    work.last_hit = {i, j, false, 0, 0};
    return work.has_last_hit = true;
  }
  return false;
}

bool ConfigurationCheck::hits_body(const PoseList& poses, std::size_t place, Workspace& work) const {
  for (std::uint32_t link = 0; link < links_.size(); ++link) {
    const auto is_free = [&](std::uint32_t body) {
      if (!is_checked(link, body, work)) return true;
      const Pose pose = poses[link];
      if (!is_near(place, link, pose, body, work) ||
          !touch(links_[link], pose, world_.shape(body), world_.pose(body), work))
        return true;
      work.last_hit = {link, body, true, 0, 0};
      return false;
    };
    if (!visit_bodies(link, place, work, is_free)) return work.has_last_hit = true;
  }
  return false;
}

/// Records the configurations in which a pair may touch, if there are any.
template <class Meeting>
void ConfigurationCheck::add_suspects(std::uint32_t link, std::uint32_t other, bool is_body, Workspace& work,
                                      const Meeting& meeting) const {
  const auto first = static_cast<std::uint32_t>(work.near.size());
  for (std::size_t part = 0; part < work.boxes.parts(); ++part)
    for (std::uint64_t bits = meeting(part); bits != 0; bits &= bits - 1)
      work.near.push_back(static_cast<std::uint32_t>(part * PoseNumbers::count) +
                          static_cast<std::uint32_t>(std::countr_zero(bits)));
  const auto last = static_cast<std::uint32_t>(work.near.size());
  if (first < last) work.suspects.push_back({link, other, is_body, first, last});
}

void ConfigurationCheck::suspect_links(Workspace& work) const {
  for (const auto& pair : setup_->self) {
    const std::uint32_t i = pair.first, j = pair.second;
    if (overlap(work.boxes.swept(i), work.boxes.swept(j)))
      add_suspects(i, j, false, work, [&](std::size_t part) { return work.boxes.meeting(part, i, j); });
  }
}

void ConfigurationCheck::suspect_bodies(Workspace& work) const {
  const std::size_t count = options_.configurations_a_motion;
  for (std::uint32_t link = 0; link < links_.size(); ++link) {
    world_.visit_overlapping(work.boxes.swept(link), [&](std::uint32_t body) {
      if (!is_checked(link, body, work)) return true;
      const PlacedBox placed = world_.placed_box(body);
      add_suspects(link, body, true, work, [&](std::size_t part) { return work.boxes.meeting(part, link, placed); });
      return true;
    });
    for (const std::uint32_t body : world_.unbounded())
      if (is_checked(link, body, work))
        add_suspects(link, body, true, work, [&](std::size_t part) {
          const std::size_t left = count - part * PoseNumbers::count;
          return left < PoseNumbers::count ? (std::uint64_t{1} << left) - 1 : ~std::uint64_t{0};
        });
  }
}

/// An upper bound on the change of the pair's gap from one configuration to another.
double ConfigurationCheck::may_move(const CheckWorkspace::Suspects& pair, const PoseList& from,
                                    const PoseList& to) const {
  const auto moved = [&](std::uint32_t link) {
    const Pose begin = from[link], end = to[link];
    return (end.translation - begin.translation).norm() +
           (end.rotation - begin.rotation).norm() * setup_->boxes[link].reach();
  };
  return moved(pair.link) + (pair.is_body ? 0 : moved(pair.other));
}

/// True if the pair touches in one of the configurations near[first .. last). Tests the middle one, skips neighbours
/// whose motion is too short to have closed its gap, then searches the rest on either side.
bool ConfigurationCheck::hits_between(const PoseList& poses, Workspace& work, const CheckWorkspace::Suspects& pair,
                                      std::size_t first, std::size_t last) const {
  if (first >= last) return false;
  const std::size_t middle = first + (last - first) / 2;
  const auto at = [&](std::size_t i) { return poses.from(work.near[i] * links_.size()); };
  const PoseList here = at(middle);
  const Shape &a = links_[pair.link], &b = pair.is_body ? world_.shape(pair.other) : links_[pair.other];
  const Pose pose_a = here[pair.link], pose_b = pair.is_body ? world_.pose(pair.other) : here[pair.other];
  std::size_t left = middle, right = middle + 1;
  // The distance of a mesh takes as long as many verdicts.
  if (a.is_convex() && b.is_convex() && last - first > 1) {
    work.watch.spend(LimitWatch::of_pair(a, b));
    const PairAnswer answer = narrow_.solve(a, pose_a, b, pose_b, Request::distance);
    const double gap = unless_stopped(answer).signed_distance - options_.margin;
    if (gap <= 0) return true;
    const double passed = gap - answer.error_bound - tolerance::gap_left * setup_->boxes[pair.link].reach();
    while (left > first && may_move(pair, here, at(left - 1)) < passed) --left;
    while (right < last && may_move(pair, here, at(right)) < passed) ++right;
  } else if (touch(a, pose_a, b, pose_b, work)) {
    return true;
  }
  return hits_between(poses, work, pair, first, left) || hits_between(poses, work, pair, right, last);
}

/// Tests all configurations of a motion at once: finds the bodies that overlap the union of a link's boxes, then
/// compares these with the box in each configuration.
bool ConfigurationCheck::motion_hits(std::size_t index, Workspace& work) const {
  const std::size_t count = options_.configurations_a_motion;
  PoseList poses = take_boxes(index * count, count, setup_->grown_boxes, work);
  work.suspects.clear();
  work.near.clear();
  suspect_bodies(work);
  suspect_links(work);
  // The pair whose boxes overlap in the most configurations is the most likely to touch.
  std::sort(work.suspects.begin(), work.suspects.end(), [](const auto& p, const auto& q) {
    return p.last - p.first != q.last - q.first ? p.last - p.first > q.last - q.first : p.first < q.first;
  });
  return std::any_of(work.suspects.begin(), work.suspects.end(),
                     [&](const auto& pair) { return hits_between(poses, work, pair, pair.first, pair.last); }) ||
         (options_.continuous && hits_in_between(poses, work));
}

void ConfigurationCheck::verdicts(std::span<Verdict> out) const {
  const std::size_t a_motion = options_.configurations_a_motion, motions = configurations_ / a_motion;
  if (out.size() != motions) refuse("the number of verdicts", out.size(), std::to_string(motions));
  std::fill(out.begin(), out.end(), Verdict::unknown);
  prepare_links();
  const auto told = [](bool hits) { return hits ? Verdict::hit : Verdict::free; };
  if (a_motion != 1)
    return each_block(motions, at_once(8), [&](std::size_t first, std::size_t last, Workspace& work) {
      for (std::size_t i = first; i < last; ++i) out[i] = told(motion_hits(i, work));
    });
  each_block(motions, at_once(1), [&](std::size_t first, std::size_t last, Workspace& work) {
    const std::size_t count = last - first;
    PoseList poses = take_boxes(first, count, setup_->grown_boxes, work);
    find_ends(work);
    meet_links(work);
    for (std::size_t k = 0; k < count; ++k, poses = poses.from(links_.size()))
      out[first + k] = told(hits_again(poses, k, work) || hits_link(poses, k, work) || hits_body(poses, k, work));
  });
}

/// The first body by index that the link touches.
bool ConfigurationCheck::first_body(const Pose& pose, std::size_t place, std::uint32_t link, Workspace& work,
                                    BodyId& body) const {
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t first = none;
  const auto look = [&](std::uint32_t index) {
    if (is_checked(link, index, work) && index < first && is_near(place, link, pose, index, work) &&
        touch(links_[link], pose, world_.shape(index), world_.pose(index), work))
      first = index;
    return true;
  };
  visit_bodies(link, place, work, look);
  if (first == none) return false;
  body = world_.id(first);
  return true;
}

/// `place`: the number of the motion's first configuration among those whose boxes were computed.
FirstHit ConfigurationCheck::first_hit(const PoseList& poses, std::size_t place, Workspace& work) const {
  const std::size_t n = links_.size(), count = options_.configurations_a_motion;
  FirstHit hit;
  hit.verdict = Verdict::hit;
  for (std::size_t k = 0; k < count; ++k) {
    const PoseList here = poses.from(k * n);
    hit.configuration = static_cast<std::uint32_t>(k);
    if (hits_link(here, place + k, work)) {
      hit.link = work.last_hit.link, hit.other_link = work.last_hit.other;
      return hit;
    }
    for (hit.link = 0; hit.link < n; ++hit.link)
      if (first_body(here[hit.link], place + k, hit.link, work, hit.body)) return hit;
  }
  hit = {};
  hit.verdict = Verdict::free;
  return hit;
}

void ConfigurationCheck::first_hits(std::span<FirstHit> out) const {
  const std::size_t count = options_.configurations_a_motion, motions = configurations_ / count;
  if (out.size() != motions) refuse("the number of hits", out.size(), std::to_string(motions));
  if (options_.continuous)
    throw std::invalid_argument("configurations: continuous is true, allowed where hits are told: false");
  std::fill(out.begin(), out.end(), FirstHit{});
  prepare_links();
  each_block(motions, at_once(1), [&](std::size_t first, std::size_t last, Workspace& work) {
    PoseList poses = take_boxes(first * count, (last - first) * count, setup_->grown_boxes, work);
    find_ends(work);
    meet_links(work);
    for (std::size_t i = first; i < last; ++i, poses = poses.from(count * links_.size()))
      out[i] = first_hit(poses, (i - first) * count, work);
  });
}

/// The links in the order of their boxes' distances from the nearest body's: a near body bounds the search of the
/// others.
void ConfigurationCheck::order_links(std::size_t place, double cutoff, Workspace& work) const {
  struct First final : NearVisitor {
    const ConfigurationCheck& check;
    Workspace& work;
    double limit, nearest = std::numeric_limits<double>::infinity();
    std::uint32_t link = 0;
    First(const ConfigurationCheck& c, Workspace& w, double cutoff) : check(c), work(w), limit(cutoff) {}
    double visit(std::uint32_t body, double distance) override {
      if (check.is_checked(link, body, work)) limit = nearest = std::min(nearest, distance);
      return limit;
    }
  };
  work.nearest.clear();
  for (std::uint32_t link = 0; link < links_.size(); ++link) {
    First first(*this, work, cutoff);
    first.link = link;
    world_.tree().visit_near(work.boxes.box(link, place), cutoff, first);
    work.nearest.push_back({first.nearest, link});
  }
  std::sort(work.nearest.begin(), work.nearest.end());
}

double ConfigurationCheck::clearance(const PoseList& poses, std::size_t place, double cutoff, Workspace& work) const {
  struct Least final : NearVisitor {
    const ConfigurationCheck& check;
    Workspace& work;
    const PoseList& poses;
    std::size_t place;
    double least;
    std::uint32_t link = 0;
    Least(const ConfigurationCheck& c, Workspace& w, const PoseList& p, std::size_t at, double cutoff)
        : check(c), work(w), poses(p), place(at), least(cutoff) {}
    // An overlapping body is never left out: it may be deeper than the least known distance.
    double farthest_wanted() const { return std::max(0.0, least) * (1 + tolerance::distance_rounding); }
    void take(const Shape& other, const Pose& pose) {
      work.watch.spend(LimitWatch::of_pair(check.links_[link], other));
      const PairAnswer answer = unless_stopped(
          check.narrow_.distance_within(check.links_[link], poses[link], other, pose, farthest_wanted()));
      if (!answer.farther) least = std::min(least, answer.signed_distance);
    }
    // The distance of a mesh takes as long as dozens of gaps between boxes, that of convex shapes as few.
    bool is_far(std::uint32_t body) const {
      const Shape& shape = check.world_.shape(body);
      return (!shape.is_convex() || !check.links_[link].is_convex()) && shape.is_bounded() &&
             work.boxes.gap(place, link, check.world_.placed_box(body)) > farthest_wanted();
    }
    double visit(std::uint32_t body, double) override {
      if (check.is_checked(link, body, work) && !is_far(body)) take(check.world_.shape(body), check.world_.pose(body));
      return farthest_wanted();
    }
  } least(*this, work, poses, place, cutoff);
  order_links(place, cutoff, work);
  for (const auto& [distance, link] : work.nearest) {
    least.link = link;
    if (distance <= least.farthest_wanted())
      world_.tree().visit_near(work.boxes.box(link, place), least.farthest_wanted(), least);
    for (const std::uint32_t body : world_.unbounded()) least.visit(body, 0);
  }
  for (const auto& [i, j] : setup_->self)
    if (box_distance(work.boxes.box(i, place), work.boxes.box(j, place)) <= least.farthest_wanted()) {
      least.link = i;
      least.take(links_[j], poses[j]);
    }
  return least.least;
}

void ConfigurationCheck::clearances(std::span<double> out, double cutoff) const {
  if (out.size() != configurations_) refuse("the number of distances", out.size(), std::to_string(configurations_));
  std::fill(out.begin(), out.end(), -std::numeric_limits<double>::infinity());
  each_block(configurations_, PoseNumbers::count, [&](std::size_t first, std::size_t last, Workspace& work) {
    PoseList poses = take_boxes(first, last - first, setup_->boxes, work);
    for (std::size_t k = 0; k < last - first; ++k, poses = poses.from(links_.size()))
      out[first + k] = clearance(poses, k, cutoff, work);
  });
}

}  // namespace tandem
