// Queries of one shape against a scene, and the entry points of batches.
#include "tandem/engine/scene_queries.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>

#include "queries/configuration_check.h"
#include "queries/limit_watch.h"
#include "queries/query_memory.h"
#include "queries/query_world.h"
#include "scene/swept_boxes.h"
#include "scene/tolerances.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

[[noreturn]] void refuse_number(std::string_view what, double found, std::string_view allowed) {
  char digits[32];
  const std::string text(digits, std::to_chars(digits, digits + sizeof digits, found).ptr);
  throw std::invalid_argument(std::string(what) + ": " + text + " is not " + std::string(allowed));
}

void require_margin(double margin) {
  if (!(margin >= 0) || !std::isfinite(margin)) refuse_number("margin", margin, "finite and >= 0");
}

void require_cutoff(double cutoff) {
  if (!(cutoff >= 0)) refuse_number("cutoff", cutoff, ">= 0");
}

/// The pose of a query, its rotation made orthonormal as those of bodies are.
Pose query_pose(const Pose& given) {
  require_valid(given, "query");
  return orthonormalized(given);
}

}  // namespace

struct SceneQueries::Impl {
  explicit Impl(const NarrowPhaseOptions& given) : options(without_bounds(given)), narrow(options) {}

  static NarrowPhaseOptions without_bounds(NarrowPhaseOptions options) {
    options.margin = 0;
    options.cutoff = infinity;
    options.memory = nullptr;  // one thread's alone
    return options;
  }

  UpdateReport update(const Scene& scene) {
    torn = true;
    const UpdateReport report = bodies.update(scene);
    torn = false;
    return report;
  }
  const QueryWorld& world() const {
    if (torn) throw std::logic_error("queries: the last update threw, allowed: queries after one that did not");
    return bodies;
  }

  Aabb box_of(const Shape& shape, const Pose& pose, double margin) const {
    return outward_box(shape, pose, margin, options.limit);
  }

  /// All bodies that the filter admits and whose boxes come within `margin` of the shape's, half-spaces first; false if
  /// `enough(index)` ended it.
  template <class Enough>
  bool each_candidate(const Aabb& box, const QueryFilter& filter, Enough&& enough) const {
    LimitWatch watch(options.limit);
    const auto is_last = [&](std::uint32_t index) {
      watch.spend(LimitWatch::a_candidate);
      return world().admits(filter, index) && enough(index, watch);
    };
    for (const std::uint32_t index : world().unbounded())
      if (is_last(index)) return false;
    return world().visit_overlapping(box, [&](std::uint32_t index) { return !is_last(index); });
  }

  PairAnswer solve(const Shape& shape, const Pose& pose, std::uint32_t index, Request request,
                   LimitWatch& watch) const {
    watch.spend(LimitWatch::of_pair(shape, world().shape(index)));
    return unless_stopped(narrow.solve(shape, pose, world().shape(index), world().pose(index), request));
  }

  PairAnswer distance(const Shape& shape, const Pose& pose, std::uint32_t index, double cutoff,
                      LimitWatch& watch) const {
    watch.spend(LimitWatch::of_pair(shape, world().shape(index)));
    return unless_stopped(narrow.distance_within(shape, pose, world().shape(index), world().pose(index), cutoff));
  }

  NarrowPhaseOptions options;
  NarrowPhase narrow;
  QueryWorld bodies;
  bool torn = false;  // the last update ended by an exception
  CheckMemory memory;
  detail::ScratchPool<std::vector<std::uint32_t>> tried;
  detail::ScratchPool<QueryMemory> lent;  // for contacts of meshes
};

SceneQueries::SceneQueries(const Scene& scene, const NarrowPhaseOptions& options)
    : impl_(std::make_unique<Impl>(options)) {
  update(scene);
}
SceneQueries::~SceneQueries() = default;
SceneQueries::SceneQueries(SceneQueries&&) noexcept = default;
SceneQueries& SceneQueries::operator=(SceneQueries&&) noexcept = default;

UpdateReport SceneQueries::update(const Scene& scene) { return impl_->update(scene); }

std::size_t SceneQueries::memory() const {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
  return sizeof(Impl) + impl_->bodies.memory() + impl_->memory.memory() + impl_->tried.memory(bytes) +
         impl_->lent.memory();
}

bool SceneQueries::collides(const Shape& shape, const Pose& given, double margin, const QueryFilter& filter) const {
  const Pose pose = query_pose(given);
  require_margin(margin);
  return !impl_->each_candidate(impl_->box_of(shape, pose, margin), filter,
                                [&](std::uint32_t index, LimitWatch& watch) {
                                  return margin == 0 ? impl_->solve(shape, pose, index, Request::collide, watch).collide
                                                     : !impl_->distance(shape, pose, index, margin, watch).farther;
                                });
}

