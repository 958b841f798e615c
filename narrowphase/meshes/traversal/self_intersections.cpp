#include "meshes/traversal/self_intersections.h"

#include <algorithm>

#include "meshes/traversal/near_triangles.h"
#include "meshes/traversal/waiting_pairs.h"
#include "shapes/posed_mesh.h"
#include "shapes/run_parts.h"

namespace tandem {
namespace {

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

class SelfIntersections final : public PairVisitor {
 public:
  SelfIntersections(const MeshModel& mesh, std::span<const std::uint32_t> first, Pairs& pairs)
      : PairVisitor(nullptr),
        mesh_(mesh),
        first_(first),
        test_(Pose{}, Pose{}, reach(mesh)),
        waiting_(mesh, mesh, test_),
        pairs_(pairs) {}

  bool visit(std::uint32_t i, std::uint32_t j) override {
    if (!share_vertex(mesh_.triangles[i], mesh_.triangles[j]) && waiting_.add(i, j)) decide();
    return false;
  }
  void decide() {
    waiting_.decide([this](std::uint32_t i, std::uint32_t j, bool meet) {
      if (meet) pairs_.push_back({i, j});
    });
  }

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
  Pairs& pairs_;
};

}  // namespace

Pairs self_intersections(const MeshModel& mesh, std::span<const std::uint32_t> first, const PartRunner& parts) {
  const NearBoxPairs near(mesh, 0);
  const std::vector<NodePair> subtrees = near.subtrees();
  std::vector<Pairs> found(subtrees.size());
  run_parts(parts, subtrees.size(), [&](std::size_t k) {
    SelfIntersections its(mesh, first, found[k]);
    near.visit(subtrees[k], its);
    its.decide();
  });
  Pairs all;
  for (const Pairs& some : found) all.insert(all.end(), some.begin(), some.end());
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace tandem
