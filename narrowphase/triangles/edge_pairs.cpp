// The nearest points of the edges of two triangles (vector kernel).
#include "triangles/edge_pairs.h"

#include <cstddef>
#include <cstdint>

#include "lanes/lanes_of_256_bits.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "triangles/edge_pairs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/cpu_dispatch.h"
#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// An edge of B a lane. Sums are in the same order on every machine, never fused: the same bits.
using EdgeLanes = hn::CappedTag<double, 4>;
using EdgeLane = hn::Vec<EdgeLanes>;

HWY_INLINE EdgeLane spread(double x) { return hn::Set(EdgeLanes(), x); }
HWY_INLINE EdgeLane scalar_product(const EdgeLane* u, const EdgeLane* v) {
  return hn::Add(hn::Mul(u[0], v[0]), hn::Add(hn::Mul(u[1], v[1]), hn::Mul(u[2], v[2])));
}
/// A quotient as a parameter on an edge, clamped to it; the start for an edge without length.
HWY_INLINE EdgeLane share(EdgeLane over, EdgeLane under) {
  const EdgeLane zero = hn::Zero(EdgeLanes()), one = spread(1);
  const auto some = hn::Gt(under, zero);
  const EdgeLane at = hn::Div(over, hn::IfThenElse(some, under, one));
  const EdgeLane in = hn::IfThenElse(hn::Lt(at, zero), zero, hn::IfThenElse(hn::Gt(at, one), one, at));
  return hn::IfThenElse(some, in, zero);
}

// Ericson, Real-Time Collision Detection, 5.1.9.
// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void nearest_on_edges(const EdgeColumns& a, const EdgeColumns& b, EdgePairs& out) {
  const EdgeLanes n;
  const EdgeLane zero = hn::Zero(n), one = spread(1);
  out.parallel = 0;
  for (std::size_t j = 0; j < 4; j += hn::Lanes(n)) {
    EdgeLane q[3], e[3];
    for (std::size_t k = 0; k < 3; ++k) q[k] = hn::Load(n, b.corner[k] + j), e[k] = hn::Load(n, b.edge[k] + j);
    const EdgeLane ee = hn::Load(n, b.length2 + j);
    for (std::size_t i = 0; i < 3; ++i) {
      EdgeLane p[3], d[3], r[3];
      for (std::size_t k = 0; k < 3; ++k) {
        p[k] = spread(a.corner[k][i]), d[k] = spread(a.edge[k][i]);
        r[k] = hn::Sub(p[k], q[k]);
      }
      const EdgeLane dd = spread(a.length2[i]);
      const EdgeLane f = scalar_product(e, r), c = scalar_product(d, r), along = scalar_product(d, e);
      const EdgeLane det = hn::Sub(hn::Mul(dd, ee), hn::Mul(along, along));
      EdgeLane s = share(hn::Sub(hn::Mul(along, f), hn::Mul(c, ee)), det);
      const EdgeLane t = share(hn::Add(hn::Mul(along, s), f), ee);
      const auto inner = hn::And(hn::Gt(t, zero), hn::Lt(t, one));
      s = hn::IfThenElse(inner, s, share(hn::Sub(hn::Mul(along, t), c), dd));
      EdgeLane w[3];
      for (std::size_t k = 0; k < 3; ++k)
        w[k] = hn::Sub(hn::Add(p[k], hn::Mul(s, d[k])), hn::Add(q[k], hn::Mul(t, e[k])));
      hn::Store(s, n, out.on_a[i] + j);
      hn::Store(t, n, out.on_b[i] + j);
      hn::Store(scalar_product(w, w), n, out.squared[i] + j);
      const auto crosses = hn::Gt(det, hn::Mul(hn::Mul(spread(tolerance::slanting2), dd), ee));
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
HWY_EXPORT(nearest_on_edges);

void nearest_on_edges(const EdgeColumns& a, const EdgeColumns& b, EdgePairs& out) {
  TANDEM_DISPATCH(nearest_on_edges)(a, b, out);
}
}  // namespace tandem
#endif
