// Points in registers, and the support functions of single polytopes, for the instruction set that the including file
// is compiled for.
#if defined(TANDEM_NARROWPHASE_CORE_SEARCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TANDEM_NARROWPHASE_CORE_SEARCH_INL_H
#undef TANDEM_NARROWPHASE_CORE_SEARCH_INL_H
#else
#define TANDEM_NARROWPHASE_CORE_SEARCH_INL_H
#endif

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cmath>

#include "lanes/fetch_ahead.h"
#include "shapes/core_point-inl.h"
#include "shapes/minkowski_difference.h"
#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Three numbers that stay in registers: written to memory one by one and read two at a time, as Eigen does, they would
/// wait for the store.
struct Point {
  double x, y, z;

  HWY_INLINE Point operator-(const Point& p) const { return {x - p.x, y - p.y, z - p.z}; }
  HWY_INLINE Point operator+(const Point& p) const { return {x + p.x, y + p.y, z + p.z}; }
  HWY_INLINE Point operator-() const { return {-x, -y, -z}; }
  HWY_INLINE double dot(const Point& p) const { return x * p.x + y * p.y + z * p.z; }
  HWY_INLINE Point plus(double s, const Point& p) const { return {x + s * p.x, y + s * p.y, z + s * p.z}; }
  HWY_INLINE Point cross(const Point& p) const { return {y * p.z - z * p.y, z * p.x - x * p.z, x * p.y - y * p.x}; }
  Vec3 vec() const { return {x, y, z}; }
};
HWY_INLINE Point point(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// The vertices, of `Blocks` blocks, within the slack of the farthest along (x, y, z), a bit each.
template <std::size_t Blocks>
HWY_INLINE std::uint64_t farthest_of(const SupportMap::Block* b, float x, float y, float z, float slack) {
  const hn::CappedTag<float, SupportMap::block> tag;
  using V = decltype(hn::Zero(tag));
  constexpr std::size_t lanes = hn::MaxLanes(tag), vectors = SupportMap::block / lanes;
  const V dx = hn::Set(tag, x), dy = hn::Set(tag, y), dz = hn::Set(tag, z);
  V along[Blocks * vectors];
  for (std::size_t i = 0; i < Blocks * vectors; ++i) {
    const SupportMap::Block& block = b[i / vectors];
    const std::size_t l = i % vectors * lanes;
    along[i] = hn::Add(hn::Add(hn::Mul(hn::Load(tag, block.x + l), dx), hn::Mul(hn::Load(tag, block.y + l), dy)),
                       hn::Mul(hn::Load(tag, block.z + l), dz));
  }
  V top = along[0];
  for (std::size_t i = 1; i < Blocks * vectors; ++i) top = hn::Max(top, along[i]);
  const V threshold = hn::Sub(hn::MaxOfLanes(tag, top), hn::Set(tag, slack));
  std::uint64_t near = 0;
  for (std::size_t i = 0; i < Blocks * vectors; ++i) {
    std::uint8_t mask[8];
    hn::StoreMaskBits(tag, hn::Ge(along[i], threshold), mask);
    near |= std::uint64_t{mask[0]} << (i * lanes);
  }
  return near;
}

/// The vertices, of up to 32, within the slack of the farthest along (x, y, z), a bit each.
HWY_INLINE std::uint64_t farthest_of(const SupportMap::Block* b, std::size_t vertices, float x, float y, float z,
                                     float slack) {
  const auto search = [&]() HWY_ATTR {
    switch ((vertices - 1) / SupportMap::block) {
      case 0:
        return farthest_of<1>(b, x, y, z, slack);
      case 1:
        return farthest_of<2>(b, x, y, z, slack);
      case 2:
        return farthest_of<3>(b, x, y, z, slack);
      default:
        return farthest_of<4>(b, x, y, z, slack);
    }
  };
  return search() & ~std::uint64_t{0} >> (64 - vertices);
}

/// A shape's core, prepared for searches of its farthest points.
class Core {
 public:
  static constexpr std::size_t most_vertices = 32;  ///< of a small hull
  static constexpr std::size_t most_blocks = most_vertices / SupportMap::block;

  explicit Core(const ConvexView& v) : view_(v) {
    if (v.kind != ShapeKind::convex || v.vertices.size() <= 4 || v.vertices.size() > most_vertices) return;
    const SupportMap& map = v.hull->support;
    blocks_ = map.blocks();
    const std::array<float, 3>& s = map.slack();
    slack_ = static_cast<float>(tolerance::bound_in_floats) * std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
  }
  /// Prefetches all vertices of a small hull.
  HWY_INLINE void fetch() const {
    if (small_hull()) fetch_ahead(view_.vertices);
  }
  /// True if the vertices are searched in blocks.
  bool small_hull() const { return blocks_ != nullptr; }
  /// Rotates the blocks, so that directions need not be; the slack must then allow for more rounding.
  HWY_INLINE void turn(const MinkowskiDifference& d, SupportMap::Block* turned) {
    const hn::CappedTag<float, SupportMap::block> tag;
    float m[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m[i][j] = static_cast<float>(d.pose.rotation(i, j));
    for (std::size_t first = 0; first < view_.vertices.size(); first += SupportMap::block) {
      const SupportMap::Block& from = blocks_[first / SupportMap::block];
      SupportMap::Block& to = turned[first / SupportMap::block];
      for (std::size_t l = 0; l < SupportMap::block; l += hn::Lanes(tag)) {
        const auto x = hn::Load(tag, from.x + l), y = hn::Load(tag, from.y + l), z = hn::Load(tag, from.z + l);
        const auto row = [&](int k) HWY_ATTR {
          return hn::Add(hn::Add(hn::Mul(hn::Set(tag, m[k][0]), x), hn::Mul(hn::Set(tag, m[k][1]), y)),
                         hn::Mul(hn::Set(tag, m[k][2]), z));
        };
        hn::Store(row(0), tag, to.x + l);
        hn::Store(row(1), tag, to.y + l);
        hn::Store(row(2), tag, to.z + l);
      }
    }
    blocks_ = turned;
    slack_ *= 4;
  }
  /// The vertex of a small hull farthest along n, in the frame of its blocks; false if rounding could decide.
  HWY_INLINE bool farthest_vertex(const Point& n, double length, std::uint32_t& vertex, Point& out) const {
    if (!(length > tolerance::shortest_in_floats && length < 1e25)) return false;
    const std::uint64_t near =
        farthest_of(blocks_, view_.vertices.size(), static_cast<float>(n.x), static_cast<float>(n.y),
                    static_cast<float>(n.z), slack_ * static_cast<float>(length));
    if (!std::has_single_bit(near)) return false;
    // All vertices are in the blocks in order, so a vertex's position is its index.
    vertex = static_cast<std::uint32_t>(hwy::Num0BitsBelowLS1Bit_Nonzero64(near));
    const double* const p = view_.vertices[vertex].data();
    out = {p[0], p[1], p[2]};
    return true;
  }
  /// The point of any core farthest along n, in its frame.
  HWY_INLINE std::uint32_t farthest(const Point& n, Point& out) const {
    const SupportPoint p = core_point(view_, n.vec());
    out = {p.p[0], p.p[1], p.p[2]};
    return p.vertex;
  }

 private:
  const ConvexView& view_;
  const SupportMap::Block* blocks_ = nullptr;  ///< null: not a small hull
  float slack_ = 0;
};

/// The columns of a matrix, for products with vectors.
struct Columns {
  HWY_ALIGN double column[3][4] = {};

  HWY_INLINE Point operator*(const Point& v) const {
    const hn::CappedTag<double, 4> tag;
    HWY_ALIGN double out[4];
    for (std::size_t l = 0; l < 4; l += hn::Lanes(tag))
      hn::Store(hn::Add(hn::Add(hn::Mul(hn::Load(tag, column[0] + l), hn::Set(tag, v.x)),
                                hn::Mul(hn::Load(tag, column[1] + l), hn::Set(tag, v.y))),
                        hn::Mul(hn::Load(tag, column[2] + l), hn::Set(tag, v.z))),
                tag, out + l);
    return {out[0], out[1], out[2]};
  }
};

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
