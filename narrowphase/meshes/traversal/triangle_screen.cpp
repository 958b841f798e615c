// Screening of the triangles of a bottom node against a convex shape, in SIMD lanes.
#include "meshes/traversal/triangle_screen.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "closed_forms/surface_distance.h"
#include "tolerances.h"

#include "lanes/lanes_of_256_bits.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "meshes/traversal/triangle_screen.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

namespace {

static_assert(mesh_lanes % hn::MaxLanes(D()) == 0);

HWY_INLINE std::uint32_t bits_of(M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(D(), mask, bytes);
  return bytes[0];
}
HWY_INLINE V infinite() { return number(infinity); }
HWY_INLINE V least(V x, V y) { return hn::Min(x, y); }
HWY_INLINE V root(V x) { return hn::Sqrt(hn::Max(x, hn::Zero(D()))); }
HWY_INLINE V squared_norm(const V* x) { return dot(x, x); }
HWY_INLINE V square_across(const V* x) { return hn::Add(hn::Mul(x[0], x[0]), hn::Mul(x[1], x[1])); }
HWY_INLINE V across(const V* x, const V* y) { return hn::Add(hn::Mul(x[0], y[0]), hn::Mul(x[1], y[1])); }

// The triangles' corners and middles in the shape's frame.
struct Points {
  V at[4][3];
};

// The height of the lowest corner along m.
HWY_INLINE V lowest(const Points& p, const V* m) {
  return least(dot(m, p.at[0]), least(dot(m, p.at[1]), dot(m, p.at[2])));
}
HWY_INLINE V least_of(const Points& p, int k) { return least(p.at[0][k], least(p.at[1][k], p.at[2][k])); }
HWY_INLINE V most_of(const Points& p, int k) { return hn::Max(p.at[0][k], hn::Max(p.at[1][k], p.at[2][k])); }

// A slab of this half width across an axis: the shorter translation of a triangle out of it, and the length along d
// from a point inside to its boundary.
HWY_INLINE V out_of_slab(const Points& p, int k, double half) {
  return hn::Add(number(half), least(hn::Neg(least_of(p, k)), most_of(p, k)));
}
HWY_INLINE V exit_of_slab(V q, V d, double half) {
  const V ahead = hn::Sub(number(half), hn::Mul(hn::CopySign(number(1), d), q));
  return hn::IfThenElse(hn::Eq(d, hn::Zero(D())), infinite(), hn::Div(ahead, hn::Abs(d)));
}
// The larger root of a s^2 + 2 b s + c = 0, c <= 0; infinite if a is not positive.
HWY_INLINE V last_root(V a, V b, V c) {
  const V at = root(hn::Sub(hn::Mul(b, b), hn::Mul(a, c)));
  const V ahead = hn::Div(hn::Neg(c), hn::Add(b, at)), behind = hn::Div(hn::Sub(at, b), a);
  const V s = hn::IfThenElse(hn::Gt(b, hn::Zero(D())), ahead, behind);
  return hn::IfThenElse(hn::Gt(a, hn::Zero(D())), s, infinite());
}
HWY_INLINE V exit_of_disc(const V* q, const V* d, double radius) {
  const V c = hn::Sub(square_across(q), number(radius * radius));
  return last_root(square_across(d), across(q, d), least(c, hn::Zero(D())));
}
HWY_INLINE M tells_a_point(V rho) { return hn::Gt(rho, number(ScreeningShape::least_lean)); }
// `value`, which was divided by the length; infinite, no bound, if the length is 0.
HWY_INLINE V where_long(V length, V value) { return hn::IfThenElse(hn::Gt(length, hn::Zero(D())), value, infinite()); }

// Each kind of shape has four functions. `inside`: true if a point is certainly inside. `exit`: the length from a point
// inside to the surface along d (unit). `depth`: the length of a translation that moves a triangle out, not necessarily
// the shortest one. `reach`: the least of out . x over the points x of the shape's side along d (unit): the face whose
// normal is nearest to d, and the point farthest along d. All faces whose normals are as near to within `tie` count.

struct BoxLanes {
  const ScreeningShape& shape;
  HWY_INLINE M inside(const V* q) const {
    V most = hn::Sub(hn::Abs(q[0]), number(shape.param[0]));
    for (int i = 1; i < 3; ++i) most = hn::Max(most, hn::Sub(hn::Abs(q[i]), number(shape.param[i])));
    return hn::Lt(most, number(-shape.pad));
  }
  HWY_INLINE V exit(const V* q, const V* d) const {
    V length = infinite();
    for (int i = 0; i < 3; ++i) length = least(length, exit_of_slab(q[i], d[i], shape.param[i]));
    return length;
  }
  HWY_INLINE V depth(const Points& p) const {
    V length = infinite();
    for (int i = 0; i < 3; ++i) length = least(length, out_of_slab(p, i, shape.param[i]));
    return length;
  }
  HWY_INLINE V reach(const V* d, const V* out, V tie) const {
    const V most = hn::Max(hn::Abs(d[0]), hn::Max(hn::Abs(d[1]), hn::Abs(d[2])));
    V far = infinite();
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const V half = number(shape.param[k]), side = hn::CopySign(half, d[k]);
      const V face = hn::Sub(hn::Mul(side, out[k]), hn::Add(hn::Mul(number(shape.param[i]), hn::Abs(out[i])),
                                                            hn::Mul(number(shape.param[j]), hn::Abs(out[j]))));
      const M looks = hn::Ge(hn::Abs(d[k]), hn::Sub(most, tie));
      far = least(far, hn::IfThenElse(looks, face, infinite()));
    }
    return far;
  }
};

