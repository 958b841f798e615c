// Gaps between a box and the boxes of a node (vector kernel).
#include "meshes/traversal/mesh_query.h"

#include "lanes/lanes_of_256_bits.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "meshes/traversal/mesh_query.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

namespace {

// The centres and half sizes of an inner node's boxes from lane l on.
struct StoredBoxes {
  const LaneBoxes& boxes;
  template <class Tag, class Lanes>
  HWY_INLINE void load(Tag tag, std::size_t l, Lanes (&mid)[3], Lanes (&half)[3]) const {
    for (int i = 0; i < 3; ++i) mid[i] = hn::Load(tag, boxes.mid[i] + l), half[i] = hn::Load(tag, boxes.half[i] + l);
  }
};
// The boxes of a bottom node's triangles, as in MeshModel::boxes_of_triangles.
struct BoxesOfTriangles {
  const TriangleBlock& block;
  float pad;
  template <class Tag, class Lanes>
  HWY_INLINE void load(Tag tag, std::size_t l, Lanes (&mid)[3], Lanes (&half)[3]) const {
    for (int i = 0; i < 3; ++i) {
      const auto p = hn::Load(tag, block.corner[0][i] + l), q = hn::Load(tag, block.corner[1][i] + l),
                 r = hn::Load(tag, block.corner[2][i] + l);
      const auto low = hn::Min(p, hn::Min(q, r)), high = hn::Max(p, hn::Max(q, r));
      mid[i] = hn::Mul(hn::Add(low, high), hn::Set(tag, 0.5f));
      half[i] = hn::Add(hn::Max(hn::Sub(high, mid[i]), hn::Sub(mid[i], low)), hn::Set(tag, pad));
    }
  }
};

template <class Source>
HWY_INLINE std::uint32_t find_gaps_of(const QueryBox* box, const Source& source, bool squared, float reach,
                                      NodeGaps* out) {
  const hn::CappedTag<float, mesh_lanes> tag;
  const auto number = [&](float x) HWY_ATTR { return hn::Set(tag, x); };
  const auto zero = hn::Zero(tag);
  const auto dot = [&](float x, float y, float z, auto u, auto v, auto w) HWY_ATTR {
    return hn::Add(hn::Add(hn::Mul(number(x), u), hn::Mul(number(y), v)), hn::Mul(number(z), w));
  };
  const auto square = [&](auto x) HWY_ATTR {
    const auto positive = hn::Max(x, zero);
    return hn::Mul(positive, positive);
  };
  std::uint32_t within = 0;
  for (std::size_t l = 0; l < mesh_lanes; l += hn::Lanes(tag)) {
    hn::Vec<decltype(tag)> mids[3], halves[3];
    source.load(tag, l, mids, halves);
    const auto x = mids[0], y = mids[1], z = mids[2], u = halves[0], v = halves[1], w = halves[2];
    const auto along = [&](int i, auto mid, auto half) HWY_ATTR {
      return hn::Sub(hn::Abs(hn::Sub(mid, number(box->mid[i]))), hn::Add(half, number(box->half[i])));
    };
    const auto own = [&](int i) HWY_ATTR {
      const float* a = box->axes[i];
      const auto centre_offset = hn::Sub(dot(a[0], a[1], a[2], x, y, z), number(box->own_mid[i]));
      const auto extent = dot(std::abs(a[0]), std::abs(a[1]), std::abs(a[2]), u, v, w);
      return hn::Sub(hn::Abs(centre_offset), hn::Add(extent, number(box->own_half[i])));
    };
    const auto a0 = along(0, x, u), a1 = along(1, y, v), a2 = along(2, z, w), b0 = own(0), b1 = own(1), b2 = own(2);
    const auto gap = squared ? hn::Max(hn::Add(hn::Add(square(a0), square(a1)), square(a2)),
                                       hn::Add(hn::Add(square(b0), square(b1)), square(b2)))
                             : hn::Max(hn::Max(hn::Max(a0, a1), a2), hn::Max(hn::Max(b0, b1), b2));
    hn::Store(gap, tag, out->lane + l);
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(tag, hn::Le(gap, number(reach)), bytes);
    within |= std::uint32_t{bytes[0]} << l;
  }
  return within;
}

}  // namespace

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void find_gaps(const QueryBox* box, const MeshModel* mesh, const MeshNode* node, bool squared, float reach,
               NodeGaps* out) {
  const std::uint32_t within =
      node->bottom()
          ? find_gaps_of(box, BoxesOfTriangles{mesh->blocks[node->block], box->corner_pad}, squared, reach, out)
          : find_gaps_of(box, StoredBoxes{mesh->boxes_of(*node)}, squared, reach, out);
  out->within = within & node->used();
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(find_gaps);

void find_gaps(const QueryBox& box, const MeshModel& mesh, const MeshNode& node, bool squared, float reach,
               NodeGaps& gaps) {
  HWY_DYNAMIC_DISPATCH(find_gaps)(&box, &mesh, &node, squared, reach, &gaps);
}
}  // namespace tandem
#endif
