// Finds the intersecting triangles of two meshes, exactly.
#include "meshes/traversal/meeting_pairs.h"

#include <algorithm>
#include <span>

#include "meshes/traversal/mesh_nearest.h"
#include "meshes/traversal/mesh_traversal.h"
#include "meshes/traversal/point_in_mesh.h"
#include "shapes/metered_sort.h"
#include "shapes/shape_insides.h"

namespace tandem {
namespace {

// Collects the exactly intersecting pairs of triangles, or passes them on, or finds whether there is one; keeps lower
// bounds on the distance otherwise.
class MeetingPairs final : public PairVisitor {
 public:
  /// Where the pairs go; without any of these the first one ends the search.
  struct Receivers {
    TrianglePairs* pairs = nullptr;
    const TakePair* take = nullptr;
    GapBound* gap = nullptr;
  };
  /// `subtrees`: null for all of both meshes.
  MeetingPairs(const MeshModel& a, const MeshModel& b, TriangleTest& test, const NodePair* subtrees,
               const Receivers& to, const WorkLimit* limit)
      : PairVisitor(limit), waiting_(a, b, test), to_(to), verdict_alone_(to.pairs == nullptr && to.take == nullptr) {
    double* const gap = to.gap == nullptr ? nullptr : &to.gap->of_others;
    if (subtrees == nullptr)
      traverse(a, b, test, verdict_alone_, *this, gap);
    else
      traverse(a, b, test, *subtrees, *this, gap);
    decide_waiting();
  }

  bool any() const { return any_; }
  bool ended() const { return ended_; }

  bool visit(std::uint32_t i, std::uint32_t j) override {
    if (waiting_.add(i, j) || verdict_alone_) decide_waiting();
    return ended_ || (verdict_alone_ && any_);
  }

 private:
  void decide_waiting() {
    meter.spend(static_cast<int>(waiting_.size()));
    waiting_.decide([this](std::uint32_t i, std::uint32_t j, bool meet) {
      if (ended_) return;
      if (meet) {
        any_ = true;
        if (to_.pairs != nullptr) to_.pairs->push_back({i, j});
        if (to_.take != nullptr) ended_ = !(*to_.take)({i, j});
      } else if (to_.gap != nullptr) {
        to_.gap->add({i, j});
      }
    });
  }

  WaitingPairs waiting_;
  const Receivers to_;
  const bool verdict_alone_;
  bool any_ = false;
  bool ended_ = false;  // by the receiver
};

// The distance of two triangles that do not intersect, or slightly less.
double gap_between(const Corners& p, const Corners& q) {
  Nearest nearest;
  triangles_nearest(p, q, nearest);
  if (!(nearest.distance > 0)) return 0;
  // The points found may be slightly farther apart than the nearest: the gap between two planes counts.
  const Vec3 normal = (nearest.on_b - nearest.on_a) / nearest.distance;
  double far_p = 0, near_q = infinity, span = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    far_p = std::max(far_p, normal.dot(p[k] - p[0]));
    near_q = std::min(near_q, normal.dot(q[k] - p[0]));
    span = std::max({span, (p[k] - p[0]).lpNorm<1>(), (q[k] - p[0]).lpNorm<1>()});
  }
  return std::max(0.0, (1 - tolerance::askew_in_floats) * (near_q - far_p) - tolerance::place_rounding * span);
}

}  // namespace

TrianglePairs meeting_pairs(const Posed& a, const Posed& b, TriangleTest& test, const NarrowPhaseOptions& options,
                            PairMemory& memory, GapBound* gap) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  constexpr std::size_t large = 16384, wanted = 64;  // number of triangles of both; of pairs of subtrees
  std::vector<NodePair> subtrees;
  if (options.parts && ma.triangles.size() + mb.triangles.size() >= large)
    subtrees = traversal_subtrees(ma, mb, test, wanted, gap == nullptr ? nullptr : &gap->of_others);
  TrianglePairs pairs(&memory.resource);
  if (subtrees.size() < wanted) {
    MeetingPairs(ma, mb, test, nullptr, {.pairs = &pairs, .gap = gap}, options.limit);
  } else {
    std::vector<TrianglePairs> found(subtrees.size());
    std::vector<GapBound> gaps(gap == nullptr ? 0 : subtrees.size());
    options.parts(subtrees.size(), [&](std::size_t k) {
      TriangleTest own(a.pose, b.pose, reach(mb));
      MeetingPairs(ma, mb, own, &subtrees[k], {.pairs = &found[k], .gap = gap == nullptr ? nullptr : &gaps[k]},
                   options.limit);
    });
    for (const GapBound& there : gaps) gap->join(there);
    for (const TrianglePairs& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
  }
  WorkMeter meter(options.limit);
  sort_metered(meter, pairs.begin(), pairs.end(), [](const TrianglePair& x, const TrianglePair& y) {
    return (std::uint64_t{x[0]} << 32 | x[1]) < (std::uint64_t{y[0]} << 32 | y[1]);
  });
  return pairs;
}

bool each_meeting_pair(const Posed& a, const Posed& b, const WorkLimit* limit, const TakePair& take,
                       const std::function<void(double)>& progress) {
  constexpr std::size_t parts = 128;  // steps of progress
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  TriangleTest test(a.pose, b.pose, reach(mb));
  const std::vector<NodePair> subtrees = traversal_subtrees(ma, mb, test, parts);
  for (std::size_t k = 0; k < subtrees.size(); ++k) {
    if (MeetingPairs(ma, mb, test, &subtrees[k], {.take = &take}, limit).ended()) return false;
    if (progress && k * parts / subtrees.size() != (k + 1) * parts / subtrees.size())
      progress(static_cast<double>(k + 1) / static_cast<double>(subtrees.size()));
  }
  return true;
}

bool has_inside(const Posed& outer, const Posed& inner, const WorkLimit* limit) {
  WorkMeter meter(limit);
  const MeshModel &o = mesh_of(outer.shape), &i = mesh_of(inner.shape);
  return o.solid && std::ranges::any_of(i.components(limit), [&](const MeshModel::Component& component) {
           meter.spend(16);
           return is_inside(o, outer.pose, i.vertices[component[0]], inner.pose, limit);
         });
}

bool meshes_collide(const Posed& a, const Posed& b, const WorkLimit* limit) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  TriangleTest test(a.pose, b.pose, reach(mb));
  return MeetingPairs(ma, mb, test, nullptr, {}, limit).any() || is_contained(a, b, limit);
}

double gap_of(const MeshModel& a, const MeshModel& b, const TriangleTest& test, const GapBound& gap) {
  if (gap.count > GapBound::most) return 0;
  double least = gap.of_others;
  for (const auto& [i, j] : std::span(gap.close).first(gap.count)) {
    Corners q = b.corners(j);
    for (Vec3& corner : q) corner = test.in_a(corner);
    least = std::min(least, gap_between(a.corners(i), q) - 4 * test.delta());
  }
  return std::max(0.0, least);
}

}  // namespace tandem
