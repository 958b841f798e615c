#include "meshes/traversal/mesh_traversal.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "meshes/traversal/mesh_traversal.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "meshes/traversal/node_pair_stack.h"
#include "meshes/traversal/traversal_frame.h"
#include "meshes/traversal/triangle_screen-inl.h"
#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

// A box of B in A's frame: middle, half along A's axes and along B's, padded.
struct alignas(32) MappedBoxes {
  Row mid[3], half[3], own[3];
};

Floats spread(const float* row, Floats u, Floats v, Floats w) {
  return dot(hn::Set(tag, std::abs(row[0])), hn::Set(tag, std::abs(row[1])), hn::Set(tag, std::abs(row[2])), u, v, w);
}

// With `gaps` it notes how far apart what it leaves out is.
template <bool gaps>
class Traversal {
 public:
  Traversal(const MeshModel& a, const MeshModel& b, const TraversalFrame& frame, PairVisitor& visitor)
      : a_(a), b_(b), f_(frame), visitor_(visitor), screen_(frame) {}

  void run(NodePair from, bool likely_first) {
    stack_.push(from);
    while (!stack_.empty()) {
      visitor_.meter.spend();
      const NodePair at = stack_.pop();
      const MeshNode &na = a_.nodes[at.a], &nb = b_.nodes[at.b];
      if (na.bottom() && nb.bottom()) {
        if (triangles(na, nb)) return;
        continue;
      }
      const std::size_t first = stack_.size();
      descend(at, na, nb);
      if (likely_first && stack_.size() > first) std::swap(stack_[deepest_at_], stack_[stack_.size() - 1]);
    }
  }

  // Level by level until there are so many.
  std::vector<NodePair> subtrees(std::size_t wanted) {
    std::vector<NodePair> level{{0, 0}}, next;
    for (bool deeper = true; deeper && level.size() < wanted; level.swap(next)) {
      deeper = false;
      next.clear();
      for (const NodePair at : level) {
        const MeshNode &na = a_.nodes[at.a], &nb = b_.nodes[at.b];
        if (na.bottom() && nb.bottom()) {
          next.push_back(at);
          continue;
        }
        deeper = true;
        descend(at, na, nb);
        while (!stack_.empty()) next.push_back(stack_.pop());
      }
    }
    return level;
  }

  // Of all that was left out, in units of A.
  float least_gap() const { return screen_.least_gap(); }

 private:
  void note(Floats gap) { screen_.note(gap); }

  void descend(NodePair at, const MeshNode& na, const MeshNode& nb) {
    deepest_ = 1;
    const float size_a = na.reach(), size_b = f_.ratio * nb.reach();
    if (na.bottom() || (!nb.bottom() && size_a * 4 < size_b))
      descend_b(at, na, nb);
    else if (nb.bottom() || size_b * 4 < size_a)
      descend_a(at, na, nb);
    else
      descend_both(na, nb);
  }

