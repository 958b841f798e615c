// tandem as a contestant of the bench of large meshes.
#include <malloc.h>
#include <oneapi/tbb/parallel_for.h>

#include "contestant.h"
#include "tandem/narrowphase/build_options.h"
#include "tandem/narrowphase/deformable_mesh.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::bench {
namespace {

PartRunner runner(int threads) {
  if (threads == 1) return {};
  return [](std::size_t parts, const auto& part) { tbb::parallel_for(std::size_t{0}, parts, part); };
}

class TandemMeshes final : public MeshContestant {
 public:
  TandemMeshes(const MeshesGiven& given, int threads)
      : given_(given), threads_(threads), parts_(runner(threads)), narrow_phase_({.parts = parts_}) {}
  std::string name() const override { return "tandem"; }
  int threads() const override { return threads_; }
  bool is_exact() const override { return true; }

  void build() override { a_.emplace(given_.a, BuildOptions{.parts = parts_}); }
  void build_all() override {
    build();
    b_.emplace(given_.b, BuildOptions{.parts = parts_});
    self_.emplace(given_.both, parts_);
  }
  std::size_t memory() override { return Shape(given_.a).memory(); }

  std::optional<TrianglePairs> pairs() override {
    return narrow_phase_.intersecting_triangles(*a_, Pose{}, *b_, Pose{});
  }
  std::optional<TrianglePairs> self_pairs() override { return self_->self_intersections(parts_); }
  std::optional<double> distance(const Pose& b) override {
    return narrow_phase_.solve(*a_, Pose{}, *b_, b, Request::distance).signed_distance;
  }

 private:
  const MeshesGiven given_;
  const int threads_;
  const PartRunner parts_;
  std::optional<Shape> a_, b_;
  std::optional<DeformableMesh> self_;
  const NarrowPhase narrow_phase_;
};

}  // namespace

std::unique_ptr<MeshContestant> tandem_meshes(const MeshesGiven& given, int threads) {
  return std::make_unique<TandemMeshes>(given, threads);
}

std::size_t heap_bytes() {
  const auto held = mallinfo2();
  return held.uordblks + held.hblkhd;
}

}  // namespace tandem::bench
