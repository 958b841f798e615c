// Separating axes and manifolds of several pairs of boxes, a pair a lane (vector kernel).
#include "boxes/box_lanes.h"

#include <algorithm>
#include <limits>

#include "boxes/box_manifold.h"
#include "manifold/manifold.h"
#include "tolerances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "boxes/box_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

#if !HWY_HAVE_SCALABLE

static_assert(BoxPairRows::most % hn::MaxLanes(D()) == 0);

/// The pairs of a vector, and the results of each stage.
struct Lanes {
  V a[12], b[12], half_a[3], half_b[3];
  V shift[3], t[3];  // from A's centre to B's, in the world and in A's frame
  V r[9], q[9];      // columns: B's axes in A's frame; their absolute values
  V size;
  V best, axis, edge_i, edge_j, edge_normal[3];
  V normal[3], world_normal[3];  // in A's frame
  V edges_cosine, facing, in_a_of_a[3], in_a_of_b[3];

  HWY_INLINE void set(const BoxPairRows& pairs, std::size_t at, M valid) {
    load(pairs.pose_a, at, valid, a);
    load(pairs.pose_b, at, valid, b);
    load(pairs.half_a, at, valid, half_a);
    load(pairs.half_b, at, valid, half_b);
    size = half_a[0];
    for (const V x : {half_a[1], half_a[2], half_b[0], half_b[1], half_b[2]}) size = hn::Add(size, x);
  }
  /// True if an edge axis, by its short formula, is no better than the best axis so far.
  HWY_INLINE M is_worse(V numerator, V length2) const {
    return hn::And(hn::Gt(length2, number(tolerance::clearly_crossing2)),
                   hn::Le(hn::Mul(numerator, hn::Abs(numerator)), hn::Mul(hn::Mul(best, hn::Abs(best)), length2)));
  }
  HWY_INLINE void find_axis(double margin);
  HWY_INLINE void measure_faces();
  HWY_INLINE void screen_edges(double margin, V* numerators, M* may_win) const;
  HWY_INLINE void measure_edges(const V* numerators, const M* may_win);
  HWY_INLINE void measure_edge(V edge, V numerator, M valid, V& least);
  HWY_INLINE void find_normal();
  HWY_INLINE M find_edges_witness();
  HWY_INLINE void choose_reference(M& of_b, V& face) const;
  HWY_INLINE M find_faces(double margin, std::size_t at, RectanglePairRows& faces, V* point, V& depth,
                          V& feature) const;
};

/// The incident face in the reference face's frame: coordinates along that face's edges and above it, as
/// `rectangle_clip` needs them.
struct FaceLanes {
  V centre[2], edge1[2], edge2[2], height, height1, height2;  // heights above the reference box's centre
  V half1, half2, rectangle[2], top, near, slant, slip[2];
  M edges;  // the normal is an edge axis

  /// True if a single corner is the whole patch; sets its position in the plane, its height, and its number.
  HWY_INLINE M find_lone_corner(double margin, V* corner, V& corner_height, V& corner_name) const;
  HWY_INLINE void store(V name, V distance, std::size_t at, RectanglePairRows& faces) const;
};

// As measure_axes and best_separation.
HWY_INLINE void Lanes::find_axis(double margin) {
  V numerators[9];
  M may_win[9];
  measure_faces();
  screen_edges(margin, numerators, may_win);
  measure_edges(numerators, may_win);
}