void SceneQueries::hits(const Shape& shape, const Pose& given, std::vector<BodyId>& bodies,
                        const QueryFilter& filter) const {
  const Pose pose = query_pose(given);
  const auto first = static_cast<std::ptrdiff_t>(bodies.size());
  impl_->each_candidate(impl_->box_of(shape, pose, 0), filter, [&](std::uint32_t index, LimitWatch& watch) {
    if (impl_->solve(shape, pose, index, Request::collide, watch).collide) bodies.push_back(impl_->world().id(index));
    return false;
  });
  std::sort(bodies.begin() + first, bodies.end(), [](BodyId a, BodyId b) { return a.index() < b.index(); });
}

std::optional<Hit> SceneQueries::nearest(const Shape& shape, const Pose& given, double cutoff,
                                         const QueryFilter& filter) const {
  const Pose pose = query_pose(given);
  require_cutoff(cutoff);

  struct Nearest final : NearVisitor {
    const Impl& impl;
    const Shape& shape;
    const Pose& pose;
    const QueryFilter& filter;
    double limit;
    LimitWatch watch;
    std::optional<Hit> best;

    Nearest(const Impl& i, const Shape& s, const Pose& p, const QueryFilter& f, double cutoff)
        : impl(i), shape(s), pose(p), filter(f), limit(cutoff), watch(i.options.limit) {}

    double visit(std::uint32_t index, double) override {
      watch.spend(LimitWatch::a_candidate);
      if (impl.world().admits(filter, index)) {
        const PairAnswer answer = impl.distance(shape, pose, index, farthest_wanted(), watch);
        if (answer.farther) return farthest_wanted();
        const double d = answer.signed_distance;
        const bool nearer =
            best ? d < best->answer.signed_distance || (d == best->answer.signed_distance && index < best->body.index())
                 : d <= limit;
        if (nearer) best = Hit{impl.world().id(index), answer};
      }
      return farthest_wanted();
    }
    // A body whose box overlaps is never left out: it may be deeper than the best one.
    double farthest_wanted() const {
      return best ? std::max(0.0, best->answer.signed_distance) * (1 + tolerance::distance_rounding) : limit;
    }
  } nearest(*impl_, shape, pose, filter, cutoff);

  for (const std::uint32_t index : impl_->world().unbounded()) nearest.visit(index, 0);
  impl_->world().tree().visit_near(impl_->box_of(shape, pose, 0), nearest.farthest_wanted(), nearest);
  return nearest.best;
}

void SceneQueries::within(const Shape& shape, const Pose& given, double margin, std::vector<Hit>& hits,
                          const QueryFilter& filter) const {
  const Pose pose = query_pose(given);
  require_margin(margin);
  const auto first = static_cast<std::ptrdiff_t>(hits.size());
  impl_->each_candidate(impl_->box_of(shape, pose, margin), filter, [&](std::uint32_t index, LimitWatch& watch) {
    const PairAnswer answer = impl_->distance(shape, pose, index, margin, watch);
    if (!answer.farther) hits.push_back({impl_->world().id(index), answer});
    return false;
  });
  std::sort(hits.begin() + first, hits.end(),
            [](const Hit& a, const Hit& b) { return a.body.index() < b.body.index(); });
}

void SceneQueries::contacts(const Shape& shape, const Pose& given, double margin, std::vector<ContactHit>& hits,
                            std::vector<Contact>& contacts, const QueryFilter& filter) const {
  const Pose pose = query_pose(given);
  NarrowPhaseOptions options = impl_->options;
  options.margin = margin;
  options.mesh_gaps = false;  // pairs without contacts are left out
  const detail::ScratchPool<QueryMemory>::Lease lent(impl_->lent);
  // Also if nothing is near: only the first query may allocate.
  if (shape.kind() == ShapeKind::mesh) lent->reserve(QueryMemory::usual(shape.triangles().size()));
  options.memory = &*lent;
  const NarrowPhase narrow(options);  // throws for an invalid margin
  // Candidates, then those of them that touch, are collected in the caller's list: nothing is allocated once it is
  // large enough.
  const auto first = static_cast<std::ptrdiff_t>(hits.size());
  impl_->each_candidate(impl_->box_of(shape, pose, margin), filter, [&](std::uint32_t index, LimitWatch&) {
    hits.push_back({impl_->world().id(index), {}, 0, 0});
    return false;
  });
  std::sort(hits.begin() + first, hits.end(),
            [](const ContactHit& a, const ContactHit& b) { return a.body.index() < b.body.index(); });
  LimitWatch watch(impl_->options.limit);
  for (auto hit = hits.begin() + first; hit != hits.end(); ++hit) {
    const std::uint32_t index = hit->body.index();
    watch.spend(LimitWatch::of_pair(shape, impl_->world().shape(index)));
    hit->first = contacts.size();
    hit->answer = unless_stopped(narrow.solve(shape, pose, impl_->world().shape(index), impl_->world().pose(index),
                                              Request::contacts, &contacts));
    hit->count = contacts.size() - hit->first;
  }
  hits.erase(std::remove_if(hits.begin() + first, hits.end(), [](const ContactHit& hit) { return hit.count == 0; }),
             hits.end());
}

