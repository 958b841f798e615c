// FCL as a contestant of the bench of large meshes.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>

#include "contestant.h"
#include "fcl_model.h"

namespace tandem::bench {
namespace {

using Model = ::fcl::BVHModel<::fcl::OBBRSS<double>>;

TrianglePairs pairs_of(const Model& a, const Model& b) {
  const ::fcl::Transform3d home = ::fcl::Transform3d::Identity();
  ::fcl::CollisionResultd result;
  ::fcl::collide(&a, home, &b, home, ::fcl::CollisionRequestd(std::size_t{1} << 28, false), result);
  TrianglePairs pairs;
  for (std::size_t k = 0; k < result.numContacts(); ++k)
    pairs.push_back(
        {static_cast<std::uint32_t>(result.getContact(k).b1), static_cast<std::uint32_t>(result.getContact(k).b2)});
  return pairs;
}

class FclMeshes final : public MeshContestant {
 public:
  explicit FclMeshes(const MeshesGiven& given) : given_(given) {}
  std::string name() const override { return "FCL, OBBRSS"; }
  bool is_exact() const override { return false; }
  std::size_t most_triangles() const override { return 1'000'000; }
  // FCL also reports all pairs of triangles that share a vertex: twelve a triangle.
  std::size_t most_triangles_of_self() const override { return 200'000; }

  void build() override { a_ = fcl_model(given_.a); }
  void build_all() override {
    build();
    b_ = fcl_model(given_.b);
    if (given_.both.triangles.size() <= most_triangles_of_self()) self_ = fcl_model(given_.both);
  }
  std::size_t memory() override {
    const std::size_t before = heap_bytes();
    const auto model = fcl_model(given_.a);
    return heap_bytes() - before;
  }

  std::optional<TrianglePairs> pairs() override { return sorted(pairs_of(*a_, *b_)); }
  std::optional<TrianglePairs> self_pairs() override {
    if (!self_) return std::nullopt;
    TrianglePairs all = pairs_of(*self_, *self_);
    const auto& triangles = given_.both.triangles;
    std::erase_if(all, [&](const auto& pair) {
      const auto &p = triangles[pair[0]], &q = triangles[pair[1]];
      return pair[0] >= pair[1] || std::find_first_of(p.begin(), p.end(), q.begin(), q.end()) != p.end();
    });
    return sorted(std::move(all));
  }
  std::optional<double> distance(const Pose& b) override {
    ::fcl::DistanceResultd result;
    return ::fcl::distance(a_.get(), ::fcl::Transform3d::Identity(), b_.get(), transform(b),
                           ::fcl::DistanceRequestd(true), result);
  }

 private:
  static ::fcl::Transform3d transform(const Pose& pose) {
    ::fcl::Transform3d out = ::fcl::Transform3d::Identity();
    out.linear() = pose.rotation;
    out.translation() = pose.translation;
    return out;
  }
  static TrianglePairs sorted(TrianglePairs pairs) {
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

  const MeshesGiven given_;
  std::shared_ptr<Model> a_, b_, self_;
};

}  // namespace

std::unique_ptr<MeshContestant> fcl_meshes(const MeshesGiven& given) { return std::make_unique<FclMeshes>(given); }

}  // namespace tandem::bench
