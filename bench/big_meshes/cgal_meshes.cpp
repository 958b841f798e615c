// CGAL as a contestant: its pairs of boxes (Zomorodian and Edelsbrunner 2002) with exact predicates. Timed as built is
// its AABB tree, which answers rays and points, not two meshes.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>

#include "contestant.h"

namespace tandem::bench {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;

Triangles triangles_of(const Mesh& mesh) {
  const auto point = [&](std::uint32_t v) {
    const Vec3& p = mesh.vertices[v];
    return Kernel::Point_3(p.x(), p.y(), p.z());
  };
  Triangles out;
  for (const auto& t : mesh.triangles) out.emplace_back(point(t[0]), point(t[1]), point(t[2]));
  return out;
}

std::vector<Box> boxes_of(const Triangles& triangles) {
  std::vector<Box> boxes;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) boxes.emplace_back(triangles[t].bbox(), t);
  return boxes;
}

class CgalMeshes final : public MeshContestant {
 public:
  explicit CgalMeshes(const MeshesGiven& given) : given_(given) {}
  std::string name() const override { return "CGAL"; }
  bool is_exact() const override { return true; }

  void build() override {
    a_ = triangles_of(given_.a);
    tree_ = std::make_unique<Tree>(a_.begin(), a_.end());
    tree_->build();
  }
  void build_all() override {
    build();
    b_ = triangles_of(given_.b);
    self_ = triangles_of(given_.both);
  }
  std::size_t memory() override {
    const std::size_t before = heap_bytes();
    const Triangles triangles = triangles_of(given_.a);
    Tree tree(triangles.begin(), triangles.end());
    tree.build();
    return heap_bytes() - before;
  }

  // CGAL has no hierarchy for pairs: the boxes are sorted each time.
  std::optional<TrianglePairs> pairs() override {
    std::vector<Box> boxes_a = boxes_of(a_), boxes_b = boxes_of(b_);
    TrianglePairs pairs;
    CGAL::box_intersection_d(boxes_a.begin(), boxes_a.end(), boxes_b.begin(), boxes_b.end(),
                             [&](const Box& x, const Box& y) {
                               if (CGAL::do_intersect(a_[x.info()], b_[y.info()]))
                                 pairs.push_back({x.info(), y.info()});
                             });
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }
  std::optional<TrianglePairs> self_pairs() override {
    std::vector<Box> boxes = boxes_of(self_);
    TrianglePairs pairs;
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& x, const Box& y) {
      const auto &p = given_.both.triangles[x.info()], &q = given_.both.triangles[y.info()];
      if (std::find_first_of(p.begin(), p.end(), q.begin(), q.end()) != p.end()) return;
      if (CGAL::do_intersect(self_[x.info()], self_[y.info()]))
        pairs.push_back({std::min(x.info(), y.info()), std::max(x.info(), y.info())});
    });
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }
  std::optional<double> distance(const Pose&) override { return std::nullopt; }

 private:
  const MeshesGiven given_;
  Triangles a_, b_, self_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace

std::unique_ptr<MeshContestant> cgal_meshes(const MeshesGiven& given) { return std::make_unique<CgalMeshes>(given); }

}  // namespace tandem::bench