  void map(const LaneBoxes& n, MappedBoxes& out) const {
    for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(tag)) {
      const auto x = hn::Load(tag, n.mid[0] + l), y = hn::Load(tag, n.mid[1] + l), z = hn::Load(tag, n.mid[2] + l);
      const auto u = hn::Load(tag, n.half[0] + l), v = hn::Load(tag, n.half[1] + l), w = hn::Load(tag, n.half[2] + l);
      for (int i = 0; i < 3; ++i) {
        hn::Store(hn::Add(dot(f_.map[i], x, y, z), hn::Set(tag, f_.shift[i])), tag, out.mid[i] + l);
        hn::Store(hn::Add(spread(f_.map[i], u, v, w), hn::Set(tag, f_.pad_a[i])), tag, out.half[i] + l);
      }
      const auto ratio = hn::Set(tag, f_.ratio);
      hn::Store(hn::Add(hn::Mul(ratio, u), hn::Set(tag, f_.pad_b[0])), tag, out.own[0] + l);
      hn::Store(hn::Add(hn::Mul(ratio, v), hn::Set(tag, f_.pad_b[1])), tag, out.own[1] + l);
      hn::Store(hn::Add(hn::Mul(ratio, w), hn::Set(tag, f_.pad_b[2])), tag, out.own[2] + l);
    }
  }

  void map(const float* mid, const float* half, MappedBoxes& out) const {  // one box into the first lane
    for (int i = 0; i < 3; ++i) {
      const float* m = f_.map[i];
      out.mid[i][0] = m[0] * mid[0] + m[1] * mid[1] + m[2] * mid[2] + f_.shift[i];
      out.half[i][0] = std::abs(m[0]) * half[0] + std::abs(m[1]) * half[1] + std::abs(m[2]) * half[2] + f_.pad_a[i];
      out.own[i][0] = f_.ratio * half[i] + f_.pad_b[i];
    }
  }

  // Largest gap along the axes of both between boxes of A, their reaches along B's axes, and boxes of B.
  Floats gap(const Floats (&mid_a)[3], const Floats (&half_a)[3], const Floats (&reach_a)[3], const Floats (&mid_b)[3],
             const Floats (&half_b)[3], const Floats (&own_b)[3]) const {
    const Floats d[3] = {hn::Sub(mid_a[0], mid_b[0]), hn::Sub(mid_a[1], mid_b[1]), hn::Sub(mid_a[2], mid_b[2])};
    Floats g[6];
    for (int i = 0; i < 3; ++i) {
      g[i] = hn::Sub(hn::Abs(d[i]), hn::Add(half_a[i], half_b[i]));
      g[3 + i] = hn::Sub(hn::Abs(dot(f_.inverse[i], d[0], d[1], d[2])), hn::Add(reach_a[i], own_b[i]));
    }
    return hn::Max(largest(g[0], g[1], g[2]), largest(g[3], g[4], g[5]));
  }

  struct Boxes {
    Floats mid[3], half[3], reach[3];
  };
  Boxes lanes_of_a(const LaneBoxes& n, std::size_t l) const {
    Boxes r;
    for (int i = 0; i < 3; ++i) r.mid[i] = hn::Load(tag, n.mid[i] + l), r.half[i] = hn::Load(tag, n.half[i] + l);
    for (int i = 0; i < 3; ++i) r.reach[i] = spread(f_.inverse[i], r.half[0], r.half[1], r.half[2]);
    return r;
  }
  Boxes whole_of_a(const MeshNode& n) const {
    Boxes r;
    for (int i = 0; i < 3; ++i) r.mid[i] = hn::Set(tag, n.box_mid[i]), r.half[i] = hn::Set(tag, n.box_half[i]);
    for (int i = 0; i < 3; ++i) r.reach[i] = spread(f_.inverse[i], r.half[0], r.half[1], r.half[2]);
    return r;
  }

  Floats against_lane(const Boxes& a, const MappedBoxes& b, std::size_t j) const {
    Floats mid[3], half[3], own[3];
    for (int i = 0; i < 3; ++i)
      mid[i] = hn::Set(tag, b.mid[i][j]), half[i] = hn::Set(tag, b.half[i][j]), own[i] = hn::Set(tag, b.own[i][j]);
    return gap(a.mid, a.half, a.reach, mid, half, own);
  }

  // Which of B's lanes the whole of A's node may meet, and how far they reach into it.
  std::uint32_t lanes_of_b(const MeshNode& na, const MappedBoxes& b, Row& depth) {
    const Boxes a = whole_of_a(na);
    std::uint32_t hits = 0;
    for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(tag)) {
      Floats mid[3], half[3], own[3];
      for (int i = 0; i < 3; ++i)
        mid[i] = hn::Load(tag, b.mid[i] + l), half[i] = hn::Load(tag, b.half[i] + l),
        own[i] = hn::Load(tag, b.own[i] + l);
      const Floats worst = gap(a.mid, a.half, a.reach, mid, half, own);
      note(worst);
      hn::Store(worst, tag, depth + l);
      hits |= bits_of(hn::Le(worst, hn::Zero(tag)), l);
    }
    return hits;
  }

  void push(NodePair p, float gap) {
    if (gap < deepest_) deepest_ = gap, deepest_at_ = stack_.size();
    stack_.push(p);
  }

  void descend_b(NodePair at, const MeshNode& na, const MeshNode& nb) {
    const ChildBoxes& boxes_b = b_.boxes_of(nb);
    MappedBoxes b;
    map(boxes_b, b);
    alignas(32) Row depth;
    for (std::uint32_t hits = lanes_of_b(na, b, depth) & nb.used(); hits; hits &= hits - 1) {
      const int j = std::countr_zero(hits);
      push({at.a, boxes_b.child[j]}, depth[j]);
    }
  }

  void push_lanes_of_a(const MeshNode& na, const ChildBoxes& boxes_a, const Boxes& a, std::size_t l,
                       const MappedBoxes& b, std::size_t j, std::uint32_t node_b) {
    const Floats worst = against_lane(a, b, j);
    note(worst);
    std::uint32_t hits = bits_of(hn::Le(worst, hn::Zero(tag)), l) & na.used();
    if (!hits) return;
    alignas(32) Row depth;
    hn::Store(worst, tag, depth + l);
    for (; hits; hits &= hits - 1) {
      const int k = std::countr_zero(hits);
      push({boxes_a.child[k], node_b}, depth[k]);
    }
  }

  void descend_a(NodePair at, const MeshNode& na, const MeshNode& nb) {
    MappedBoxes b;
    map(nb.box_mid, nb.box_half, b);
    const ChildBoxes& boxes_a = a_.boxes_of(na);
    for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(tag))
      push_lanes_of_a(na, boxes_a, lanes_of_a(boxes_a, l), l, b, 0, at.b);
  }

  void descend_both(const MeshNode& na, const MeshNode& nb) {
    const ChildBoxes &boxes_a = a_.boxes_of(na), &boxes_b = b_.boxes_of(nb);
    MappedBoxes b;
    map(boxes_b, b);
    alignas(32) Row depth;
    const std::uint32_t near = lanes_of_b(na, b, depth) & nb.used();
    for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(tag)) {
      const Boxes a = lanes_of_a(boxes_a, l);
      for (std::uint32_t left = near; left; left &= left - 1) {
        const auto j = static_cast<std::size_t>(std::countr_zero(left));
        push_lanes_of_a(na, boxes_a, a, l, b, j, boxes_b.child[j]);
      }
    }
  }

  bool triangles(const MeshNode& na, const MeshNode& nb) {
    return screen_.each(na, a_.blocks[na.block], nb, b_.blocks[nb.block], [&](std::size_t i, std::size_t j) HWY_ATTR {
      return visitor_.visit(a_.order[na.first() + i], b_.order[nb.first() + j]);
    });
  }

  const MeshModel& a_;
  const MeshModel& b_;
  const TraversalFrame& f_;
  PairVisitor& visitor_;
  NodePairStack stack_;
  TriangleScreen<gaps> screen_;
  float deepest_ = 1;
  std::size_t deepest_at_ = 0;
};

}  // namespace

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void run_traversal(const MeshModel& a, const MeshModel& b, const TraversalFrame& frame, NodePair from,
                   bool likely_first, PairVisitor& visitor) {
  Traversal<false>(a, b, frame, visitor).run(from, likely_first);
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
float run_noting_gaps(const MeshModel& a, const MeshModel& b, const TraversalFrame& frame, NodePair from,
                      bool likely_first, PairVisitor& visitor) {
  Traversal<true> traversal(a, b, frame, visitor);
  traversal.run(from, likely_first);
  return traversal.least_gap();
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::vector<NodePair> subtrees_of_traversal(const MeshModel& a, const MeshModel& b, const TraversalFrame& frame,
                                            std::size_t wanted, float& gap) {
  struct Nobody final : PairVisitor {
    Nobody() : PairVisitor(nullptr) {}
    bool visit(std::uint32_t, std::uint32_t) override { return true; }
  } nobody;
  Traversal<true> traversal(a, b, frame, nobody);
  std::vector<NodePair> subtrees = traversal.subtrees(wanted);
  gap = traversal.least_gap();
  return subtrees;
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(run_traversal);
HWY_EXPORT(run_noting_gaps);
HWY_EXPORT(subtrees_of_traversal);

namespace {

// Less than single precision and rotations that are orthonormal to 1e-6 are off by.
void lower(double* gap, double units, const MeshModel& a) {
  if (gap != nullptr) *gap = std::min(*gap, (1 - tolerance::askew_in_floats) * units * a.unit);
}

void traverse(const MeshModel& a, const MeshModel& b, const TraversalFrame& frame, NodePair from, bool likely_first,
              PairVisitor& visitor, double* gap) {
  if (gap == nullptr)
    HWY_DYNAMIC_DISPATCH(run_traversal)(a, b, frame, from, likely_first, visitor);
  else
    lower(gap, static_cast<double>(HWY_DYNAMIC_DISPATCH(run_noting_gaps)(a, b, frame, from, likely_first, visitor)), a);
}

}  // namespace

void traverse(const MeshModel& a, const MeshModel& b, const TriangleTest& frame, bool likely_first,
              PairVisitor& visitor, double* gap) {
  const TraversalFrame in_units(a, b, frame);
  if (in_units.gap > 0)
    lower(gap, in_units.gap, a);
  else
    traverse(a, b, in_units, {0, 0}, likely_first, visitor, gap);
}

std::vector<NodePair> traversal_subtrees(const MeshModel& a, const MeshModel& b, const TriangleTest& frame,
                                         std::size_t wanted, double* gap) {
  const TraversalFrame in_units(a, b, frame);
  if (in_units.gap > 0) {
    lower(gap, in_units.gap, a);
    return {};
  }
  float units;
  std::vector<NodePair> subtrees = HWY_DYNAMIC_DISPATCH(subtrees_of_traversal)(a, b, in_units, wanted, units);
  lower(gap, static_cast<double>(units), a);
  return subtrees;
}

void traverse(const MeshModel& a, const MeshModel& b, const TriangleTest& frame, NodePair subtree, PairVisitor& visitor,
              double* gap) {
  traverse(a, b, TraversalFrame(a, b, frame), subtree, false, visitor, gap);
}

}  // namespace tandem
#endif
