// The simultaneous traversal of two meshes' hierarchies (vector kernel).
#include "meshes/traversal/mesh_traversal.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "meshes/traversal/mesh_traversal.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, mesh_lanes>;
using Floats = hn::Vec<Tag>;
constexpr Tag tag;

using Row = float[mesh_lanes];

struct alignas(32) MappedTriangles {
  Row corner[3][3], low[3], high[3];
};

template <class Mask>
std::uint32_t bits_of(Mask mask, std::size_t lane) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(tag, mask, bytes);
  return std::uint32_t{bytes[0]} << lane;
}

Floats largest(Floats x, Floats y, Floats z) { return hn::Max(x, hn::Max(y, z)); }

Floats dot(Floats x, Floats y, Floats z, Floats u, Floats v, Floats w) {
  return hn::Add(hn::Add(hn::Mul(x, u), hn::Mul(y, v)), hn::Mul(z, w));
}
Floats dot(const float* row, Floats u, Floats v, Floats w) {
  return dot(hn::Set(tag, row[0]), hn::Set(tag, row[1]), hn::Set(tag, row[2]), u, v, w);
}

/// Screens two blocks for pairs of triangles that are not known to be separated. With `gaps` it keeps lower bounds on
/// the distances of separated ones.
template <bool gaps>
class BlockScreen {
 public:
  explicit BlockScreen(const TraversalFrame& frame) : f_(frame) {}

  // Takes the lanes with a gap above 0, whose pairs are left out.
  void note(Floats gap) {
    if constexpr (gaps) least_gap_ = hn::Min(least_gap_, hn::IfThenElse(hn::Gt(gap, hn::Zero(tag)), gap, least_gap_));
  }
  // Over all pairs left out, in units of A.
  float least_gap() const { return hn::GetLane(hn::MinOfLanes(tag, least_gap_)); }

  // Calls visit(lane of na, lane of nb) for each remaining pair; true ends it, and is returned.
  template <class Visit>
  bool each(const MeshNode& na, const TriangleBlock& block_a, const MeshNode& nb, const TriangleBlock& block_b,
            const Visit& visit) {
    MappedTriangles b;
    map(block_b, b);
    std::uint64_t hits = boxes_meet(na, block_a, nb, b);
    if (hits == 0) return false;
    // Remaining pairs, one a lane: index in B's block and in A's. Entries beyond the last are ignored.
    std::uint8_t pairs[mesh_lanes * (mesh_lanes + 1)];
    std::size_t count = 0;
    for (; hits != 0; hits &= hits - 1) pairs[count++] = static_cast<std::uint8_t>(std::countr_zero(hits));
    std::fill_n(pairs + count, mesh_lanes, std::uint8_t{0});
    for (std::size_t first = 0; first < count; first += hn::Lanes(tag)) {
      std::uint32_t left = not_apart(block_a, b, pairs + first, count - first);
      for (; left != 0; left &= left - 1) {
        const std::uint8_t pair = pairs[first + static_cast<std::size_t>(std::countr_zero(left))];
        if (visit(pair % mesh_lanes, pair / mesh_lanes)) return true;
      }
    }
    return false;
  }

 private:
  // Ignores unused lanes.
  static Floats of_lanes(std::uint32_t lanes, std::size_t l, Floats gap) {
    return hn::IfThenElseZero(hn::Lt(hn::Iota(tag, static_cast<float>(l)), hn::Set(tag, static_cast<float>(lanes))),
                              gap);
  }