std::optional<Impact> SceneQueries::cast(const Shape& shape, const Motion& motion, const QueryFilter& filter) const {
  require_valid(motion, "motion");
  std::optional<Impact> best;
  const detail::ScratchPool<std::vector<std::uint32_t>>::Lease lease(impl_->tried);
  std::vector<std::uint32_t>& tried = *lease;  // sorted
  tried.clear();
  const auto attempt = [&](std::uint32_t index, LimitWatch&) {
    const auto place = std::lower_bound(tried.begin(), tried.end(), index);
    if (place != tried.end() && *place == index) return false;
    tried.insert(place, index);
    const Pose& at = impl_->world().pose(index);
    const auto touch = impl_->narrow.time_of_impact(shape, motion, impl_->world().shape(index), Motion{at, at});
    const BodyId body = impl_->world().id(index);
    if (touch && (!best || touch->t < best->t || (touch->t == best->t && index < best->body.index())))
      best = Impact{body, touch->t, touch->point, touch->normal, touch->feature};
    return false;
  };
  const SweptBoxes swept(shape, motion, impl_->options.limit);
  for (std::size_t i = 0; i < swept.size(); ++i) {
    if (best && best->t < swept.begins(i)) break;
    impl_->each_candidate(swept.box(i), filter, attempt);
  }
  return best;
}

namespace {

/// A body of the world as the query's shape: its shape and pose, and a filter that leaves out the body itself.
class AskingBody {
 public:
  AskingBody(const QueryWorld& world, BodyId body) : world_(world), body_(body) {
    if (!world.has(body))
      throw std::invalid_argument("body id: slot_plus_one is " + std::to_string(body.slot_plus_one) + ", generation " +
                                  std::to_string(body.generation) + ": no body of the last update has it");
    filter_.group = world.group(body.index());
    filter_.mask = world.mask(body.index());
    filter_.ignore = std::span(&body_, 1);
    if (world.is_static(body.index()))
      filter_.admits = [&world](BodyId other) { return !world.is_static(other.index()); };
  }
  AskingBody(const AskingBody&) = delete;
  AskingBody& operator=(const AskingBody&) = delete;

  const Shape& shape() const { return world_.shape(body_.index()); }
  const Pose& pose() const { return world_.pose(body_.index()); }
  const QueryFilter& filter() const { return filter_; }

 private:
  const QueryWorld& world_;
  const BodyId body_;
  QueryFilter filter_;
};

}  // namespace

bool SceneQueries::collides(BodyId body, double margin) const {
  const AskingBody asking(impl_->world(), body);
  return collides(asking.shape(), asking.pose(), margin, asking.filter());
}

void SceneQueries::hits(BodyId body, std::vector<BodyId>& bodies) const {
  const AskingBody asking(impl_->world(), body);
  hits(asking.shape(), asking.pose(), bodies, asking.filter());
}

std::optional<Hit> SceneQueries::nearest(BodyId body, double cutoff) const {
  const AskingBody asking(impl_->world(), body);
  return nearest(asking.shape(), asking.pose(), cutoff, asking.filter());
}

void SceneQueries::within(BodyId body, double margin, std::vector<Hit>& hits) const {
  const AskingBody asking(impl_->world(), body);
  within(asking.shape(), asking.pose(), margin, hits, asking.filter());
}

void SceneQueries::check(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self,
                         std::span<Verdict> verdicts, const BatchOptions& options) const {
  require_margin(options.margin);
  ConfigurationCheck(impl_->world(), impl_->options, links, poses, self, options, impl_->memory).verdicts(verdicts);
}

void SceneQueries::first_hits(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self,
                              std::span<FirstHit> hits, const BatchOptions& options) const {
  require_margin(options.margin);
  ConfigurationCheck(impl_->world(), impl_->options, links, poses, self, options, impl_->memory).first_hits(hits);
}

void SceneQueries::clearance(std::span<const Shape> links, const BatchPoses& poses, const PairTable& self,
                             std::span<double> distances, double cutoff, const BatchOptions& options) const {
  require_cutoff(cutoff);
  ConfigurationCheck(impl_->world(), impl_->options, links, poses, self, options, impl_->memory)
      .clearances(distances, cutoff);
}

}  // namespace tandem
