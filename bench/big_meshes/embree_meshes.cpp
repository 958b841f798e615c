// Embree as a contestant: hierarchies over the triangles as user primitives, the only ones that rtcCollide takes, which
// finds pairs whose boxes overlap; FCL's triangle test, in double precision, decides the rest.
#include <embree3/rtcore.h>
#include <fcl/narrowphase/detail/traversal/collision/intersect.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

#include "contestant.h"

namespace tandem::bench {
namespace {

class EmbreeScene {
 public:
  EmbreeScene(RTCDevice device, const Mesh& mesh) : mesh_(mesh), scene_(rtcNewScene(device)) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(mesh.triangles.size()));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, &bounds, this);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene() { rtcReleaseScene(scene_); }

  RTCScene scene() const { return scene_; }
  const Mesh& mesh() const { return mesh_; }
  const Vec3& corner(std::uint32_t t, std::size_t k) const { return mesh_.vertices[mesh_.triangles[t][k]]; }

 private:
  static void bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& self = *static_cast<const EmbreeScene*>(arguments->geometryUserPtr);
    Eigen::AlignedBox3d box;
    for (std::size_t k = 0; k < 3; ++k) box.extend(self.corner(arguments->primID, k));
    float* out[2] = {&arguments->bounds_o->lower_x, &arguments->bounds_o->upper_x};
    const float out_of_range = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      out[0][axis] = std::nextafter(static_cast<float>(box.min()[axis]), -out_of_range);
      out[1][axis] = std::nextafter(static_cast<float>(box.max()[axis]), out_of_range);
    }
  }

  const Mesh& mesh_;
  const RTCScene scene_;
};

class EmbreeMeshes final : public MeshContestant {
 public:
  EmbreeMeshes(const MeshesGiven& given, int threads)
      : given_(given), threads_(threads), device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())) {
    rtcSetDeviceMemoryMonitorFunction(device_, &count, &held_);
  }
  EmbreeMeshes(const EmbreeMeshes&) = delete;
  EmbreeMeshes& operator=(const EmbreeMeshes&) = delete;
  ~EmbreeMeshes() override {
    a_.reset(), b_.reset(), self_.reset();
    rtcReleaseDevice(device_);
  }
  std::string name() const override { return "Embree, rtcCollide"; }
  int threads() const override { return threads_; }
  bool is_exact() const override { return false; }

  void build() override { a_.emplace(device_, given_.a); }
  void build_all() override {
    build();
    b_.emplace(device_, given_.b);
    self_.emplace(device_, given_.both);
  }
  std::size_t memory() override {
    const auto before = held_.load();
    const EmbreeScene scene(device_, given_.a);
    return static_cast<std::size_t>(held_ - before) + given_.a.vertices.size() * sizeof(Vec3) +
           given_.a.triangles.size() * sizeof(given_.a.triangles[0]);
  }

  std::optional<TrianglePairs> pairs() override { return collide(*a_, *b_, false); }
  std::optional<TrianglePairs> self_pairs() override { return collide(*self_, *self_, true); }
  std::optional<double> distance(const Pose&) override { return std::nullopt; }

 private:
  struct Search {
    const EmbreeScene &a, &b;
    bool self;
    std::mutex mutex{};
    TrianglePairs pairs{};
  };
  static bool count(void* held, ssize_t bytes, bool) {
    *static_cast<std::atomic<ssize_t>*>(held) += bytes;
    return true;
  }
  static void compare(void* search, RTCCollision* found, unsigned count) {
    auto& s = *static_cast<Search*>(search);
    TrianglePairs pairs;
    for (unsigned k = 0; k < count; ++k) {
      const std::uint32_t i = found[k].primID0, j = found[k].primID1;
      if (s.self && !counts(s.a.mesh(), i, j)) continue;
      if (::fcl::detail::Intersect<double>::intersect_Triangle(s.a.corner(i, 0), s.a.corner(i, 1), s.a.corner(i, 2),
                                                               s.b.corner(j, 0), s.b.corner(j, 1), s.b.corner(j, 2)))
        pairs.push_back({i, j});
    }
    const std::lock_guard lock(s.mutex);
    s.pairs.insert(s.pairs.end(), pairs.begin(), pairs.end());
  }
  static TrianglePairs collide(const EmbreeScene& a, const EmbreeScene& b, bool self) {
    Search search{a, b, self};
    rtcCollide(a.scene(), b.scene(), &compare, &search);
    std::sort(search.pairs.begin(), search.pairs.end());
    search.pairs.erase(std::unique(search.pairs.begin(), search.pairs.end()), search.pairs.end());
    return std::move(search.pairs);
  }

  const MeshesGiven given_;
  const int threads_;
  std::atomic<ssize_t> held_{0};
  const RTCDevice device_;
  std::optional<EmbreeScene> a_, b_, self_;
};

}  // namespace

std::unique_ptr<MeshContestant> embree_meshes(const MeshesGiven& given, int threads) {
  return std::make_unique<EmbreeMeshes>(given, threads);
}

}  // namespace tandem::bench
