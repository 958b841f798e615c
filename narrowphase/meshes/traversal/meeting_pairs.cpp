#include "meshes/traversal/meeting_pairs.h"

#include <algorithm>
#include <span>

#include "meshes/traversal/mesh_nearest.h"
#include "meshes/traversal/mesh_traversal.h"
#include "meshes/traversal/point_in_mesh.h"
#include "meshes/traversal/waiting_pairs.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"

namespace tandem {
namespace {

// Collects the pairs of triangles that meet, exactly, or only whether there is one; and what is known if there is none.
class MeetingPairs final : public PairVisitor {
 public:
  MeetingPairs(const MeshModel& a, const MeshModel& b, TriangleTest& test, TrianglePairs* pairs, GapBound* gap)
      : waiting_(a, b, test), pairs_(pairs), gap_(gap) {
    traverse(a, b, test, pairs == nullptr, *this, gap == nullptr ? nullptr : &gap->of_others);
    decide_waiting();
  }
  MeetingPairs(const MeshModel& a, const MeshModel& b, TriangleTest& test, NodePair subtrees, TrianglePairs& pairs,
               GapBound* gap)
      : waiting_(a, b, test), pairs_(&pairs), gap_(gap) {
    traverse(a, b, test, subtrees, *this, gap == nullptr ? nullptr : &gap->of_others);
    decide_waiting();
  }

  bool any() const { return any_; }

  bool visit(std::uint32_t i, std::uint32_t j) override {
    if (waiting_.add(i, j) || pairs_ == nullptr) decide_waiting();
    return pairs_ == nullptr && any_;
  }

 private:
  void decide_waiting() {
    waiting_.decide([this](std::uint32_t i, std::uint32_t j, bool meet) {
      if (meet) {
        any_ = true;
        if (pairs_ != nullptr) pairs_->push_back({i, j});
      } else if (gap_ != nullptr) {
        gap_->add({i, j});
      }
    });
  }

  WaitingPairs waiting_;
  TrianglePairs* pairs_;
  GapBound* gap_;
  bool any_ = false;
};

// How far apart two triangles that do not meet are, or a little less.
double gap_between(const Corners& p, const Corners& q) {
  Nearest nearest;
  triangles_nearest(p, q, nearest);
  if (!(nearest.distance > 0)) return 0;
  // Points found may be a little farther from each other than the nearest: what counts is what lies between two planes.
  const Vec3 normal = (nearest.on_b - nearest.on_a) / nearest.distance;
  double far_p = 0, near_q = infinity, span = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    far_p = std::max(far_p, normal.dot(p[k] - p[0]));
    near_q = std::min(near_q, normal.dot(q[k] - p[0]));
    span = std::max({span, (p[k] - p[0]).lpNorm<1>(), (q[k] - p[0]).lpNorm<1>()});
  }
  return std::max(0.0,
                  (1 - tolerance::askew_with_room) * (near_q - far_p) - tolerance::place_rounding_of_nearest * span);
}

}  // namespace

TrianglePairs meeting_pairs(const Posed& a, const Posed& b, TriangleTest& test, const PartRunner& runner,
                            PairMemory& memory, GapBound* gap) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  constexpr std::size_t large = 16384, wanted = 64;  // triangles of both; pairs of subtrees
  std::vector<NodePair> subtrees;
  if (runner && ma.triangles.size() + mb.triangles.size() >= large)
    subtrees = traversal_subtrees(ma, mb, test, wanted, gap == nullptr ? nullptr : &gap->of_others);
  TrianglePairs pairs(&memory.resource);
  if (subtrees.size() < wanted) {
    MeetingPairs(ma, mb, test, &pairs, gap);
  } else {
    std::vector<TrianglePairs> found(subtrees.size());
    std::vector<GapBound> gaps(gap == nullptr ? 0 : subtrees.size());
    runner(subtrees.size(), [&](std::size_t k) {
      TriangleTest own(a.pose, b.pose, reach(mb));
      MeetingPairs(ma, mb, own, subtrees[k], found[k], gap == nullptr ? nullptr : &gaps[k]);
    });
    for (const GapBound& there : gaps) gap->join(there);
    for (const TrianglePairs& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
  }
  std::sort(pairs.begin(), pairs.end(), [](const auto& x, const auto& y) {
    return (std::uint64_t{x[0]} << 32 | x[1]) < (std::uint64_t{y[0]} << 32 | y[1]);
  });
  return pairs;
}

bool has_inside(const Posed& outer, const Posed& inner) {
  const MeshModel &o = mesh_of(outer.shape), &i = mesh_of(inner.shape);
  return o.solid && std::any_of(i.components().begin(), i.components().end(), [&](const MeshModel::Component& component) {
           return is_inside(o, outer.pose, i.vertices[component[0]], inner.pose);
         });
}

bool meshes_collide(const Posed& a, const Posed& b) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  TriangleTest test(a.pose, b.pose, reach(mb));
  return MeetingPairs(ma, mb, test, nullptr, nullptr).any() || is_contained(a, b);
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