/// Transforms the boxes into A's frame, and finds the best of the six face normals.
HWY_INLINE void Lanes::measure_faces() {
  for (int k = 0; k < 3; ++k) shift[k] = hn::Sub(b[9 + k], a[9 + k]);
  V u[3], face_of_a[3], face_of_b[3];
  for (int i = 0; i < 3; ++i) {
    t[i] = dot(shift, a + 3 * i);
    u[i] = dot(shift, b + 3 * i);
    for (int j = 0; j < 3; ++j) {
      r[3 * j + i] = dot(a + 3 * i, b + 3 * j);
      q[3 * j + i] = hn::Abs(r[3 * j + i]);
    }
  }
  for (int k = 0; k < 3; ++k) {
    face_of_a[k] = hn::Sub(hn::Sub(hn::Abs(t[k]), half_a[k]),
                           sum_of_products(half_b[0], q[k], half_b[1], q[3 + k], half_b[2], q[6 + k]));
    face_of_b[k] = hn::Sub(hn::Sub(hn::Abs(u[k]), half_b[k]), dot(half_a, q + 3 * k));
  }
  best = face_of_a[0];
  axis = number(0);
  for (int k = 1; k < 6; ++k) {
    const V s = k < 3 ? face_of_a[k] : face_of_b[k - 3];
    const M better = hn::Gt(s, best);
    best = hn::IfThenElse(better, s, best);
    axis = hn::IfThenElse(better, number(k), axis);
  }
  edge_i = edge_j = number(-1);
  for (V& n : edge_normal) n = number(0);
}

/// Screens the nine edge axes by their short formula for those that may be better than the best face.
HWY_INLINE void Lanes::screen_edges(double margin, V* numerators, M* may_win) const {
  const V hopeless = hn::Min(best, number(0));
  const M near = hn::Le(best, number(margin));
  HWY_UNROLL(3)
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    HWY_UNROLL(3)
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const V y = r[3 * j + i1], z = r[3 * j + i2];
      const V centre = hn::Abs(hn::Sub(hn::Mul(t[i2], y), hn::Mul(t[i1], z)));
      const V from_a = hn::Add(hn::Mul(half_a[i1], q[3 * j + i2]), hn::Mul(half_a[i2], q[3 * j + i1]));
      const V from_b = hn::Add(hn::Mul(half_b[j1], q[3 * j2 + i]), hn::Mul(half_b[j2], q[3 * j1 + i]));
      const V numerator = hn::Sub(hn::Sub(centre, from_a), from_b);
      const M hopeful =
          hn::And(near, hn::Or(hn::Gt(numerator, hopeless), hn::Gt(q[3 * j + i], number(nearly_parallel))));
      const V length2 = hn::Add(hn::Mul(y, y), hn::Mul(z, z));
      may_win[3 * i + j] = hn::And(hn::AndNot(is_worse(numerator, length2), hopeful),
                                   hn::Gt(length2, number(tolerance::parallel_edges2)));
      numerators[3 * i + j] = numerator;
    }
  }
}

/// Each lane goes through its own few candidates in their order.
HWY_INLINE void Lanes::measure_edges(const V* numerators, const M* may_win) {
  V least = hn::Mul(number(tolerance::tie), size), edge = number(-1);
  for (;;) {
    V next = number(9), numerator = number(0);
    HWY_UNROLL(9)
    for (int k = 8; k >= 0; --k) {
      const M it = hn::And(may_win[k], hn::Gt(number(k), edge));
      next = hn::IfThenElse(it, number(k), next);
      numerator = hn::IfThenElse(it, numerators[k], numerator);
    }
    edge = next;
    const M some = hn::Lt(edge, number(9));
    if (hn::AllFalse(D(), some)) break;
    measure_edge(edge, numerator, some, least);
  }
}