  void map(const TriangleBlock& t, MappedTriangles& out) const {
    for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(tag))
      for (int i = 0; i < 3; ++i) {
        Floats p[3];
        for (int c = 0; c < 3; ++c) {
          p[c] = hn::Add(dot(f_.map[i], hn::Load(tag, t.corner[c][0] + l), hn::Load(tag, t.corner[c][1] + l),
                             hn::Load(tag, t.corner[c][2] + l)),
                         hn::Set(tag, f_.shift[i]));
          hn::Store(p[c], tag, out.corner[c][i] + l);
        }
        const auto pad = hn::Set(tag, f_.pad_a[i]);
        hn::Store(hn::Sub(hn::Min(p[0], hn::Min(p[1], p[2])), pad), tag, out.low[i] + l);
        hn::Store(hn::Add(hn::Max(p[0], hn::Max(p[1], p[2])), pad), tag, out.high[i] + l);
      }
  }

  // For each of B's triangles the triangles of A whose boxes overlap its box, eight bits each.
  std::uint64_t boxes_meet(const MeshNode& na, const TriangleBlock& t, const MeshNode& nb, const MappedTriangles& b) {
    std::uint32_t near = 0;
    for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(tag)) {
      auto worst = hn::Set(tag, -1.0f);
      for (int i = 0; i < 3; ++i) {
        const auto low = hn::Set(tag, na.box_mid[i] - na.box_half[i]),
                   high = hn::Set(tag, na.box_mid[i] + na.box_half[i]);
        worst = largest(worst, hn::Sub(hn::Load(tag, b.low[i] + l), high), hn::Sub(low, hn::Load(tag, b.high[i] + l)));
      }
      note(of_lanes(nb.lanes(), l, worst));
      near |= bits_of(hn::Le(worst, hn::Zero(tag)), l);
    }
    near &= nb.used();
    if (near == 0) return 0;
    std::uint64_t hits = 0;
    for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(tag)) {
      Floats low[3], high[3];
      for (int i = 0; i < 3; ++i) {
        const Floats p[3] = {hn::Load(tag, t.corner[0][i] + l), hn::Load(tag, t.corner[1][i] + l),
                             hn::Load(tag, t.corner[2][i] + l)};
        low[i] = hn::Min(p[0], hn::Min(p[1], p[2]));
        high[i] = hn::Max(p[0], hn::Max(p[1], p[2]));
      }
      for (std::uint32_t left = near; left != 0; left &= left - 1) {
        const auto j = static_cast<std::size_t>(std::countr_zero(left));
        auto worst = hn::Set(tag, -1.0f);
        for (int i = 0; i < 3; ++i)
          worst =
              largest(worst, hn::Sub(low[i], hn::Set(tag, b.high[i][j])), hn::Sub(hn::Set(tag, b.low[i][j]), high[i]));
        note(of_lanes(na.lanes(), l, worst));
        hits |= std::uint64_t{bits_of(hn::Le(worst, hn::Zero(tag)), l)} << (mesh_lanes * j);
      }
    }
    return hits & (0x0101010101010101u * na.used());
  }

  using Places = hn::Vec<hn::RebindToSigned<Tag>>;
  static Floats look_up(const float* row, Places places) {
    if constexpr (hn::MaxLanes(tag) == mesh_lanes)
      return hn::TableLookupLanes(hn::Load(tag, row), hn::IndicesFromVec(tag, places));
    else
      return hn::GatherIndex(tag, row, places);
  }

  static Floats cross(const Floats* u, const Floats* v, int i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    return hn::Sub(hn::Mul(u[j], v[k]), hn::Mul(u[k], v[j]));
  }

  // Of the first `count` pairs of a vector, whose boxes overlap, the bits of those that no triangle's plane separates.
  std::uint32_t not_apart(const TriangleBlock& block, const MappedTriangles& b, const std::uint8_t* pairs,
                          std::size_t count) {
    const hn::RebindToSigned<Tag> places;
    const auto pair = hn::PromoteTo(places, hn::LoadU(hn::Rebind<std::uint8_t, Tag>(), pairs));
    const auto in_a = hn::And(pair, hn::Set(places, mesh_lanes - 1)), in_b = hn::ShiftRight<3>(pair);
    Floats p[3][3], q[3][3];
    auto span = hn::Zero(tag);
    for (int i = 0; i < 3; ++i) {
      for (int c = 0; c < 3; ++c) p[c][i] = look_up(block.corner[c][i], in_a), q[c][i] = look_up(b.corner[c][i], in_b);
      const auto low = hn::Min(p[0][i], hn::Min(p[1][i], p[2][i])), high = hn::Max(p[0][i], hn::Max(p[1][i], p[2][i]));
      span = hn::Max(span, hn::Sub(hn::Max(high, look_up(b.high[i], in_b)), hn::Min(low, look_up(b.low[i], in_b))));
    }
    // Every difference is at most `span`, with an error of 2 off plus its rounding: the error of a determinant of them
    // is less than 6 span^2 (6 off + 10 u span), u = 2^-24, and that of a normal less than this over span.
    const auto askew = hn::Mul(
        span, hn::Add(hn::Set(tag, 48 * f_.off),
                      hn::Mul(hn::Set(tag, static_cast<float>(tolerance::determinant_rounding_of_floats)), span)));
    const auto bound = hn::Mul(span, askew), below = hn::Neg(bound);
    auto keep = hn::FirstN(tag, count);
    const auto tell_apart = [&](const Floats(&t)[3][3], const Floats(&other)[3][3]) HWY_ATTR {
      Floats u[3], v[3], n[3], side[3];
      for (int i = 0; i < 3; ++i) u[i] = hn::Sub(t[1][i], t[0][i]), v[i] = hn::Sub(t[2][i], t[0][i]);
      for (int i = 0; i < 3; ++i) n[i] = cross(u, v, i);
      for (int c = 0; c < 3; ++c)
        side[c] = dot(n[0], n[1], n[2], hn::Sub(other[c][0], t[0][0]), hn::Sub(other[c][1], t[0][1]),
                      hn::Sub(other[c][2], t[0][2]));
      const auto lowest = hn::Min(side[0], hn::Min(side[1], side[2])), highest = largest(side[0], side[1], side[2]);
      if constexpr (gaps) {
        const auto beyond = hn::Sub(hn::Max(lowest, hn::Neg(highest)), bound);
        const auto length = hn::Add(hn::Sqrt(dot(n[0], n[1], n[2], n[0], n[1], n[2])), askew);
        note(hn::IfThenElseZero(keep, hn::Div(beyond, length)));
      }
      keep = hn::And(keep, hn::And(hn::Le(lowest, bound), hn::Ge(highest, below)));
    };
    tell_apart(p, q);
    tell_apart(q, p);
    return bits_of(keep, 0);
  }

  const TraversalFrame& f_;
  Floats least_gap_ = hn::Set(tag, std::numeric_limits<float>::infinity());
};

