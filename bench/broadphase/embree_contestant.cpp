// Embree as a contestant of the broad-phase bench.
#include <embree3/rtcore.h>

#include <mutex>
#include <stdexcept>

#include "contestant.h"

namespace tandem::bench {
namespace {

/// rtcCollide of a scene with itself: reports pairs in both orders, and of boxes that share overlapping leaves.
class EmbreeContestant final : public BoxContestant {
 public:
  EmbreeContestant(bool refit, int threads)
      : refit_(refit),
        threads_(threads),
        device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())),
        scene_(rtcNewScene(device_)) {
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) throw std::runtime_error("Embree: no device");
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_DYNAMIC);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
  }
  EmbreeContestant(const EmbreeContestant&) = delete;
  EmbreeContestant& operator=(const EmbreeContestant&) = delete;
  ~EmbreeContestant() override {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  std::string name() const override { return refit_ ? "Embree refit" : "Embree rebuild"; }
  int threads() const override { return threads_; }
  bool exact() const override { return false; }

  void step(const BoxArray& boxes, PairList& out) override {
    boxes_ = &boxes;
    out_ = &out;
    if (geometry_ == nullptr || size_ != boxes.size()) {
      if (geometry_ != nullptr) rtcDetachGeometry(scene_, 0);
      size_ = boxes.size();
      geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
      rtcSetGeometryBuildQuality(geometry_, refit_ ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_LOW);
      rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(size_));
      rtcSetGeometryUserData(geometry_, this);
      rtcSetGeometryBoundsFunction(geometry_, bounds, this);
      rtcAttachGeometryByID(scene_, geometry_, 0);
      rtcReleaseGeometry(geometry_);  // the scene keeps a reference
    }
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
    rtcCollide(scene_, scene_, put, this);
  }

 private:
  static void bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto& self = *static_cast<const EmbreeContestant*>(arguments->geometryUserPtr);
    const Aabb box = (*self.boxes_)[arguments->primID];
    RTCBounds& b = *arguments->bounds_o;
    b.lower_x = box.lo[0], b.lower_y = box.lo[1], b.lower_z = box.lo[2];
    b.upper_x = box.hi[0], b.upper_y = box.hi[1], b.upper_z = box.hi[2];
  }
  static void put(void* user, RTCCollision* found, unsigned count) {
    auto& self = *static_cast<EmbreeContestant*>(user);
    // Also on one thread: a device's number of threads is an upper bound, which other devices of the process may raise.
    const std::lock_guard lock(self.mutex_);
    for (unsigned i = 0; i < count; ++i)
      if (found[i].primID0 < found[i].primID1) self.out_->put(found[i].primID0, found[i].primID1);
  }

  bool refit_;
  int threads_;
  RTCDevice device_;
  RTCScene scene_;
  RTCGeometry geometry_ = nullptr;
  std::size_t size_ = 0;
  const BoxArray* boxes_ = nullptr;
  PairList* out_ = nullptr;
  std::mutex mutex_;
};

}  // namespace

std::unique_ptr<BoxContestant> embree_contestant(bool refit, int threads) {
  return std::make_unique<EmbreeContestant>(refit, threads);
}

}  // namespace tandem::bench
