// Bullet as a contestant of the broad-phase bench.
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#include <utility>

#include "contestant.h"

namespace tandem::bench {
namespace {

/// btDbvtBroadphase: enlarges boxes so that they rarely leave those of its tree, and reports the pairs of the enlarged
/// ones.
class BulletContestant final : public BoxContestant {
 public:
  BulletContestant() = default;
  BulletContestant(const BulletContestant&) = delete;
  BulletContestant& operator=(const BulletContestant&) = delete;
  ~BulletContestant() override {
    // Otherwise each proxy would be searched for among all pairs.
    broadphase_.getOverlappingPairCache()->getOverlappingPairArray().clear();
    for (btBroadphaseProxy* proxy : proxies_)
      if (proxy != nullptr) broadphase_.destroyProxy(proxy, nullptr);
  }

  std::string name() const override { return "Bullet dbvt"; }
  bool exact() const override { return false; }

  void changes(std::span<const std::uint8_t> changed) override { changed_ = changed; }

  void step(const BoxArray& boxes, PairList& out) override {
    for (std::size_t i = boxes.size(); i < proxies_.size(); ++i) remove(i);
    proxies_.resize(boxes.size(), nullptr);
    const std::span<const std::uint8_t> changed = std::exchange(changed_, {});
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (!changed.empty() && changed[i] == 0) continue;
      const Aabb box = boxes[i];
      if (!(box.lo[0] <= box.hi[0])) {
        remove(i);
        continue;
      }
      const btVector3 lo(box.lo[0], box.lo[1], box.lo[2]), hi(box.hi[0], box.hi[1], box.hi[2]);
      if (proxies_[i] != nullptr) {
        broadphase_.setAabb(proxies_[i], lo, hi, nullptr);
      } else {
        proxies_[i] = broadphase_.createProxy(lo, hi, 0, nullptr, 1, 1, nullptr);
        proxies_[i]->m_clientObject = reinterpret_cast<void*>(i);
      }
    }
    broadphase_.calculateOverlappingPairs(nullptr);
    const auto& pairs = broadphase_.getOverlappingPairCache()->getOverlappingPairArray();
    for (int k = 0; k < pairs.size(); ++k) out.put(index(pairs[k].m_pProxy0), index(pairs[k].m_pProxy1));
  }

 private:
  static std::uint32_t index(const btBroadphaseProxy* proxy) {
    return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(proxy->m_clientObject));
  }
  void remove(std::size_t i) {
    if (proxies_[i] == nullptr) return;
    broadphase_.destroyProxy(proxies_[i], nullptr);
    proxies_[i] = nullptr;
  }

  btDbvtBroadphase broadphase_;
  std::vector<btBroadphaseProxy*> proxies_;
  std::span<const std::uint8_t> changed_;
};

}  // namespace

std::unique_ptr<BoxContestant> bullet_contestant() { return std::make_unique<BulletContestant>(); }

}  // namespace tandem::bench