// A box of B in A's frame: centre, half sizes along A's axes and along B's, padded.
struct alignas(32) MappedBoxes {
  Row mid[3], half[3], own[3];
};

Floats spread(const float* row, Floats u, Floats v, Floats w) {
  return dot(hn::Set(tag, std::abs(row[0])), hn::Set(tag, std::abs(row[1])), hn::Set(tag, std::abs(row[2])), u, v, w);
}

// With `gaps` it keeps lower bounds on the distances of the pairs that it leaves out.
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

  std::vector<NodePair> subtrees(std::size_t wanted) {
    return pairs_of_level(a_, b_, wanted, [this](NodePair at, std::vector<NodePair>& next) {
      descend(at, a_.nodes[at.a], b_.nodes[at.b]);
      while (!stack_.empty()) next.push_back(stack_.pop());
    });
  }

  // Over all that was left out, in units of A.
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

  // The largest gap along the axes of both between boxes of A, their extents along B's axes, and boxes of B.
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

  // The lanes of B that A's whole node may overlap, and the depth of the overlap.
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
  BlockScreen<gaps> screen_;
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

TraversalFrame::TraversalFrame(const MeshModel& a, const MeshModel& b, const TriangleTest& frame) {
  const double scale = b.unit / a.unit;
  const Mat3 inv = frame.map().inverse();
  const Vec3 between = (frame.map() * b.centre + (frame.shift() - a.centre)) / a.unit;
  const Vec3 half_a = a.half / a.unit, half_b = frame.map().cwiseAbs() * b.half / a.unit;
  gap = (between.cwiseAbs() - half_a - half_b).maxCoeff() - tolerance::whole_boxes;
  if (!(gap <= 0)) return;
  // Coordinates of A are rounded once, those of B go through three products and sums of rounded factors: 6 units in the
  // last place of the largest term, 2^-24 each. Comparing them adds a few more.
  const Vec3 size = half_a + half_b + between.cwiseAbs();
  const Vec3 pad = tolerance::box_of_floats * size + Vec3::Constant(4 * frame.delta() / a.unit + tolerance::no_extent);
  const Vec3 along_b = 3 * (inv.cwiseAbs() * pad);
  for (int i = 0; i < 3; ++i) {
    shift[i] = static_cast<float>(between[i]);
    pad_a[i] = static_cast<float>(pad[i]);
    pad_b[i] = static_cast<float>(along_b[i]);
    for (int j = 0; j < 3; ++j) {
      map[i][j] = static_cast<float>(frame.map()(i, j) * scale);
      inverse[i][j] = static_cast<float>(inv(i, j));
    }
  }
  ratio = static_cast<float>(scale);
  // These are not compared: 1, 6 and 2 units.
  const Vec3 rounded = 1.3 * std::exp2(-24) * (half_a + 6 * half_b + 2 * between.cwiseAbs());
  off = static_cast<float>((rounded + Vec3::Constant(4 * frame.delta() / a.unit + tolerance::no_extent)).maxCoeff());
}

namespace {

// Lowers a gap by the errors of single precision and of rotations that are orthonormal to 1e-6.
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
