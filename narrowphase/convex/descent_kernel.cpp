// The loop of GJK for two polytopes (Gilbert, Johnson, Keerthi 1988), compiled once for each instruction set.
#include "convex/descent_kernel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "convex/descent_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "convex/core_search-inl.h"
#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The simplex without its last point, and the point of the simplex nearest the origin. The nearest feature contains
/// the last point p: it is p, an edge at p, or a face at p. All seven are evaluated side by side, without branches.
class NearestFeature {
  using Tag = hn::CappedTag<double, 4>;
  using V = hn::Vec<Tag>;

 public:
  /// Starts with one point.
  NearestFeature(const Point& p, std::uint64_t id) : id_{id, id, id} {
    put(0, p.x, p.x, p.x);
    put(1, p.y, p.y, p.y);
    put(2, p.z, p.z, p.z);
  }
  bool knows(std::uint64_t id) const { return (id_[0] == id) | (id_[1] == id) | (id_[2] == id); }
  int count() const { return count_; }
  std::uint64_t id(int i) const { return id_[i]; }
  Point point(int i) const { return {q_[0][i], q_[1][i], q_[2][i]}; }

  enum class Step { moved, inside, lost };
  /// Adds a point; v becomes the nearest point, if that is nearer than v.
  HWY_INLINE Step add(const Point& p, std::uint64_t id, Point& v) {
    const Tag tag;
    const auto dot = [](V ax, V ay, V az, V bx, V by, V bz)
                         HWY_ATTR { return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz)); };
    const V px = hn::Set(tag, p.x), py = hn::Set(tag, p.y), pz = hn::Set(tag, p.z);
    const V zero = hn::Zero(tag), infinity = hn::Set(tag, std::numeric_limits<double>::infinity());
    const bool full = count_ == 3;
    HWY_ALIGN double near[3][8];     // points on the faces, at 3 the last point, then on the edges
    HWY_ALIGN std::uint64_t key[8];  // squared distances, with the feature's number in their last bits
    bool outside = !full;
    for (std::size_t l = 0; l < 4; l += hn::Lanes(tag)) {
      const V qx = hn::LoadU(tag, q_[0] + l), qy = hn::LoadU(tag, q_[1] + l), qz = hn::LoadU(tag, q_[2] + l);
      const V ax = hn::Sub(qx, px), ay = hn::Sub(qy, py), az = hn::Sub(qz, pz);
      const V bx = hn::Sub(hn::LoadU(tag, q_[0] + l + 1), px), by = hn::Sub(hn::LoadU(tag, q_[1] + l + 1), py),
              bz = hn::Sub(hn::LoadU(tag, q_[2] + l + 1), pz);
      const V cx = hn::Sub(hn::LoadU(tag, q_[0] + l + 2), px), cy = hn::Sub(hn::LoadU(tag, q_[1] + l + 2), py),
              cz = hn::Sub(hn::LoadU(tag, q_[2] + l + 2), pz);
      // The faces between edges a and b.
      const V nx = hn::Sub(hn::Mul(ay, bz), hn::Mul(az, by)), ny = hn::Sub(hn::Mul(az, bx), hn::Mul(ax, bz)),
              nz = hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx));
      const V aa = dot(ax, ay, az, ax, ay, az), bb = dot(bx, by, bz, bx, by, bz), cc = dot(cx, cy, cz, cx, cy, cz);
      const V n2 = dot(nx, ny, nz, nx, ny, nz), height = dot(nx, ny, nz, px, py, pz);
      const V volume = dot(nx, ny, nz, cx, cy, cz);
      auto out = hn::Le(hn::Mul(volume, volume),
                        hn::Mul(hn::Mul(hn::Set(tag, tolerance::parallel_edges2), n2), hn::Max(aa, hn::Max(bb, cc))));
      out = hn::Or(out, hn::Gt(hn::Xor(height, hn::And(hn::SignBit(tag), volume)), zero));
      if (full) {
        outside |= !hn::AllFalse(tag, out);
      } else {
        out = hn::Eq(zero, zero);
      }
      const V mx = hn::Sub(hn::Mul(ny, pz), hn::Mul(nz, py)), my = hn::Sub(hn::Mul(nz, px), hn::Mul(nx, pz)),
              mz = hn::Sub(hn::Mul(nx, py), hn::Mul(ny, px));
      const auto on_face =
          hn::And(hn::And(hn::Ge(dot(ax, ay, az, mx, my, mz), zero), hn::Le(dot(bx, by, bz, mx, my, mz), zero)),
                  hn::And(out, hn::Gt(n2, hn::Mul(hn::Set(tag, tolerance::parallel_lines2), hn::Mul(aa, bb)))));
      const V along_n = hn::Div(height, n2);
      hn::Store(hn::Mul(nx, along_n), tag, near[0] + l);
      hn::Store(hn::Mul(ny, along_n), tag, near[1] + l);
      hn::Store(hn::Mul(nz, along_n), tag, near[2] + l);
      const V face2 = hn::IfThenElse(on_face, hn::Mul(height, along_n), infinity);
      // The edges a, from the nearer end: less cancellation.
      const V t = hn::Sub(zero, dot(px, py, pz, ax, ay, az));
      const auto first_half = hn::Le(hn::Add(t, t), aa);
      const V s = hn::Div(hn::IfThenElse(first_half, t, hn::Min(hn::Sub(t, aa), zero)), aa);
      const V ex = hn::Add(hn::IfThenElse(first_half, px, qx), hn::Mul(s, ax)),
              ey = hn::Add(hn::IfThenElse(first_half, py, qy), hn::Mul(s, ay)),
              ez = hn::Add(hn::IfThenElse(first_half, pz, qz), hn::Mul(s, az));
      hn::Store(ex, tag, near[0] + 4 + l);
      hn::Store(ey, tag, near[1] + 4 + l);
      hn::Store(ez, tag, near[2] + 4 + l);
      const V edge2 = hn::IfThenElse(hn::Gt(t, zero), dot(ex, ey, ez, ex, ey, ez), infinity);
      store_keys(l, face2, edge2, key);
    }
    if (!outside) return Step::inside;
    return take_nearest(p, id, key, near, v);
  }

 private:
  /// The squared distances of three faces and three edges, each with its number in its last bits.
  static HWY_INLINE void store_keys(std::size_t l, V face2, V edge2, std::uint64_t* key) {
    const hn::RebindToUnsigned<Tag> bits;
    const auto number = hn::Iota(bits, l), rounded = hn::Set(bits, ~std::uint64_t{7});
    hn::Store(hn::Or(hn::And(hn::BitCast(bits, face2), rounded), number), bits, key + l);
    hn::Store(hn::Or(hn::Or(hn::And(hn::BitCast(bits, edge2), rounded), number), hn::Set(bits, std::uint64_t{4})), bits,
              key + 4 + l);
  }
  /// The simplex becomes the feature, of all seven, with the least squared distance, and the nearest point its point.
  HWY_INLINE Step take_nearest(const Point& p, std::uint64_t id, const std::uint64_t* key, double (*near)[8],
                               Point& v) {
    const std::uint64_t vertex = (std::bit_cast<std::uint64_t>(p.dot(p)) & ~std::uint64_t{7}) | 3;
    const std::uint64_t least = std::min(std::min(std::min(key[0], key[1]), std::min(key[2], key[4])),
                                         std::min(std::min(key[5], key[6]), vertex));
    near[0][3] = p.x, near[1][3] = p.y, near[2][3] = p.z;
    const std::size_t which = least & 7;
    const Point at{near[0][which], near[1][which], near[2][which]};
    if (!(at.dot(at) < v.dot(v))) return Step::lost;
    v = at;
    // The two earlier points that are kept for each feature, or the new one again.
    static constexpr std::uint8_t first[8] = {0, 1, 2, 3, 0, 1, 2}, second[8] = {1, 2, 0, 3, 0, 1, 2},
                                  counts[8] = {3, 3, 3, 1, 2, 2, 2};
    const std::size_t i = first[which], j = second[which];
    const std::uint64_t ids[4] = {id_[0], id_[1], id_[2], id};
    id_[0] = id, id_[1] = ids[i], id_[2] = ids[j];
    const double added[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; ++k) {
      q_[k][3] = added[k];
      put(k, added[k], q_[k][i], q_[k][j]);
    }
    count_ = counts[which];
    return Step::moved;
  }
  HWY_INLINE void put(int k, double x, double y, double z) {
    double* const q = q_[k];
    q[0] = x, q[1] = y, q[2] = z, q[3] = x, q[4] = y, q[5] = z;
  }
  double q_[3][8] = {};  ///< x, y, z of the points; if fewer than three, the last is repeated; then all once more
  std::uint64_t id_[3];
  int count_ = 1;
};