// Spheres and capsules: a segment along z, rounded by a radius.
struct CapsuleLanes {
  const ScreeningShape& shape;
  double radius, half;
  HWY_INLINE void from_axis(const V* q, V* out) const {
    out[0] = q[0], out[1] = q[1];
    out[2] = hn::Sub(q[2], hn::Max(number(-half), least(q[2], number(half))));
  }
  HWY_INLINE M inside(const V* q) const {
    V u[3];
    from_axis(q, u);
    const double within = radius - shape.pad;
    return within > 0 ? hn::Lt(squared_norm(u), number(within * within)) : hn::Lt(number(1), number(0));
  }
  HWY_INLINE V exit_of_ball(const V* q, const V* d, double z) const {
    const V u[3] = {q[0], q[1], hn::Sub(q[2], number(z))};
    const V along = dot(u, d);
    const V det = hn::Sub(hn::Mul(along, along), hn::Sub(squared_norm(u), number(radius * radius)));
    const V length = hn::Sub(root(det), along);
    return hn::IfThenElse(hn::Ge(det, hn::Zero(D())), length, hn::Zero(D()));
  }
  HWY_INLINE V exit(const V* q, const V* d) const {
    if (!(half > 0)) return exit_of_ball(q, d, 0);
    const V balls = hn::Max(exit_of_ball(q, d, half), exit_of_ball(q, d, -half));
    const V side = exit_of_disc(q, d, radius), z = hn::Abs(hn::Add(q[2], hn::Mul(side, d[2])));
    const M on_side = hn::And(hn::Lt(side, infinite()), hn::Le(z, number(half)));
    return hn::IfThenElse(on_side, hn::Max(balls, side), balls);
  }
  HWY_INLINE V depth(const Points& p) const {
    V length = infinite();
    for (const auto& q : p.at) {
      V m[3];
      from_axis(q, m);
      const V size = hn::Sqrt(squared_norm(m));
      const V height = hn::Sub(hn::Mul(number(half), hn::Abs(m[2])), lowest(p, m));
      length = least(length, where_long(size, hn::Add(number(radius), hn::Div(height, size))));
    }
    return length;
  }
  HWY_INLINE V reach(const V* d, const V* out, V) const {
    const V end = hn::Mul(number(radius), dot(d, out));
    if (!(half > 0)) return end;
    // If d is nearly along the axis, the whole circle of the side counts.
    const V rho = hn::Sqrt(square_across(d)), width = hn::Sqrt(square_across(out));
    const V side = hn::IfThenElse(tells_a_point(rho), hn::Div(across(d, out), rho), hn::Neg(width));
    return hn::Sub(least(end, hn::Mul(number(radius), side)), hn::Mul(number(half), hn::Abs(out[2])));
  }
};

