// Separations along the edge axes of triangles and boxes, and nearest points of their edges (vector kernels).
#include "triangles/triangle_kernel.h"

#include <cstddef>
#include <cstdint>
#include <limits>

#include "lanes/lanes_of_256_bits.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "triangles/triangle_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/cpu_dispatch.h"
#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// An edge of B a lane. Sums are in the same order on every machine, never fused: the same bits.
using Columns = hn::CappedTag<double, 4>;
using W = hn::Vec<Columns>;

HWY_INLINE W number_of(double x) { return hn::Set(Columns(), x); }
HWY_INLINE W product_sum(W p0, W q0, W p1, W q1, W p2, W q2) {
  return hn::Add(hn::Add(hn::Mul(p0, q0), hn::Mul(p1, q1)), hn::Mul(p2, q2));
}
/// The sum in another order, the last two products first.
HWY_INLINE W product_sum(const W* u, const W* v) { return product_sum(u[1], v[1], u[2], v[2], u[0], v[0]); }
HWY_INLINE W clamped(W x, W lo, W hi) { return hn::Min(hn::Max(x, lo), hi); }

struct Three {
  W x[3];
  HWY_INLINE Three(const double (&rows)[3][4], std::size_t j) {
    for (std::size_t k = 0; k < 3; ++k) x[k] = hn::Load(Columns(), rows[k] + j);
  }
};