/// The separation along the edge axis 3 i + j, of another pair of edges in each lane; becomes the best if it is better
/// by `least`.
HWY_INLINE void Lanes::measure_edge(V edge, V numerator, M valid, V& least) {
  const M second = hn::Ge(edge, number(3)), third = hn::Ge(edge, number(6));
  const V i = hn::IfThenElse(third, number(2), hn::IfThenElseZero(second, number(1)));
  const V j = hn::Sub(edge, hn::Mul(number(3), i));
  const Choice of_a(i), of_b(j);
  V own[3], others[2][3];
  of_b.own_column(r, own);
  of_b.next_column(r, others[0]);
  of_b.last_column(r, others[1]);
  const V y = of_a.next(own), z = of_a.last(own);
  const V length2 = hn::Add(hn::Mul(y, y), hn::Mul(z, z)), length = hn::Sqrt(length2);
  const V n1 = hn::Div(hn::Neg(z), length), n2 = hn::Div(y, length);
  V s = hn::Sub(hn::Abs(hn::Add(hn::Mul(n1, of_a.next(t)), hn::Mul(n2, of_a.last(t)))),
                hn::Add(hn::Mul(of_a.next(half_a), hn::Abs(n1)), hn::Mul(of_a.last(half_a), hn::Abs(n2))));
  for (const int k : {0, 1}) {
    const V reach = hn::Abs(hn::Add(hn::Mul(n1, of_a.next(others[k])), hn::Mul(n2, of_a.last(others[k]))));
    s = hn::Sub(s, hn::Mul(k == 0 ? of_b.next(half_b) : of_b.last(half_b), reach));
  }
  const M better = hn::And(hn::AndNot(is_worse(numerator, length2), valid), hn::Gt(s, hn::Add(best, least)));
  best = hn::IfThenElse(better, s, best);
  least = hn::IfThenZeroElse(better, least);
  axis = hn::IfThenElse(better, hn::Add(number(6), edge), axis);
  edge_i = hn::IfThenElse(better, i, edge_i);
  edge_j = hn::IfThenElse(better, j, edge_j);
  const V zero = number(0), n[3] = {of_a.of(zero, n2, n1), of_a.of(n1, zero, n2), of_a.of(n2, n1, zero)};
  for (int k = 0; k < 3; ++k) edge_normal[k] = hn::IfThenElse(better, n[k], edge_normal[k]);
}

// As axis_direction.
HWY_INLINE void Lanes::find_normal() {
  for (int k = 0; k < 3; ++k) normal[k] = edge_normal[k];
  for (int face = 0; face < 6; ++face) {
    const M it = hn::Eq(axis, number(face));
    for (int k = 0; k < 3; ++k)
      normal[k] = hn::IfThenElse(it, face < 3 ? number(k == face ? 1 : 0) : r[3 * (face - 3) + k], normal[k]);
  }
  const M away = hn::Lt(dot(normal, t), number(0));
  for (V& n : normal) n = hn::IfThenElse(away, hn::Neg(n), n);
  turn(a, normal, world_normal);
}

// As describe_edges and edges_witness: false where these fail, and for face axes.
HWY_INLINE M Lanes::find_edges_witness() {
  const Choice i(edge_i), j(edge_j);
  V against[3], along[3];
  facing = hn::Max(hn::Max(hn::Abs(normal[0]), hn::Abs(normal[1])), hn::Abs(normal[2]));
  for (int k = 0; k < 3; ++k) {
    const V cosine = dot(normal, r + 3 * k);
    facing = hn::Max(facing, hn::Abs(cosine));
    against[k] = hn::Neg(hn::CopySign(half_b[k], cosine));
  }
  const V b1 = j.next(against), b2 = j.last(against);
  V next_edge[3], last_edge[3], line[3];
  j.own_column(r, along);
  j.next_column(r, next_edge);
  j.last_column(r, last_edge);
  for (int k = 0; k < 3; ++k) line[k] = hn::Add(t[k], hn::Add(hn::Mul(next_edge[k], b1), hn::Mul(last_edge[k], b2)));
  const V half_i = i.own(half_a), half_j = j.own(half_b);
  const V a1 = hn::CopySign(i.next(half_a), i.next(normal)), a2 = hn::CopySign(i.last(half_a), i.last(normal));
  const V w1 = hn::Sub(i.next(line), a1), w2 = hn::Sub(i.last(line), a2), y = i.next(along), z = i.last(along);
  const V slack = hn::Mul(number(tolerance::on_feature), size);
  V on_b = hn::Div(hn::Neg(hn::Add(hn::Mul(w1, y), hn::Mul(w2, z))), hn::Add(hn::Mul(y, y), hn::Mul(z, z)));
  V on_a = hn::Add(i.own(line), hn::Mul(on_b, i.own(along)));
  M witness = hn::And(hn::Ge(axis, number(6)), hn::And(hn::Le(hn::Abs(on_a), hn::Add(half_i, slack)),
                                                       hn::Le(hn::Abs(on_b), hn::Add(half_j, slack))));
  on_a = hn::Min(hn::Max(on_a, hn::Neg(half_i)), half_i);
  on_b = hn::Min(hn::Max(on_b, hn::Neg(half_j)), half_j);
  in_a_of_a[0] = i.of(on_a, a2, a1);
  in_a_of_a[1] = i.of(a1, on_a, a2);
  in_a_of_a[2] = i.of(a2, a1, on_a);
  V off2 = number(0);
  for (int k = 0; k < 3; ++k) {
    in_a_of_b[k] = hn::Add(in_a_of_a[k], hn::Mul(best, normal[k]));
    const V off = hn::Sub(hn::Add(line[k], hn::Mul(on_b, along[k])), in_a_of_b[k]);
    off2 = hn::Add(off2, hn::Mul(off, off));
  }
  edges_cosine = hn::Abs(i.own(along));
  return hn::And(witness, hn::Le(off2, hn::Mul(slack, slack)));
}