struct CylinderLanes {
  const ScreeningShape& shape;
  HWY_INLINE M inside(const V* q) const {
    const double within = shape.param[0] - shape.pad;
    if (!(within > 0)) return hn::Lt(number(1), number(0));
    return hn::And(hn::Lt(square_across(q), number(within * within)),
                   hn::Lt(hn::Abs(q[2]), number(shape.param[1] - shape.pad)));
  }
  HWY_INLINE V exit(const V* q, const V* d) const {
    return least(exit_of_disc(q, d, shape.param[0]), exit_of_slab(q[2], d[2], shape.param[1]));
  }
  HWY_INLINE V depth(const Points& p) const {
    V length = out_of_slab(p, 2, shape.param[1]);
    for (const auto& q : p.at) {
      const V rho = hn::Sqrt(square_across(q)),
              low = least(across(q, p.at[0]), least(across(q, p.at[1]), across(q, p.at[2])));
      length = least(length, where_long(rho, hn::Sub(number(shape.param[0]), hn::Div(low, rho))));
    }
    return length;
  }
  HWY_INLINE V reach(const V* d, const V* out, V tie) const {
    const V rho = hn::Sqrt(square_across(d)), lean = hn::Sub(hn::Abs(d[2]), rho), half = number(shape.param[1]);
    const V disc = hn::Sub(hn::Mul(hn::CopySign(half, d[2]), out[2]),
                           hn::Mul(number(shape.param[0]), hn::Sqrt(square_across(out))));
    const V line =
        hn::Sub(hn::Div(hn::Mul(number(shape.param[0]), across(d, out)), rho), hn::Mul(half, hn::Abs(out[2])));
    return least(hn::IfThenElse(hn::Gt(lean, hn::Neg(tie)), disc, infinite()),
                 hn::IfThenElse(hn::Lt(lean, tie), line, infinite()));
  }
};

struct ConeLanes {
  const ScreeningShape& shape;  // its length is twice the half one
  HWY_INLINE double length() const { return 2 * shape.param[1]; }
  HWY_INLINE double slant() const { return shape.slant; }
  HWY_INLINE M inside(const V* q) const {
    const V rho = hn::Sqrt(square_across(q)), down = hn::Sub(number(shape.param[1]), q[2]);
    const V side = hn::Sub(hn::Mul(rho, number(length())), hn::Mul(number(shape.param[0]), down));
    return hn::And(hn::Lt(side, number(-shape.pad * slant())), hn::Gt(q[2], number(shape.pad - shape.param[1])));
  }
  HWY_INLINE V exit(const V* q, const V* d) const {
    const V zero = hn::Zero(D()), slope2 = number(shape.param[0] * shape.param[0] / (length() * length()));
    const V down = hn::Sub(number(shape.param[1]), q[2]), fall = hn::Neg(d[2]);
    const V a = hn::Sub(square_across(d), hn::Mul(slope2, hn::Mul(fall, fall)));
    const V b = hn::Sub(across(q, d), hn::Mul(slope2, hn::Mul(down, fall)));
    const V c = least(zero, hn::Sub(square_across(q), hn::Mul(slope2, hn::Mul(down, down))));
    const V base = hn::IfThenElse(hn::Gt(fall, zero), hn::Div(hn::Add(number(shape.param[1]), q[2]), fall), infinite());
    // A direction steeper than the side has both roots on one side: upwards it leaves at the first one.
    const V to_first = hn::Add(b, root(hn::Sub(hn::Mul(b, b), hn::Mul(a, c))));
    const V up = hn::IfThenElse(hn::Gt(to_first, zero), hn::Div(hn::Neg(c), to_first), zero);
    const V steep = hn::IfThenElse(hn::Lt(fall, zero), up, infinite());
    const V side = hn::IfThenElse(hn::Gt(a, zero), last_root(a, b, c), steep);
    return hn::Max(zero, least(base, side));
  }
  HWY_INLINE V depth(const Points& p) const {
    V least_way = hn::Add(number(shape.param[1]), most_of(p, 2));
    const double z = shape.param[0] / slant(), xy = length() / slant();
    for (const auto& q : p.at) {
      const V rho = hn::Sqrt(square_across(q)), scale = hn::Div(number(xy), rho);
      const V m[3] = {hn::Mul(q[0], scale), hn::Mul(q[1], scale), number(z)};
      least_way = least(least_way, where_long(rho, hn::Sub(number(z * shape.param[1]), lowest(p, m))));
    }
    return least_way;
  }
  HWY_INLINE V reach(const V* d, const V* out, V tie) const {
    const V rho = hn::Sqrt(square_across(d)), half = number(shape.param[1]);
    const V side = hn::Add(hn::Mul(rho, number(length() / slant())), hn::Mul(d[2], number(shape.param[0] / slant())));
    const V lean = hn::Sub(hn::Neg(d[2]), side), base = hn::Neg(hn::Mul(half, out[2]));
    const V disc = hn::Sub(base, hn::Mul(number(shape.param[0]), hn::Sqrt(square_across(out))));
    const V foot = hn::Add(base, hn::Div(hn::Mul(number(shape.param[0]), across(d, out)), rho));
    const V line = least(hn::Mul(half, out[2]), hn::IfThenElse(tells_a_point(rho), foot, disc));
    const V twice = hn::Add(tie, tie);
    return least(hn::IfThenElse(hn::Gt(lean, hn::Neg(twice)), disc, infinite()),
                 hn::IfThenElse(hn::Lt(lean, twice), line, infinite()));
  }
};

