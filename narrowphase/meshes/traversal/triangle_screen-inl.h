// Triangles of two blocks, eight and eight, that may meet: by their boxes, then by their planes. In floats with a bound
// on their error, for the instruction set that the including file is compiled for.
#if defined(TANDEM_NARROWPHASE_TRIANGLE_SCREEN_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TANDEM_NARROWPHASE_TRIANGLE_SCREEN_INL_H
#undef TANDEM_NARROWPHASE_TRIANGLE_SCREEN_INL_H
#else
#define TANDEM_NARROWPHASE_TRIANGLE_SCREEN_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "meshes/traversal/traversal_frame.h"
#include "shapes/mesh_model.h"
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

/// Of two blocks, those of a triangle each that are not known to be apart. With `gaps` it notes how far apart what it
/// leaves out is.
template <bool gaps>
class TriangleScreen {
 public:
  explicit TriangleScreen(const TraversalFrame& frame) : f_(frame) {}

  // What the lanes with a gap above 0 say of pairs that are left out.
  void note(Floats gap) {
    if constexpr (gaps) least_gap_ = hn::Min(least_gap_, hn::IfThenElse(hn::Gt(gap, hn::Zero(tag)), gap, least_gap_));
  }
  // Of all that was left out, in units of A.
  float least_gap() const { return hn::GetLane(hn::MinOfLanes(tag, least_gap_)); }

  // Calls visit(lane of na, lane of nb) for each pair; true ends it, and is returned.
  template <class Visit>
  bool each(const MeshNode& na, const TriangleBlock& block_a, const MeshNode& nb, const TriangleBlock& block_b,
            const Visit& visit) {
    MappedTriangles b;
    map(block_b, b);
    std::uint64_t hits = boxes_meet(na, block_a, nb, b);
    if (hits == 0) return false;
    // Pairs that are left, one a lane: place in B's block and in A's. What lies beyond the last counts for nothing.
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
  // Lanes beyond those in use say nothing.
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

  // Which of A's triangles, eight bits each, boxes do not tell from each of B's.
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

  // Which of the first `count` of a vector of pairs, whose boxes meet, the triangles' planes do not tell apart.
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
    // Every difference is at most `span`, and wrong by 2 off plus its rounding: a determinant of them is wrong by
    // less than 6 span^2 (6 off + 10 u span), u = 2^-24, and a normal by less than that over span.
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

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