// As choose_reference of append_box_manifold.
HWY_INLINE void Lanes::choose_reference(M& of_b, V& face) const {
  const M edges = hn::Ge(axis, number(6));
  of_b = hn::Ge(axis, number(3));
  face = hn::IfThenElse(of_b, hn::Sub(axis, number(3)), axis);
  if (!hn::AllFalse(D(), edges)) {
    V most[2] = {number(-1), number(-1)}, steepest[2] = {number(0), number(0)};
    for (const int body : {0, 1}) {
      for (int k = 0; k < 3; ++k) {
        const V steep = hn::Abs(body == 0 ? normal[k] : dot(b + 3 * k, world_normal));
        const M more = hn::Gt(steep, most[body]);
        most[body] = hn::IfThenElse(more, steep, most[body]);
        steepest[body] = hn::IfThenElse(more, number(k), steepest[body]);
      }
    }
    const M b_is_steeper = hn::Lt(hn::Add(most[0], number(tolerance::alike_cosines)), most[1]);
    of_b = hn::Or(hn::AndNot(edges, of_b), hn::And(edges, b_is_steeper));
    face = hn::IfThenElse(edges, hn::IfThenElse(b_is_steeper, steepest[1], steepest[0]), face);
  }
  for (int i = 0; i < 3; ++i) {
    const M flush = hn::Gt(hn::Abs(normal[i]), number(tolerance::flush_face));
    of_b = hn::AndNot(flush, of_b);
    face = hn::IfThenElse(flush, number(i), face);
  }
}

HWY_INLINE M FaceLanes::find_lone_corner(double margin, V* corner, V& corner_height, V& corner_name) const {
  const V one = number(1), minus = number(-1);
  const V lowest = hn::Sub(hn::Sub(height, hn::Abs(height1)), hn::Abs(height2));
  const V clearance = hn::Sub(hn::Add(top, hn::Add(number(margin), near)), lowest);
  const V rise1 = hn::Mul(number(2), hn::Abs(height1)), rise2 = hn::Mul(number(2), hn::Abs(height2));
  const M down1 = hn::Lt(height1, number(0)), down2 = hn::Lt(height2, number(0));
  const V side1 = hn::IfThenElse(down1, one, minus), side2 = hn::IfThenElse(down2, one, minus);
  M lone = hn::AndNot(
      edges, hn::And(hn::And(hn::Lt(clearance, rise1), hn::Lt(clearance, rise2)), hn::Ge(clearance, number(0))));
  for (int c = 0; c < 2; ++c) {
    corner[c] = hn::Add(centre[c], hn::Add(hn::Mul(side1, edge1[c]), hn::Mul(side2, edge2[c])));
    const V wide = hn::Sub(rectangle[c], near);
    const auto is_over = [&](V back, V e, V rise) HWY_ATTR {
      return hn::Lt(hn::Abs(hn::Add(hn::Mul(corner[c], rise), hn::Mul(clearance, hn::Mul(back, e)))),
                    hn::Mul(wide, rise));
    };
    lone = hn::And(lone, hn::Lt(hn::Abs(corner[c]), wide));
    lone = hn::And(lone, is_over(hn::Mul(number(-2), side1), edge1[c], rise1));
    lone = hn::And(lone, is_over(hn::Mul(number(-2), side2), edge2[c], rise2));
  }
  corner_height = hn::Add(height, hn::Add(hn::Mul(side1, height1), hn::Mul(side2, height2)));
  corner_name =
      hn::IfThenElse(down1, hn::IfThenElse(down2, number(0), number(3)), hn::IfThenElse(down2, number(1), number(2)));
  return lone;
}