struct EllipsoidLanes {
  const ScreeningShape& shape;
  HWY_INLINE void in_radii(const V* q, V* out) const {
    for (int i = 0; i < 3; ++i) out[i] = hn::Mul(q[i], number(1 / shape.param[i]));
  }
  HWY_INLINE M inside(const V* q) const {
    const double within = 1 - shape.pad / std::min({shape.param[0], shape.param[1], shape.param[2]});
    V u[3];
    in_radii(q, u);
    return within > 0 ? hn::Lt(squared_norm(u), number(within * within)) : hn::Lt(number(1), number(0));
  }
  HWY_INLINE V exit(const V* q, const V* d) const {
    V u[3], e[3];
    in_radii(q, u), in_radii(d, e);
    return last_root(squared_norm(e), dot(u, e), least(hn::Zero(D()), hn::Sub(squared_norm(u), number(1))));
  }
  HWY_INLINE V depth(const Points& p) const {
    V length = infinite();
    for (int i = 0; i < 3; ++i) length = least(length, out_of_slab(p, i, shape.param[i]));
    for (const auto& q : p.at) {
      V u[3], m[3];
      in_radii(q, u), in_radii(u, m);
      const V size = hn::Sqrt(squared_norm(m));
      length = least(length, where_long(size, hn::Div(hn::Sub(hn::Sqrt(squared_norm(u)), lowest(p, m)), size)));
    }
    return length;
  }
  HWY_INLINE V reach(const V* d, const V* out, V) const {
    V u[3], w[3];
    for (int i = 0; i < 3; ++i)
      u[i] = hn::Mul(d[i], number(shape.param[i])), w[i] = hn::Mul(out[i], number(shape.param[i]));
    return hn::Div(dot(u, w), hn::Sqrt(squared_norm(u)));
  }
};

HWY_INLINE V along(const Vec3& p, const V* u) {
  const V at[3] = {number(p[0]), number(p[1]), number(p[2])};
  return dot(at, u);
}

struct HullLanes {
  const ScreeningShape& shape;
  std::uint32_t& outside_of;  // the face outside of which all were last time: tested first
  // For all three sides of the triangle at once, so that the faces are traversed twice only.
  HWY_INLINE void reach(const V* d, const V (&out)[3][3], V tie, V* far) const {
    const Hull& hull = *shape.hull;
    V looks = number(-infinity), farthest = number(-infinity);
    for (int i = 0; i < 3; ++i) far[i] = infinite();
    for (const Hull::Face& face : hull.faces) looks = hn::Max(looks, along(face.normal, d));
    const auto add = [&](M counts, const Vec3& p) HWY_ATTR {
      for (int i = 0; i < 3; ++i) far[i] = least(far[i], hn::IfThenElse(counts, along(p, out[i]), infinite()));
    };
    const V nearly = hn::Sub(looks, tie);
    for (const Hull::Face& face : hull.faces) {
      const M counts = hn::Ge(along(face.normal, d), nearly);
      if (hn::AllFalse(D(), counts)) continue;
      for (std::uint32_t i = 0; i < face.count; ++i) add(counts, hull.vertices[hull.loop[face.first + i]]);
    }
    for (const Vec3& p : hull.vertices) farthest = hn::Max(farthest, along(p, d));
    const V as_far = hn::Sub(farthest, hn::Mul(tie, number(shape.reach)));
    for (const Vec3& p : hull.vertices) {
      const M counts = hn::Ge(along(p, d), as_far);
      if (!hn::AllFalse(D(), counts)) add(counts, p);
    }
  }
};

