// CGAL as a contestant of the broad-phase bench.
#include <CGAL/Box_intersection_d/Box_d.h>
#include <CGAL/box_intersection_d.h>

#include "contestant.h"

namespace tandem::bench {
namespace {

/// box_self_intersection_d on closed boxes, from scratch each step (Zomorodian and Edelsbrunner 2002).
class CgalContestant final : public BoxContestant {
 public:
  std::string name() const override { return "CGAL boxes"; }

  void step(const BoxArray& boxes, PairList& out) override {
    boxes_.clear();
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Aabb box = boxes[i];
      if (box.lo[0] <= box.hi[0]) boxes_.emplace_back(box, static_cast<std::uint32_t>(i));
    }
    CGAL::box_self_intersection_d(boxes_.begin(), boxes_.end(),
                                  [&](const Box& a, const Box& b) { out.put(a.index, b.index); });
  }

 private:
  struct Box : CGAL::Box_intersection_d::Box_d<float, 3, CGAL::Box_intersection_d::ID_EXPLICIT> {
    Box(Aabb box, std::uint32_t index) : Box_d(box.lo.data(), box.hi.data()), index(index) {}
    std::uint32_t index;
  };
  std::vector<Box> boxes_;
};

}  // namespace

std::unique_ptr<BoxContestant> cgal_contestant() { return std::make_unique<CgalContestant>(); }

}  // namespace tandem::bench