/// The difference of two cores, prepared for many support queries.
class Difference {
 public:
  explicit Difference(const MinkowskiDifference& d) : a_(d.a), b_(d.b), shift_(d.pose.translation) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        turn_.column[j][i] = d.pose.rotation(i, j);
        back_.column[i][j] = d.pose.rotation(i, j);
      }
    a_.fetch();
    b_.fetch();
    if (b_.small_hull()) b_.turn(d, turned_);
  }
  /// The point farthest against v, and the numbers of its vertices.
  HWY_INLINE std::uint64_t farthest_against(const Point& v, double length, Point& w) const {
    Point a, b;
    std::uint32_t vertex_a, vertex_b;
    if (!a_.small_hull() || !a_.farthest_vertex(-v, length, vertex_a, a)) vertex_a = a_.farthest(-v, a);
    if (!b_.small_hull() || !b_.farthest_vertex(v, length, vertex_b, b)) vertex_b = b_.farthest(back_ * v, b);
    const Point turned = turn_ * b;
    w = {a.x - (turned.x + shift_[0]), a.y - (turned.y + shift_[1]), a.z - (turned.z + shift_[2])};
    return std::uint64_t{vertex_a} << 32 | vertex_b;
  }

 private:
  Core a_, b_;
  Columns turn_, back_;
  SupportMap::Block turned_[Core::most_blocks];
  Vec3 shift_;
};

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void descend(const MinkowskiDifference& d, const DescentLimits& limits, GjkResult& r) {
  constexpr int most_steps = 96;
  const Difference difference(d);
  Point v{r.v[0], r.v[1], r.v[2]}, w;
  double upper = std::numeric_limits<double>::infinity(), length = std::sqrt(v.dot(v));
  std::uint64_t id = difference.farthest_against(v, length, w);
  double lower = v.dot(w) / length;
  if (!(lower > limits.at_once) && limits.at_once > -std::numeric_limits<double>::infinity()) {
    r.lower = lower;
    r.direction = -v.vec() / length;
    return;
  }
  NearestFeature simplex(w, id);
  bool inside = false;
  Point best = v;  // its reverse is the direction of `lower`
  double best_length = length;
  if (!(lower > limits.beyond)) {
    v = w;
    upper = length = std::sqrt(v.dot(v));
    for (int step = 0; step < most_steps && upper > limits.within && length > limits.rounding; ++step) {
      id = difference.farthest_against(v, length, w);
      const double along = v.dot(w) / length;
      if (along > lower - limits.rounding) lower = std::max(lower, along), best = v, best_length = length;
      if (lower > limits.beyond || upper - lower <= limits.tolerance * std::min(upper, limits.size) + limits.rounding ||
          simplex.knows(id))
        break;
      const auto moved = simplex.add(w, id, v);
      if (moved != NearestFeature::Step::moved) {
        inside = moved == NearestFeature::Step::inside;
        break;
      }
      length = std::sqrt(v.dot(v));
      if (simplex.count() == 2 && length < tolerance::short_difference * limits.scale) {
        // Cancellation makes a short v inexact: made perpendicular to the edge, it is exact where that matters.
        const Point e = simplex.point(0).plus(-1, simplex.point(1));
        if (const double e2 = e.dot(e); e2 > 0) v = v.plus(-(v.dot(e) / e2), e);
        length = std::sqrt(v.dot(v));
      }
      upper = length;
    }
  }
  r.v = v.vec();
  r.direction = -best.vec() / best_length;
  r.lower = lower, r.upper = inside ? 0 : upper;
  const auto point = [&](const Point& at, std::uint64_t numbers) {
    const auto a = static_cast<std::uint32_t>(numbers >> 32), b = static_cast<std::uint32_t>(numbers);
    return MinkowskiPoint{at.vec(), core_vertex(d.a, a), a, b};
  };
  Simplex& s = r.simplex;
  s.count = simplex.count();
  for (int i = 0; i < s.count; ++i) s.p[i] = point(simplex.point(s.count - 1 - i), simplex.id(s.count - 1 - i));
  if (inside) {
    r.end = GjkResult::End::inside;
    s.p[s.count++] = point(w, id);
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(descend);
DescentKernel descent_kernel() { return HWY_DYNAMIC_DISPATCH(descend); }
}  // namespace tandem
#endif