template <class Body>
HWY_INLINE void reach_of_sides(const Body& body, const V* d, const V (&out)[3][3], V tie, V* far) {
  for (int i = 0; i < 3; ++i) far[i] = body.reach(d, out[i], tie);
}
HWY_INLINE void reach_of_sides(const HullLanes& body, const V* d, const V (&out)[3][3], V tie, V* far) {
  body.reach(d, out, tie, far);
}

// The triangles' normals (unit, outward by winding), and a bound on the error of cosines of angles to them. Both ends
// of a side have an error of up to `corner_off`, so the side of twice that, and the cross product of two sides of up to
// four times that times the longest.
struct Normals {
  V own[3], against[3], off;
  double corner_off;
  HWY_INLINE void find(const Points& p) {
    V u[3], v[3], w[3];
    subtract(p.at[1], p.at[0], u);
    subtract(p.at[2], p.at[0], v);
    subtract(p.at[2], p.at[1], w);
    cross(u, v, own);
    const V area = hn::Sqrt(squared_norm(own));
    const M flat = hn::Gt(area, hn::Zero(D()));
    const V per = hn::Div(number(1), hn::IfThenElse(flat, area, number(1)));
    for (int k = 0; k < 3; ++k) own[k] = hn::Mul(own[k], per), against[k] = hn::Neg(own[k]);
    const V longest = hn::Sqrt(hn::Max(squared_norm(u), hn::Max(squared_norm(v), squared_norm(w))));
    constexpr double unknown = 2;  // cosines differ by no more
    off = hn::IfThenElse(flat, hn::Mul(number(4 * corner_off), hn::Mul(longest, per)), number(unknown));
  }
};

// Computes chord and depth. Returns false, and sets nothing, if no point of any lane is inside.
template <class Body>
HWY_INLINE bool measure(const Body& body, const Points& p, bool both_ways, Normals& n, V& chord, V& depth) {
  M inside[4];
  for (int i = 0; i < 4; ++i) inside[i] = body.inside(p.at[i]);
  const M any = hn::Or(hn::Or(inside[0], inside[1]), hn::Or(inside[2], inside[3]));
  if (hn::AllFalse(D(), any)) return false;
  n.find(p);
  chord = hn::Zero(D());
  for (int i = 0; i < 4; ++i) {
    V exit = body.exit(p.at[i], n.against);
    if (both_ways) exit = least(exit, body.exit(p.at[i], n.own));
    chord = hn::Max(chord, hn::IfThenElse(inside[i], exit, hn::Zero(D())));
  }
  depth = hn::IfThenElse(any, body.depth(p), infinite());
  return true;
}

HWY_INLINE bool measure(const HullLanes& body, const Points& p, bool both_ways, Normals& n, V& chord, V& depth) {
  const V zero = hn::Zero(D()), within = number(-body.shape.pad), third = number(1.0 / 3);
  V highest[4], exit[4];
  for (int i = 0; i < 4; ++i) highest[i] = number(-infinity), exit[i] = infinite();
  depth = infinite();
  const std::vector<Hull::Face>& faces = body.shape.hull->faces;
  const Hull::Face& last = faces[body.outside_of];
  const V low = least(along(last.normal, p.at[0]), least(along(last.normal, p.at[1]), along(last.normal, p.at[2])));
  if (hn::AllFalse(D(), hn::Lt(hn::Sub(low, number(last.offset)), within))) return false;
  n.find(p);
  for (const Hull::Face& face : faces) {
    const V offset = number(face.offset), speed = along(face.normal, n.against);
    const V pace = both_ways ? hn::Abs(speed) : speed;
    const V per = hn::IfThenElse(hn::Gt(pace, zero), hn::Div(number(1), pace), infinite());
    V below[4];
    for (int i = 0; i < 3; ++i) below[i] = hn::Sub(offset, along(face.normal, p.at[i]));
    below[3] = hn::Mul(third, hn::Add(below[0], hn::Add(below[1], below[2])));
    depth = least(depth, hn::Max(below[0], hn::Max(below[1], below[2])));
    M any = hn::Lt(number(1), zero);
    for (int i = 0; i < 4; ++i) {
      highest[i] = hn::Max(highest[i], hn::Neg(below[i]));
      exit[i] = least(exit[i], hn::Mul(below[i], per));
      any = hn::Or(any, hn::Lt(highest[i], within));
    }
    if (hn::AllFalse(D(), any)) {
      body.outside_of = static_cast<std::uint32_t>(&face - faces.data());
      return false;
    }
  }
  chord = zero;
  M any = hn::Lt(number(1), zero);
  for (int i = 0; i < 4; ++i) {
    const M inside = hn::Lt(highest[i], within);
    any = hn::Or(any, inside);
    chord = hn::Max(chord, hn::IfThenElse(inside, exit[i], zero));
  }
  depth = hn::IfThenElse(any, depth, infinite());
  return true;
}