/// Stores the faces, with the centre and the edges sheared along the normal, so that points are projected along it.
HWY_INLINE void FaceLanes::store(V name, V distance, std::size_t at, RectanglePairRows& faces) const {
  const D lane;
  const V below = hn::Sub(top, height);
  for (int c = 0; c < 2; ++c) {
    const V lean = hn::Div(slip[c], slant);  // 0 where the normal is the face's
    hn::Store(hn::Add(centre[c], hn::Mul(lean, below)), lane, faces.centre[c] + at);
    hn::Store(hn::Sub(edge1[c], hn::Mul(lean, height1)), lane, faces.edge1[c] + at);
    hn::Store(hn::Sub(edge2[c], hn::Mul(lean, height2)), lane, faces.edge2[c] + at);
  }
  hn::Store(height, lane, faces.centre[2] + at);
  hn::Store(height1, lane, faces.edge1[2] + at);
  hn::Store(height2, lane, faces.edge2[2] + at);
  hn::Store(half1, lane, faces.half1 + at);
  hn::Store(half2, lane, faces.half2 + at);
  hn::Store(rectangle[0], lane, faces.half_u + at);
  hn::Store(rectangle[1], lane, faces.half_w + at);
  hn::Store(top, lane, faces.top + at);
  hn::Store(distance, lane, faces.distance + at);
  hn::Store(near, lane, faces.near + at);
  hn::Store(slant, lane, faces.slant + at);
  hn::Store(slip[0], lane, faces.slip_u + at);
  hn::Store(slip[1], lane, faces.slip_w + at);
  hn::Store(name, lane, faces.name + at);
}

/// The rotation columns of the reference box, and of the other box, by the choice of each lane.
struct ReferenceLanes {
  V pose[12], other[9], d[3], away[3], reference[3], incident[3];

  HWY_INLINE ReferenceLanes(const Lanes& x, M of_b) {
    for (int k = 0; k < 12; ++k) pose[k] = hn::IfThenElse(of_b, x.b[k], x.a[k]);
    for (int k = 0; k < 9; ++k) other[k] = hn::IfThenElse(of_b, x.a[k], x.b[k]);
    for (int k = 0; k < 3; ++k) {
      d[k] = hn::IfThenElse(of_b, hn::Neg(x.shift[k]), x.shift[k]);
      away[k] = hn::IfThenElse(of_b, hn::Neg(x.world_normal[k]), x.world_normal[k]);
      reference[k] = hn::IfThenElse(of_b, x.half_b[k], x.half_a[k]);
      incident[k] = hn::IfThenElse(of_b, x.half_a[k], x.half_b[k]);
    }
  }
  /// The incident face, whose normal is most opposed to the reference face's; of two alike, the first. `turned`: its
  /// lower side.
  HWY_INLINE V find_incident(const V* outward, M& turned) const {
    V cosine[3], face = number(0);
    for (int k = 0; k < 3; ++k) cosine[k] = dot(outward, other + 3 * k);
    V most = hn::Abs(cosine[0]);
    for (int k = 1; k < 3; ++k) {
      const V steepness = hn::Abs(cosine[k]);
      const M more = hn::Gt(steepness, hn::Add(most, number(tolerance::alike)));
      most = hn::IfThenElse(more, steepness, most);
      face = hn::IfThenElse(more, number(k), face);
    }
    turned = hn::Gt(Choice(face).own(cosine), number(0));
    return face;
  }
};

