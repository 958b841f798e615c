// FCL as a contestant of the bench of large meshes.
#include <fcl/narrowphase/distance.h>

#include "contestant.h"
#include "fcl_model.h"
#include "fcl_shape.h"

namespace tandem::bench {
namespace {

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

  std::optional<TrianglePairs> pairs() override { return fcl_pairs(*a_, *b_, nullptr); }
  std::optional<TrianglePairs> self_pairs() override {
    if (!self_) return std::nullopt;
    return fcl_pairs(*self_, *self_, &given_.both);
  }
  std::optional<double> distance(const Pose& b) override {
    ::fcl::DistanceResultd result;
    return ::fcl::distance(a_.get(), ::fcl::Transform3d::Identity(), b_.get(), fcl_pose(b),
                           ::fcl::DistanceRequestd(true), result);
  }

 private:
  const MeshesGiven given_;
  std::shared_ptr<FclModel> a_, b_, self_;
};

}  // namespace

std::unique_ptr<MeshContestant> fcl_meshes(const MeshesGiven& given) { return std::make_unique<FclMeshes>(given); }

}  // namespace tandem::bench