HWY_INLINE void load_points(const ScreeningShape& shape, const TriangleBlock& block, std::size_t l, Points& p) {
  const hn::Rebind<float, D> floats;
  for (int c = 0; c < 3; ++c) {
    V x[3];
    for (int k = 0; k < 3; ++k) x[k] = hn::PromoteTo(D(), hn::Load(floats, block.corner[c][k] + l));
    for (int k = 0; k < 3; ++k) {
      const double* row = shape.to_own[k];
      p.at[c][k] =
          hn::Add(sum_of_products(number(row[0]), x[0], number(row[1]), x[1], number(row[2]), x[2]), number(row[3]));
    }
  }
  for (int k = 0; k < 3; ++k)
    p.at[3][k] = hn::Mul(hn::Add(p.at[0][k], hn::Add(p.at[1][k], p.at[2][k])), number(1.0 / 3));
}

// For the prisms over the triangles along their normals: true if the shape's side against the normal (`reach`) lies
// beyond one of the prism's three sides, by more than the rounding error.
template <class Body>
HWY_INLINE M lies_beside(const Body& body, const Points& p, const V* n, V off) {
  const ScreeningShape& shape = body.shape;
  const V zero = hn::Zero(D());
  // For a surface the side of the shape's middle counts, if that is known.
  V away[3];
  for (int k = 0; k < 3; ++k) away[k] = hn::Sub(number(shape.middle[k]), p.at[0][k]);
  const V height = dot(n, away);
  const V turn = shape.solid ? number(1) : hn::CopySign(number(1), height);
  const M known = hn::Gt(shape.solid ? infinite() : hn::Abs(height), hn::Mul(off, number(shape.reach)));
  V d[3];
  for (int k = 0; k < 3; ++k) d[k] = hn::Neg(hn::Mul(turn, n[k]));
  const V beyond = hn::Add(number(shape.pad), hn::Mul(off, number(shape.reach)));
  V edge[3], out[3][3], far[3];
  for (int i = 0; i < 3; ++i) {
    subtract(p.at[(i + 1) % 3], p.at[i], edge);
    cross(edge, n, out[i]);
  }
  reach_of_sides(body, d, out, off, far);
  M beside = hn::Lt(number(1), zero);
  for (int i = 0; i < 3; ++i)
    beside =
        hn::Or(beside, hn::Gt(hn::Sub(far[i], dot(out[i], p.at[i])), hn::Mul(beyond, hn::Sqrt(squared_norm(out[i])))));
  return hn::And(known, beside);
}