/// One row: the squared lengths of the cross products, and the separations along them times their length, of B beyond A
/// or A beyond B. Returns the bits of the doubtful ones.
HWY_INLINE unsigned put_separations(W squared, W by_parallel, W there, W back, std::size_t j, double* row) {
  const Columns d;
  const auto clear = hn::Gt(squared, hn::Mul(number_of(tolerance::clearly_crossing_edges2), by_parallel));
  const W separation = hn::Div(hn::Max(there, back), hn::Sqrt(squared));
  hn::Store(hn::IfThenElse(clear, separation, number_of(-std::numeric_limits<double>::infinity())), d, row + j);
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, hn::Not(clear), bits);
  return static_cast<unsigned>(bits[0]) << j;
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void triangle_products(const TriangleColumns& a, const TriangleColumns& b, EdgeProducts& out) {
  const Columns d;
  const W zero = hn::Zero(d);
  out.doubtful = 0;
  for (std::size_t j = 0; j < 4; j += hn::Lanes(d)) {
    const Three f(b.edge, j), q(b.corner, j);
    const W f2 = hn::Load(d, b.length2 + j);
    // Along a cross product, A's third corner differs from its edge by minus the product of its area vector with B's
    // edge.
    const W beside_a =
        hn::Neg(product_sum(f.x[0], number_of(a.area[0]), f.x[1], number_of(a.area[1]), f.x[2], number_of(a.area[2])));
    const W low_a = hn::Min(beside_a, zero), high_a = hn::Max(beside_a, zero);
    for (std::size_t i = 0; i < 3; ++i) {
      const W e[3] = {number_of(a.edge[0][i]), number_of(a.edge[1][i]), number_of(a.edge[2][i])};
      W n[3], w[3];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
        n[k] = hn::Sub(hn::Mul(e[u], f.x[v]), hn::Mul(e[v], f.x[u]));
        w[k] = hn::Sub(q.x[k], number_of(a.corner[k][i]));
      }
      const W between = product_sum(n[0], w[0], n[1], w[1], n[2], w[2]);
      const W beside_b =
          product_sum(e[0], number_of(b.area[0]), e[1], number_of(b.area[1]), e[2], number_of(b.area[2]));
      const W there = hn::Sub(hn::Add(between, hn::Min(beside_b, zero)), high_a);
      const W back = hn::Sub(low_a, hn::Add(between, hn::Max(beside_b, zero)));
      out.doubtful |= put_separations(product_sum(n[0], n[0], n[1], n[1], n[2], n[2]),
                                      hn::Mul(number_of(a.length2[i]), f2), there, back, j, out.separation[i])
                      << (4 * i);
    }
  }
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void box_triangle_products(const double (&half)[3], const TriangleColumns& b, EdgeProducts& out) {
  const Columns d;
  const W zero = hn::Zero(d);
  out.doubtful = 0;
  for (std::size_t j = 0; j < 4; j += hn::Lanes(d)) {
    const Three f(b.edge, j), q(b.corner, j);
    const W f2 = hn::Load(d, b.length2 + j);
    for (std::size_t i = 0; i < 3; ++i) {
      // e_i x f: minus f's last coordinate along the next axis, its next along the last.
      const std::size_t u = (i + 1) % 3, v = (i + 2) % 3;
      const W reach =
          hn::Add(hn::Mul(number_of(half[u]), hn::Abs(f.x[v])), hn::Mul(number_of(half[v]), hn::Abs(f.x[u])));
      const W at = hn::Sub(hn::Mul(f.x[u], q.x[v]), hn::Mul(f.x[v], q.x[u])), beside = number_of(b.area[i]);
      const W there = hn::Sub(hn::Add(at, hn::Min(beside, zero)), reach);
      const W back = hn::Sub(hn::Neg(hn::Add(at, hn::Max(beside, zero))), reach);
      out.doubtful |= put_separations(hn::Add(hn::Mul(f.x[u], f.x[u]), hn::Mul(f.x[v], f.x[v])), f2, there, back, j,
                                      out.separation[i])
                      << (4 * i);
    }
  }
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void corner_offsets(const TriangleColumns& a, const TriangleColumns& b, CornerOffsets& out) {
  const Columns d;
  const W zero = hn::Zero(d), one = number_of(1);
  for (std::size_t j = 0; j < 4; j += hn::Lanes(d)) {
    const Three f(b.edge, j), q(b.corner, j);
    const W by_f2 = hn::Div(one, hn::Load(d, b.length2 + j));
    for (std::size_t i = 0; i < 3; ++i) {
      W w[3];
      for (std::size_t k = 0; k < 3; ++k) w[k] = hn::Sub(number_of(a.corner[k][i]), q.x[k]);
      const auto squared_past = [&](const W* from, const W* edge, W by_length2) HWY_ATTR {
        const W t =
            clamped(hn::Mul(product_sum(from[0], edge[0], from[1], edge[1], from[2], edge[2]), by_length2), zero, one);
        W x[3];
        for (std::size_t k = 0; k < 3; ++k) x[k] = hn::Sub(from[k], hn::Mul(t, edge[k]));
        return product_sum(x[0], x[0], x[1], x[1], x[2], x[2]);
      };
      hn::Store(squared_past(w, f.x, by_f2), d, out.from_a[i] + j);
      const W e[3] = {number_of(a.edge[0][i]), number_of(a.edge[1][i]), number_of(a.edge[2][i])};
      const W back[3] = {hn::Neg(w[0]), hn::Neg(w[1]), hn::Neg(w[2])};
      hn::Store(squared_past(back, e, number_of(1 / a.length2[i])), d, out.from_b[i] + j);
    }
  }
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void edge_offsets(const double (&half)[3], const TriangleColumns& b, EdgeOffsets& out) {
  const Columns d;
  const W zero = hn::Zero(d), one = number_of(1);
  for (std::size_t j = 0; j < 4; j += hn::Lanes(d)) {
    const Three f(b.edge, j), q(b.corner, j);
    // The squared distance is convex in t; its slope is increasing, and linear between the parameters where the edge
    // passes a plane of the box: the minimum lies between the last of these with a negative slope and the first with a
    // positive one.
    W lo = zero, hi = one, slope_lo, slope_hi;
    const auto over = [&](W t, std::size_t k) HWY_ATTR {
      const W p = hn::Add(q.x[k], hn::Mul(t, f.x[k])), h = number_of(half[k]);
      return hn::Sub(p, clamped(p, hn::Neg(h), h));
    };
    const auto slope = [&](W t)
                           HWY_ATTR { return product_sum(f.x[0], over(t, 0), f.x[1], over(t, 1), f.x[2], over(t, 2)); };
    slope_lo = slope(lo);
    slope_hi = slope(hi);
    for (std::size_t k = 0; k < 3; ++k)
      for (const double side : {half[k], -half[k]}) {
        const W to = hn::Sub(number_of(side), q.x[k]);
        // An edge parallel to the plane never passes it.
        const W t =
            hn::IfThenElse(hn::Eq(f.x[k], zero), zero, hn::Div(to, hn::IfThenElse(hn::Eq(f.x[k], zero), one, f.x[k])));
        const W s = slope(t);
        const auto inner = hn::And(hn::Gt(t, lo), hn::Lt(t, hi)), falls = hn::Lt(s, zero);
        const auto later = hn::And(inner, falls), sooner = hn::AndNot(falls, inner);
        lo = hn::IfThenElse(later, t, lo);
        slope_lo = hn::IfThenElse(later, s, slope_lo);
        hi = hn::IfThenElse(sooner, t, hi);
        slope_hi = hn::IfThenElse(sooner, s, slope_hi);
      }
    const W rise = hn::Sub(slope_hi, slope_lo);
    const W share = clamped(hn::Div(hn::Neg(slope_lo), hn::IfThenElse(hn::Gt(rise, zero), rise, one)), zero, one);
    W t = hn::Add(lo, hn::Mul(share, hn::Sub(hi, lo)));
    t = hn::IfThenElse(hn::Ge(slope_lo, zero), lo, hn::IfThenElse(hn::Le(slope_hi, zero), hi, t));
    const W x = over(t, 0), y = over(t, 1), z = over(t, 2);
    hn::Store(product_sum(x, x, y, y, z, z), d, out.squared + j);
    hn::Store(t, d, out.at + j);
  }
}

/// A quotient as a parameter on an edge, clamped to it; the start for an edge without length.
HWY_INLINE W share(W over, W under) {
  const W zero = hn::Zero(Columns()), one = number_of(1);
  const auto some = hn::Gt(under, zero);
  const W at = hn::Div(over, hn::IfThenElse(some, under, one));
  const W in = hn::IfThenElse(hn::Lt(at, zero), zero, hn::IfThenElse(hn::Gt(at, one), one, at));
  return hn::IfThenElse(some, in, zero);
}

// Ericson, Real-Time Collision Detection, 5.1.9.
// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void nearest_on_edges(const EdgeColumns& a, const EdgeColumns& b, EdgePairs& out) {
  const Columns n;
  const W zero = hn::Zero(n), one = number_of(1);
  out.parallel = 0;
  for (std::size_t j = 0; j < 4; j += hn::Lanes(n)) {
    W q[3], e[3];
    for (std::size_t k = 0; k < 3; ++k) q[k] = hn::Load(n, b.corner[k] + j), e[k] = hn::Load(n, b.edge[k] + j);
    const W ee = hn::Load(n, b.length2 + j);
    for (std::size_t i = 0; i < 3; ++i) {
      W p[3], d[3], r[3];
      for (std::size_t k = 0; k < 3; ++k) {
        p[k] = number_of(a.corner[k][i]), d[k] = number_of(a.edge[k][i]);
        r[k] = hn::Sub(p[k], q[k]);
      }
      const W dd = number_of(a.length2[i]);
      const W f = product_sum(e, r), c = product_sum(d, r), along = product_sum(d, e);
      const W det = hn::Sub(hn::Mul(dd, ee), hn::Mul(along, along));
      W s = share(hn::Sub(hn::Mul(along, f), hn::Mul(c, ee)), det);
      const W t = share(hn::Add(hn::Mul(along, s), f), ee);
      const auto inner = hn::And(hn::Gt(t, zero), hn::Lt(t, one));
      s = hn::IfThenElse(inner, s, share(hn::Sub(hn::Mul(along, t), c), dd));
      W w[3];
      for (std::size_t k = 0; k < 3; ++k)
        w[k] = hn::Sub(hn::Add(p[k], hn::Mul(s, d[k])), hn::Add(q[k], hn::Mul(t, e[k])));
      hn::Store(s, n, out.on_a[i] + j);
      hn::Store(t, n, out.on_b[i] + j);
      hn::Store(product_sum(w, w), n, out.squared[i] + j);
      const auto crosses = hn::Gt(det, hn::Mul(hn::Mul(number_of(tolerance::slanting2), dd), ee));
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(n, hn::Not(crosses), bits);
      out.parallel |= static_cast<unsigned>(bits[0]) << (4 * i + j);
    }
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(triangle_products);
HWY_EXPORT(box_triangle_products);
HWY_EXPORT(corner_offsets);
HWY_EXPORT(edge_offsets);
HWY_EXPORT(nearest_on_edges);

void triangle_products(const TriangleColumns& a, const TriangleColumns& b, EdgeProducts& out) {
  TANDEM_DISPATCH(triangle_products)(a, b, out);
}
void box_triangle_products(const double (&half)[3], const TriangleColumns& b, EdgeProducts& out) {
  TANDEM_DISPATCH(box_triangle_products)(half, b, out);
}
void corner_offsets(const TriangleColumns& a, const TriangleColumns& b, CornerOffsets& out) {
  TANDEM_DISPATCH(corner_offsets)(a, b, out);
}
void edge_offsets(const double (&half)[3], const TriangleColumns& b, EdgeOffsets& out) {
  TANDEM_DISPATCH(edge_offsets)(half, b, out);
}
void nearest_on_edges(const EdgeColumns& a, const EdgeColumns& b, EdgePairs& out) {
  TANDEM_DISPATCH(nearest_on_edges)(a, b, out);
}
}  // namespace tandem
#endif