// As FaceClip of append_box_manifold: the two faces, and whether a single corner is the whole patch.
HWY_INLINE M Lanes::find_faces(double margin, std::size_t at, RectanglePairRows& faces, V* point, V& depth,
                               V& feature) const {
  M of_b;
  V face;
  choose_reference(of_b, face);
  const ReferenceLanes x(*this, of_b);
  const Choice reference_axis(face);
  V outward[3], along_u[3], along_w[3];
  reference_axis.own_column(x.pose, outward);
  reference_axis.next_column(x.pose, along_u);
  reference_axis.last_column(x.pose, along_w);
  const V one = number(1), minus = number(-1);
  const V along_face = dot(outward, x.away);
  const M is_front = hn::Ge(along_face, number(0));
  FaceLanes f;
  f.edges = hn::Ge(axis, number(6));
  f.slant = hn::IfThenElse(f.edges, hn::Abs(along_face), one);
  f.slip[0] = hn::IfThenElseZero(f.edges, dot(along_u, x.away));
  f.slip[1] = hn::IfThenElseZero(f.edges, dot(along_w, x.away));
  const V side = hn::IfThenElse(is_front, one, minus);
  for (V& v : outward) v = hn::Mul(side, v);

  V all = x.reference[0];
  for (const V v : {x.reference[1], x.reference[2], x.incident[0], x.incident[1], x.incident[2]}) all = hn::Add(all, v);
  M turned;
  const V incident_face = x.find_incident(outward, turned);
  const Choice k(incident_face);
  const V towards = hn::IfThenElse(turned, minus, one);
  V own[3], next[3], last[3];
  k.own_column(x.other, own);
  k.next_column(x.other, next);
  k.last_column(x.other, last);
  const V ahead = hn::Mul(towards, k.own(x.incident));
  f.half1 = k.next(x.incident), f.half2 = k.last(x.incident);
  for (int c = 0; c < 3; ++c) {
    own[c] = hn::Add(x.d[c], hn::Mul(ahead, own[c]));
    next[c] = hn::Mul(f.half1, next[c]);
    last[c] = hn::Mul(f.half2, last[c]);
  }
  f.height = dot(outward, own), f.height1 = dot(outward, next), f.height2 = dot(outward, last);
  f.edge1[0] = dot(along_u, next), f.edge1[1] = dot(along_w, next);
  f.edge2[0] = dot(along_u, last), f.edge2[1] = dot(along_w, last);
  f.centre[0] = dot(along_u, own), f.centre[1] = dot(along_w, own);
  f.rectangle[0] = reference_axis.next(x.reference), f.rectangle[1] = reference_axis.last(x.reference);
  f.top = reference_axis.own(x.reference), f.near = hn::Mul(number(tolerance::alike), all);

  V corner[2], corner_height, corner_name;
  const M lone = f.find_lone_corner(margin, corner, corner_height, corner_name);
  depth = hn::Max(hn::Min(hn::Sub(f.top, corner_height), hn::Neg(best)), number(-margin));
  const V above = hn::Mul(side, hn::Sub(f.top, hn::Mul(number(0.5), depth)));
  const V in_frame[3] = {reference_axis.of(above, corner[1], corner[0]), reference_axis.of(corner[0], above, corner[1]),
                         reference_axis.of(corner[1], corner[0], above)};
  place(x.pose, in_frame, point);
  const V reference_name = hn::Add(hn::Mul(number(2), face), hn::IfThenElse(is_front, number(0), one));
  const V incident_name = hn::Add(hn::Mul(number(2), incident_face), hn::IfThenElse(turned, one, number(0)));
  const V name = hn::Add(hn::Add(hn::Mul(number(1 << 12), reference_name), hn::Mul(number(1 << 8), incident_name)),
                         hn::IfThenElse(of_b, number(1u << 31), number(0)));
  feature = hn::Add(name, corner_name);
  f.store(name, best, at, faces);
  return lone;
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void overlap_boxes(const BoxPairRows& pairs, std::size_t count, double margin, BoxFindingRows& found) {
  const D d;
  for (std::size_t at = 0; at < count; at += hn::Lanes(d)) {
    Lanes x;
    const M valid = hn::FirstN(d, count - at);
    x.set(pairs, at, valid);
    x.find_axis(margin);
    x.find_normal();
    const M apart = hn::Gt(x.best, hn::Set(d, margin)), overlap = hn::Le(x.best, hn::Zero(d));
    const M witness = x.find_edges_witness();
    V point[3], depth, feature;
    const M carried = hn::Or(hn::Lt(x.axis, number(6)), hn::And(witness, hn::Ge(x.facing, number(carries_patch))));
    const M corner = hn::And(carried, x.find_faces(margin, at, found.faces, point, depth, feature));
    V on_a[3], on_b[3];
    place(x.a, x.in_a_of_a, on_a);
    place(x.a, x.in_a_of_b, on_b);
    const M crossing = hn::And(witness, hn::And(hn::Lt(x.facing, hn::Set(d, carries_patch)),
                                                hn::Le(x.edges_cosine, hn::Set(d, clearly_crossing))));
    const M of_edges = hn::AndNot(corner, witness);
    const V half = hn::Mul(number(0.5), x.best), sense = hn::MaskedLoad(valid, d, pairs.sense + at);
    const M back = hn::Lt(sense, hn::Zero(d));
    V first[3], second[3], normal[3];
    for (int k = 0; k < 3; ++k) {
      point[k] = hn::IfThenElse(crossing, hn::Mul(number(0.5), hn::Add(on_a[k], on_b[k])), point[k]);
      const V half_depth = hn::Mul(half, x.world_normal[k]);
      on_a[k] = hn::IfThenElse(of_edges, on_a[k], hn::Sub(point[k], half_depth));
      on_b[k] = hn::IfThenElse(of_edges, on_b[k], hn::Add(point[k], half_depth));
      first[k] = hn::IfThenElse(back, on_b[k], on_a[k]);
      second[k] = hn::IfThenElse(back, on_a[k], on_b[k]);
      normal[k] = hn::Mul(sense, x.world_normal[k]);
    }
    hn::Store(x.best, d, found.distance + at);
    hn::Store(x.axis, d, found.axis + at);
    hn::Store(x.edges_cosine, d, found.edges_cosine + at);
    hn::Store(x.facing, d, found.facing + at);
    store(x.normal, at, found.normal_in_a);
    store(x.in_a_of_a, at, found.in_a_of_a);
    store(x.in_a_of_b, at, found.in_a_of_b);
    store_in_turn(x.best, first[0], first[1], first[2], at, found.answers.first);
    store_in_turn(second[0], second[1], second[2], normal[0], at, found.answers.second);
    store_in_turn(point[0], point[1], point[2], normal[0], at, found.contacts.first);
    store_in_turn(normal[1], normal[2], hn::IfThenElse(crossing, hn::Neg(x.best), depth),
                  whole_bits(hn::IfThenZeroElse(crossing, feature)), at, found.contacts.second);
    // The last condition that holds.
    const hn::RebindToSigned<D> whole;
    auto finding = hn::Set(whole, BoxFinding::unknown);
    const auto finds = [&](M it, std::int64_t what) HWY_ATTR {
      finding = hn::IfThenElse(hn::RebindMask(whole, it), hn::Set(whole, what), finding);
    };
    finds(hn::And(overlap, witness), BoxFinding::axis);
    finds(hn::And(overlap, carried), BoxFinding::faces);
    finds(hn::And(overlap, hn::Or(crossing, corner)), BoxFinding::point);
    finds(apart, BoxFinding::apart);
    hn::Store(finding, whole, found.finding + at);
  }
}

#else

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void overlap_boxes(const BoxPairRows&, std::size_t count, double, BoxFindingRows& found) {
  std::fill_n(found.finding, count, BoxFinding::unknown);
}

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(overlap_boxes);

BoxAnswer BoxFindingRows::answer(std::size_t column) const {
  const auto vector = [column](const double(&rows)[3][most]) {
    return Vec3(rows[0][column], rows[1][column], rows[2][column]);
  };
  BoxAnswer out;
  out.local.signed_distance = distance[column];
  out.local.normal = vector(normal_in_a);
  out.axis = static_cast<int>(axis[column]);
  if (out.axis < 6) return out;
  out.local.point_a = vector(in_a_of_a);
  out.local.point_b = vector(in_a_of_b);
  out.edges_cosine = edges_cosine[column];
  out.facing = facing[column];
  return out;
}

void overlap_boxes(const BoxPairRows& pairs, std::size_t count, double margin, BoxFindingRows& found) {
  HWY_DYNAMIC_DISPATCH(overlap_boxes)(pairs, count, margin, found);
}
}  // namespace tandem
#endif