template <class Body>
void screen(const Body& body, const TriangleBlock& block, std::uint32_t within, ScreenedTriangles& result) {
  const ScreeningShape& shape = body.shape;
  result.beside = result.deep = 0;
  for (std::size_t l = 0; l < mesh_lanes; l += lanes) {
    if ((within >> l & ((1u << lanes) - 1)) == 0) continue;
    Points p;
    load_points(shape, block, l, p);
    Normals n;
    n.corner_off = shape.corner_off;
    V chord, depth;
    if (!measure(body, p, !shape.solid, n, chord, depth)) continue;
    depth = hn::Add(depth, number(shape.pad));
    const std::uint32_t deep = bits_of(hn::And(hn::Gt(chord, depth), hn::Lt(n.off, number(ScreeningShape::most_off))));
    if ((deep & within >> l) == 0) continue;
    hn::Store(chord, D(), result.chord + l);
    hn::Store(depth, D(), result.depth + l);
    hn::Store(n.off, D(), result.cosine_off + l);
    result.deep |= deep << l;
    result.beside |= bits_of(lies_beside(body, p, n.own, n.off)) << l;
  }
}

}  // namespace

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void screen_triangles(const ScreeningShape* shape, const TriangleBlock* block, std::uint32_t within,
                      ScreenedTriangles* out) {
  switch (shape->kind) {
    case ShapeKind::sphere:
      return screen(CapsuleLanes{*shape, shape->param[0], 0}, *block, within, *out);
    case ShapeKind::capsule:
      return screen(CapsuleLanes{*shape, shape->param[0], shape->param[1]}, *block, within, *out);
    case ShapeKind::box:
      return screen(BoxLanes{*shape}, *block, within, *out);
    case ShapeKind::cylinder:
      return screen(CylinderLanes{*shape}, *block, within, *out);
    case ShapeKind::cone:
      return screen(ConeLanes{*shape}, *block, within, *out);
    case ShapeKind::ellipsoid:
      return screen(EllipsoidLanes{*shape}, *block, within, *out);
    case ShapeKind::convex:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::triangle:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      return screen(HullLanes{*shape, out->outside_of}, *block, within, *out);
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(screen_triangles);

TriangleScreen::TriangleScreen(const MeshModel& mesh, const ConvexView& convex, const Mat3& turn, const Vec3& shift,
                               double size)
    : mesh_(mesh) {
  shape_.kind = convex.kind;
  shape_.hull = convex.hull;
  std::copy_n(convex.param.begin(), 3, shape_.param);
  const bool is_long =
      convex.kind == ShapeKind::capsule || convex.kind == ShapeKind::cylinder || convex.kind == ShapeKind::cone;
  if (is_long) {
    const double radius = shape_.param[0], length = shape_.param[1];
    shape_.slant = std::sqrt(radius * radius + length * length);
    shape_.param[1] *= 0.5;
  }
  const bool is_round = is_long || convex.kind == ShapeKind::sphere || convex.kind == ShapeKind::box ||
                        convex.kind == ShapeKind::ellipsoid;
  const bool is_polytope =
      convex.hull != nullptr && convex.hull->dimension == 3 && convex.hull->faces.size() <= most_faces_in_turn;
  applies_ = is_round || is_polytope;
  if (!is_round) shape_.kind = ShapeKind::convex;
  if (applies_ && is_polytope) units_ += static_cast<int>(convex.hull->faces.size() / 16);
  const Vec3 at = turn.transpose() * (mesh.centre - shift);
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) shape_.to_own[k][i] = mesh.unit * turn(i, k);
    shape_.to_own[k][3] = at[k];
    shape_.middle[k] = convex.hull != nullptr ? convex.hull->inside[k] : 0;
  }
  // Each coordinate has an error of the mesh's pad, so the corner of the root of 3 times that, less than twice.
  shape_.corner_off = 2 * mesh.corner_pad() * mesh.unit;
  // Twice the allowance of the tests of single triangles (ConvexContacts::enough_for), and more than the sum of the
  // errors of a depth's first and lowest corner and of a chord's first point.
  shape_.pad = 2 * tolerance::flush * size + 4 * shape_.corner_off;
  // Points of both are no farther apart than the sum of their diameters; the error of the normal affects both a side's
  // outward direction and the direction of `reach`.
  shape_.reach = 2 * size;
  if (is_long) shape_.reach += 2 * shape_.param[0] / ScreeningShape::least_lean;
  if (convex.kind == ShapeKind::ellipsoid) {
    const auto [shortest, longest] = std::minmax({shape_.param[0], shape_.param[1], shape_.param[2]});
    shape_.reach += longest * longest / shortest;
  }
  shape_.solid = mesh.solid;
}

void TriangleScreen::look(const MeshNode& bottom, std::uint32_t within, ScreenedTriangles& out) const {
  HWY_DYNAMIC_DISPATCH(screen_triangles)(&shape_, &mesh_.blocks[bottom.block], within, &out);
}

}  // namespace tandem
#endif
