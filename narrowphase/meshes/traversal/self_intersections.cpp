// Self-intersections of a mesh, exactly.
#include "meshes/traversal/self_intersections.h"

#include <algorithm>

#include "meshes/traversal/meeting_pairs.h"
#include "meshes/traversal/near_triangles.h"
#include "shapes/posed_mesh.h"
#include "shapes/run_parts.h"

namespace tandem {
namespace {

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

using Pair = std::array<std::uint32_t, 2>;

// Calls report(pair) for intersecting pairs; false ends it.
template <class Report>
class SelfIntersections final : public PairVisitor {
 public:
  SelfIntersections(const MeshModel& mesh, std::span<const std::uint32_t> first, Report report, const WorkLimit* limit)
      : PairVisitor(limit),
        mesh_(mesh),
        first_(first),
        test_(Pose{}, Pose{}, reach(mesh)),
        waiting_(mesh, mesh, test_),
        report_(report) {}

  bool visit(std::uint32_t i, std::uint32_t j) override {
    if (!share_vertex(mesh_.triangles[i], mesh_.triangles[j]) && waiting_.add(i, j)) decide();
    return ended_;
  }
  void decide() {
    meter.spend(4);  // some twenty comparisons
    waiting_.decide([this](std::uint32_t i, std::uint32_t j, bool meet) {
      if (meet && !ended_) ended_ = !report_(Pair{i, j});
    });
  }
  bool ended() const { return ended_; }

 private:
  bool share_vertex(const std::array<std::uint32_t, 3>& p, const std::array<std::uint32_t, 3>& q) const {
    const std::uint32_t u = first_[q[0]], v = first_[q[1]], w = first_[q[2]];
    return std::any_of(p.begin(), p.end(), [&](std::uint32_t corner) {
      const std::uint32_t at = first_[corner];
      return at == u || at == v || at == w;
    });
  }

  const MeshModel& mesh_;
  const std::span<const std::uint32_t> first_;
  TriangleTest test_;
  WaitingPairs waiting_;
  Report report_;
  bool ended_ = false;
};

}  // namespace

Pairs self_intersections(const MeshModel& mesh, std::span<const std::uint32_t> first, const PartRunner& parts) {
  const NearBoxPairs near(mesh, 0);
  const std::vector<NodePair> subtrees = near.subtrees();
  std::vector<Pairs> found(subtrees.size());
  run_parts(parts, subtrees.size(), [&](std::size_t k) {
    const auto keep = [&](const Pair& pair) { return found[k].push_back(pair), true; };
    SelfIntersections its(mesh, first, keep, nullptr);
    near.visit(subtrees[k], its);
    its.decide();
  });
  Pairs all;
  for (const Pairs& some : found) all.insert(all.end(), some.begin(), some.end());
  std::sort(all.begin(), all.end());
  return all;
}

SearchEnd visit_self_intersections(const MeshModel& mesh, std::span<const std::uint32_t> first,
                                   const std::function<bool(const Pair&)>& visitor, const SearchOptions& options) {
  const auto report = [&](const Pair& pair) { return visitor(pair); };
  SelfIntersections its(mesh, first, report, options.limit);
  return visit_in_turn(NearBoxPairs(mesh, 0), its, options, [&] {
    its.decide();
    return its.ended();
  });
}

}  // namespace tandem
