// Contacts of a mesh and a bounded convex shape, triangle by triangle.
#include "meshes/contacts/convex_contacts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "closed_forms/closed_forms.h"
#include "closed_forms/surface_distance.h"
#include "manifold/feature_overlap.h"
#include "manifold/flat_feature.h"
#include "manifold/manifold.h"
#include "meshes/contacts/normal_cone.h"
#include "shapes/lent_memory.h"
#include "shapes/mesh_model.h"
#include "shapes/work_meter.h"

namespace tandem {
namespace {

constexpr int a_solve = 32;  // units of work to solve a triangle with a convex shape, at most

// True if a point in the triangle's plane is beyond one of its sides by more than `most`. `n`: its normal, to either
// side.
bool is_beyond_side(const Corners& p, const Vec3& n, const Vec3& point, double most) {
  const double turn = n.dot(area_vector(p)) > 0 ? 1 : -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = p[(i + 1) % 3] - p[i];
    const double beside = turn * edge.cross(n).dot(point - p[i]);
    if (beside > 0 && beside * beside > most * most * edge.squaredNorm()) return true;
  }
  return false;
}

}  // namespace

// Is the translation off the triangle's plane to the side of the convex shape's centre, along n (unit), provably the
// shortest? The point that is deepest, w below the plane, lies over the triangle at least rho from its edges. So a disc
// of it holds the shape back along any direction at an angle x to n by w cos x + rho sin x, which is less than w only
// beyond pi - 2 atan(w / rho). There the centre, h above the plane and l away from the deepest point along it, holds it
// back by -h cos x - l sin x. Apart, the deepest point need only lie over the triangle.
bool ConvexContacts::depth_is_along(const Vec3& n, const Corners& p, const Vec3& deepest, double w) const {
  double rho2 = infinity;
  const double turn = n.dot(area_vector(p)) > 0 ? 1 : -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = p[(i + 1) % 3] - p[i];
    const double beside = turn * n.cross(edge).dot(deepest - p[i]), length2 = edge.squaredNorm();
    if (!(beside > 0)) return false;
    if (w > 0 && !(beside * beside > 16 * w * w * length2)) return false;
    rho2 = std::min(rho2, beside * beside / length2);
  }
  if (!(w > 0)) return true;
  const Vec3 up = pair_.centre() - deepest;
  const double k2 = w * w / rho2, h = up.dot(n) - w, l2 = (up - up.dot(n) * n).squaredNorm();
  const double spare = h * (1 - k2) - w * (1 + k2);
  return spare > 0 && spare * spare > 4 * k2 * l2;
}

// Do all of the points lie on an edge or a corner of the triangle beyond which its neighbours reach farther along n?
bool ConvexContacts::neighbours_reach_farther(std::uint32_t t, const Corners& p, const Vec3& n,
                                              std::span<const Contact> points) const {
  const double slack = tolerance::alike * pair_.size();
  const MeshModel& model = pair_.model();
  const auto all = [&](auto&& are_there) {
    return std::all_of(points.begin(), points.end(), [&](const Contact& c) { return are_there(c.point); });
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &from = p[k], &to = p[(k + 1) % 3];
    if (all([&](const Vec3& q) { return (q - from).norm() <= slack; })) return has_higher_neighbour(model, t, k, n);
    const std::uint32_t next = model.neighbours()[t][k];
    if (next == no_index) continue;
    const Corners other = pair_.corners(next);
    const double highest = std::max({n.dot(other[0]), n.dot(other[1]), n.dot(other[2])});
    if (highest - std::max(n.dot(from), n.dot(to)) <= slack) continue;
    const Vec3 along = (to - from).stableNormalized();
    if (all([&](const Vec3& q) { return (q - from).cross(along).norm() <= slack; })) return true;
  }
  return false;
}

// Is an answer's normal a direction along which the surface pushes at the triangle? What only touches is pushed by the
// neighbours where it lies behind the triangle, or where they go on along the normal.
bool ConvexContacts::pushes(std::uint32_t t, const Corners& p, const TrianglePlane& plane, const PairAnswer& answer,
                            std::span<const Contact> points) const {
  const MeshModel& model = pair_.model();
  const double slack = tolerance::alike * pair_.size();
  if (model.solid && plane.flat && !(answer.normal.dot(plane.normal) > -tolerance::flush)) return false;
  if (answer.signed_distance >= -slack && neighbours_reach_farther(t, p, answer.normal, points)) return false;
  return in_normal_cone(model, t, answer.normal, pair_.in_mesh(answer.point_a), slack);
}

// How far it is from a point inside the convex shape to its surface against n (unit); of a mesh that is no solid, which
// may push to either side, the shorter translation of both.
double ConvexContacts::exit_length(const Vec3& q, const Vec3& n) const {
  const double down = pair_.exit_length(q, -n);
  return pair_.model().solid ? down : std::min(down, pair_.exit_length(q, n));
}

// Is the depth along all directions of a cone, spanned by normals times a sign, more than `enough`? That of a corner
// and the vertices around it, which reach no farther along these, is a convex function h of n, the support of all of
// them - convex shape; a point g of that, from a support along some direction, has h(n) >= g . n, which over the cone
// is least along one of the normals. From the one nearest to where the depth is small, `towards` (unit), on to the
// normal that speaks against the last g (Frank and Wolfe, 1956).
bool ConvexContacts::needs_more(const Vec3& corner, std::span<const std::uint32_t> around,
                                std::span<const Vec3> normals, double sign, const Vec3& towards, double enough) const {
  constexpr int steps = 4;
  const auto along = [&](const Vec3& d) {
    return [&](const Vec3& x, const Vec3& y) { return sign * d.dot(x) < sign * d.dot(y); };
  };
  Vec3 n = sign * *std::max_element(normals.begin(), normals.end(), along(towards));
  for (int i = 0; i < steps; ++i) {
    const Vec3 d = unit(n), low = pair_.support(-d);
    Vec3 g = corner - low;
    for (const std::uint32_t v : around)
      if (const Vec3 other = pair_.vertex(v) - low; d.dot(other) > d.dot(g)) g = other;
    if (!(d.dot(g) > enough)) return false;
    const Vec3 against = sign * *std::min_element(normals.begin(), normals.end(), along(g));
    if (against.dot(g) > enough) return true;
    const Vec3 turn = against - n;
    const double length2 = turn.squaredNorm();
    if (!(length2 > 0)) return false;
    const double step = std::clamp((towards - n).dot(turn) / length2, 0.0, 1.0);
    if (!(step > tolerance::least_turn)) return false;
    n += step * turn;
  }
  return false;
}

// Where the translation out of a corner is that of the triangle: the depth, as a solver would find it, well beyond
// rounding. `bound` is that by a point of the triangle, and then the best by its corners, too.
bool ConvexContacts::depth_by_corner(const Corners& p, TriangleBound& bound, CornerBounds& corners,
                                     PairAnswer& r) const {
  for (std::size_t k = 0; k < 3; ++k) {
    TriangleBound& own = corners[k] = pair_.bound(p, p[k]);
    if (!own.overlaps) continue;
    if (own.is_depth) {
      r.collide = true;
      r.signed_distance = own.gap;
      r.normal = own.normal;
      r.point_a = p[k];
      r.point_b = p[k] + own.gap * own.normal;
      return true;
    }
    if (own.gap > bound.gap || !bound.overlaps) bound = own;
  }
  return false;
}

// The translation along n (unit) that takes all of a triangle out, where it is not longer than a point of the triangle
// is deep: then no other is shorter.
bool ConvexContacts::is_depth_along(const Corners& p, const Vec3& n, const TriangleBound& point, PairAnswer& r) const {
  const double depth = -pair_.support_plane(n).beyond(p);
  if (!point.overlaps || !(depth <= point.depth + pair_.slack())) return false;
  r.collide = true;
  r.signed_distance = -depth;
  r.normal = n;
  r.point_a = point.point;
  r.point_b = point.point - depth * n;
  return true;
}

// Of a smooth shape, where the deepest of the triangle's points lies over its face, as the shape's point farthest below
// does.
bool ConvexContacts::depth_by_face(const Corners& p, const TrianglePlane& plane, PairAnswer& r) const {
  const Vec3 n = plane.normal.dot(pair_.centre() - p[0]) < 0 ? Vec3(-plane.normal) : plane.normal;
  const Vec3 low = pair_.support(-n), foot = low + n.dot(p[0] - low) * n;
  return !is_beyond_side(p, n, foot, 0) && is_depth_along(p, n, pair_.bound(p, foot), r);
}

// Where it lies on an edge between points of which each is deeper towards the other: how deep a point lies is a concave
// function, whose derivative along the edge is that of the normal. Its zero is found by secants (Illinois).
bool ConvexContacts::depth_by_edge(const Corners& p, const CornerBounds& corners, PairAnswer& r) const {
  constexpr int most_steps = 8;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 edge = p[(k + 1) % 3] - p[k], across = p[(k + 2) % 3] - p[k];
    double from = 0, to = 1, rise = corners[k].normal.dot(edge), fall = corners[(k + 1) % 3].normal.dot(edge);
    if (!(rise > 0 && fall < 0)) continue;
    double before = 0;
    for (int i = 0; i < most_steps; ++i) {
      const double at = (rise * to - fall * from) / (rise - fall);
      const TriangleBound own = pair_.bound(p, p[k] + at * edge);
      const double slope = own.normal.dot(edge);
      const Vec3 n = unit(own.normal - slope / edge.squaredNorm() * edge);
      if (n.dot(across) > std::abs(slope)) break;  // deeper points lie inside
      if (std::abs(slope) <= tolerance::descent_accuracy * edge.norm()) return is_depth_along(p, n, own, r);
      if (slope > 0) {
        if (before > 0) fall /= 2;
        from = at, rise = slope;
      } else {
        if (before < 0) rise /= 2;
        to = at, fall = slope;
      }
      before = slope;
    }
  }
  return false;
}

// Proves a depth by a point of the triangle that is as deep, well beyond rounding.
bool ConvexContacts::depth_by_point(const Corners& p, const TrianglePlane& plane, TriangleBound& bound,
                                    PairAnswer& r) const {
  const double sure = -tolerance::alike * pair_.size();
  if (!bound.known || bound.gap >= sure) return false;
  const ShapeKind kind = pair_.convex().kind;
  const bool is_smooth = kind == ShapeKind::ellipsoid || kind == ShapeKind::capsule;
  CornerBounds corners;
  const bool is_known = depth_by_corner(p, bound, corners, r) ||
                        (is_smooth && (depth_by_face(p, plane, r) || depth_by_edge(p, corners, r)));
  return is_known && r.signed_distance < sure;
}

// Is the least depth of a triangle that overlaps found for sure along no normal at which its neighbours let it push?
// From a point of it inside the convex shape to where a line against its own normal leaves that, e away, both reach;
// along a direction n these two need e cos(n, own normal) to come apart, more than what is known to suffice.
bool ConvexContacts::chord_forbids(std::uint32_t t, const Vec3& normal, const TriangleBound& bound) const {
  if (!bound.overlaps) return false;
  const std::optional<double> least_cosine = CornerNormals::kept_least_cosine(pair_.model(), t);
  return least_cosine && exit_length(bound.point, normal) * *least_cosine > enough_for(bound);
}

// Else the same is shown of its edges and corners each by itself. `along_plane`: the depth along its own normal.
bool ConvexContacts::cannot_push(std::uint32_t t, const TrianglePlane& plane, double along_plane, const Corners& p,
                                 const TriangleBound& bound) const {
  if (chord_forbids(t, plane.normal, bound)) return true;
  CornerNormals cones;
  const double enough = enough_for(bound);
  if (!bound.overlaps || !(along_plane > enough) || !cones.find(pair_.model(), t)) return false;
  for (const double sign : {1.0, -1.0}) {
    for (std::size_t k = 0; k < 3; ++k)
      if (!needs_more(p[k], cones.around(k).first(2), cones.normals(k).first(2), sign, bound.normal, enough) ||
          !needs_more(p[k], cones.around(k), cones.normals(k), sign, bound.normal, enough))
        return false;
    if (pair_.model().solid) break;
  }
  return true;
}

// Off the triangle's plane, to the side of the convex shape's centre; whether that is the depth, which `r` tells then.
bool ConvexContacts::depth_along_plane(const Corners& p, const TrianglePlane& plane, double& depth,
                                       PairAnswer& r) const {
  const Vec3 n = plane.normal.dot(pair_.centre() - p[0]) < 0 ? Vec3(-plane.normal) : plane.normal;
  const Vec3 deepest = pair_.support(-n);
  depth = n.dot(p[0] - deepest);
  if (depth < -pair_.options().margin || pair_.convex().kind == ShapeKind::sphere ||
      !depth_is_along(n, p, deepest, depth))
    return false;
  r.signed_distance = -depth;
  r.normal = n;
  r.point_a = deepest + depth * n;
  r.point_b = deepest;
  return true;
}

// Is a triangle so far inside the convex shape that it can push along no direction (chord_forbids), as its middle and
// corners tell? Then it has what lies along its own normal alone, appended to `found`, and its depth is looked for
// where all others are less deep.
bool ConvexContacts::is_swallowed(std::uint32_t t, std::size_t lane, const ScreenedTriangles& screened, Seen& seen,
                                  std::vector<Contact>& found) const {
  if ((screened.deep >> lane & 1) == 0) return false;
  const double depth = screened.depth[lane], chord = screened.chord[lane];
  const std::optional<double> least_cosine = CornerNormals::kept_least_cosine(pair_.model(), t);
  if (!least_cosine || !(chord * (*least_cosine - screened.cosine_off[lane]) > depth)) return false;
  if ((screened.beside >> lane & 1) == 0) {
    const Corners p = pair_.corners(t);
    const TrianglePlane plane = pair_.plane_of(p);
    const double side = plane.normal.dot(pair_.centre() - p[0]);
    if (!plane.flat || (side == 0 && !pair_.model().solid)) return false;
    const Vec3 n = pair_.model().solid || side > 0 ? plane.normal : Vec3(-plane.normal);
    const Vec3 low = pair_.support(-n);
    append_over(p, n, low, n.dot(p[0] - low), found);
  }
  seen.leave(t, depth);
  return true;
}

// The triangle's contacts, appended to `found`, which holds `first` of others.
ConvexContacts::Apart ConvexContacts::find_contacts(std::uint32_t t, const Corners& p, Seen& seen,
                                                    std::vector<Contact>& found, std::size_t first) const {
  const double margin = pair_.options().margin;
  const TrianglePlane plane = pair_.plane_of(p);
  if (const double gap = pair_.box_gap_along(plane); gap > margin) return {gap};
  PairAnswer r;
  bool is_known = false;
  double along_plane = 0;
  if (plane.flat) {
    is_known = depth_along_plane(p, plane, along_plane, r);
    if (along_plane < -margin) return {-along_plane};
  }
  if (!is_known) {
    TriangleBound bound = pair_.bound(p);
    if (bound.gap > margin + pair_.slack()) return {bound.gap, bound.normal};
    is_known = plane.flat && depth_by_point(p, plane, bound, r);
    if (is_known && !pushes(t, p, plane, r, {})) {
      if (r.signed_distance < seen.near.signed_distance) seen.near = r;
      append_along_plane(p, plane, r.normal, seen, found);
      return {r.signed_distance, r.normal};
    }
    if (!is_known && plane.flat && cannot_push(t, plane, along_plane, p, bound)) {
      seen.leave(t, -bound.gap);
      append_along_plane(p, plane, bound.normal, seen, found);
      return {bound.gap, bound.normal};
    }
    if (!is_known) r = pair_.solve(p, Request::contacts);
  }
  pair_.append_patch(p, {r.signed_distance, r.point_a, r.point_b, r.normal, 0}, found);
  if (r.signed_distance < seen.near.signed_distance) seen.near = r;
  const Apart apart{r.signed_distance, r.normal};
  if (found.size() == first || pushes(t, p, plane, r, std::span<const Contact>(found).subspan(first))) return apart;
  // Its neighbours lie there. What the face bears counts of what has gone through it.
  found.resize(first);
  if (plane.flat && r.signed_distance < -tolerance::alike * pair_.size())
    append_along_plane(p, plane, r.normal, seen, found);
  return apart;
}

// Does all that the convex shape shows against n (unit) lie beyond one side of a triangle, so that clipping would leave
// nothing of it? All in the shape's frame; `low`: its point farthest against n.
bool ConvexContacts::lies_beside(const Corners& p, const Vec3& n, const Vec3& low) const {
  const double slack = 2 * std::max(tolerance::in_plane, tolerance::alike) * pair_.size();
  const ConvexView& convex = pair_.convex();
  const bool is_point = convex.kind == ShapeKind::sphere || convex.kind == ShapeKind::ellipsoid;
  const double turn = n.dot(area_vector(p)) > 0 ? 1 : -1;
  FlatFeature shown;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 out = turn * (p[(i + 1) % 3] - p[i]).cross(n);
    const double beyond = slack * out.norm(), offset = out.dot(p[i]);
    if (!(out.dot(low) - offset > beyond)) continue;
    if (is_point) return true;
    if (shown.count == 0) shown = best_face(convex, -n);
    if (std::all_of(shown.corner, shown.corner + shown.count,
                    [&](const Vec3& corner) { return out.dot(corner) - offset > beyond; }))
      return true;
  }
  return false;
}

bool ConvexContacts::is_known_beside(const Corners& p, const Vec3& n, const Vec3& low, Seen& seen) const {
  if (!seen.beside.is_due()) return false;
  const bool is_beside = lies_beside(p, n, low);
  seen.beside.tell(is_beside);
  return is_beside;
}

// The contacts along the triangle's normal, to the outer side; for a surface to that of the convex shape's centre.
void ConvexContacts::append_along_plane(const Corners& p, const TrianglePlane& plane, const Vec3& normal, Seen& seen,
                                        std::vector<Contact>& found) const {
  const double side = plane.normal.dot(pair_.centre() - p[0]);
  const bool as_wound = pair_.model().solid || side > 0 || (side == 0 && plane.normal.dot(normal) >= 0);
  const Vec3 n = as_wound ? plane.normal : Vec3(-plane.normal);
  const Vec3 low = pair_.support(-n);
  const double depth = n.dot(p[0] - low);
  if (depth < -pair_.options().margin) return;
  const Mat3& turn = pair_.turn();
  const Corners own{turn.transpose() * p[0], turn.transpose() * p[1], turn.transpose() * p[2]};
  if (is_known_beside(own, turn.transpose() * n, turn.transpose() * low, seen)) return;
  append_over(p, n, low, depth, found);
}

// Those along n (unit), against which the convex shape reaches to `low`, `depth` below the triangle's plane: what it
// shows there, clipped by the sides of the triangle.
void ConvexContacts::append_over(const Corners& p, const Vec3& n, const Vec3& low, double depth,
                                 std::vector<Contact>& found) const {
  const TriangleView triangle(p);
  const ConvexView &own = triangle, &convex = pair_.convex();
  const double slack = tolerance::alike * (own.size + convex.size);
  PatchPoint points[max_patch];
  int count = 0;
  if (own.vertices.size() == 3 && convex.kind != ShapeKind::sphere && convex.kind != ShapeKind::ellipsoid) {
    FlatFeature shown = best_face(convex, -(pair_.turn().transpose() * n));
    move(shown, {pair_.turn(), Vec3::Zero()});
    FlatFeature face;
    face.id = n.dot(area_vector(p)) >= 0 ? 0 : 1;
    for (std::size_t i = 0; i < 3; ++i) face.add(p[face.id == 0 ? i : 2 - i]);
    face.normal = n;
    count = clip_over_triangle(face, shown, pair_.options().margin, depth, slack, points);
  }
  const bool reaches = count > 0 && set_deepest(points, count, depth, slack);
  for (int i = 0; i < count; ++i) found.push_back({points[i].at, n, points[i].depth, points[i].feature});
  if (reaches) return;
  const Vec3 foot = low + depth * n;
  if (!is_beyond_side(p, n, foot, 2 * tolerance::in_plane * pair_.size()) &&
      point_distance(triangle, foot).signed_distance <= tolerance::in_plane * pair_.size())
    found.push_back({0.5 * (foot + low), n, depth, witness_point});
}

PairAnswer ConvexContacts::least_depth(const Corners& p) const {
  PairAnswer r;
  double along_plane = 0;
  const TrianglePlane plane = pair_.plane_of(p);
  if (plane.flat && depth_along_plane(p, plane, along_plane, r)) return r;
  TriangleBound bound = pair_.bound(p);
  if (plane.flat && depth_by_point(p, plane, bound, r)) return r;
  return pair_.solve(p, pair_.convex().kind == ShapeKind::sphere ? Request::contacts : Request::distance);
}

// Solves those of the remaining triangles that may be deeper than all others.
void ConvexContacts::find_deepest(Seen& seen) const {
  std::pmr::vector<Unsolved>& left = seen.unsolved;
  WorkMeter meter(pair_.options().limit, a_solve);
  SupportPlane clear;
  while (!left.empty() && left.front().depth > -seen.near.signed_distance) {
    const Corners p = pair_.corners(left.front().t);
    std::pop_heap(left.begin(), left.end());
    left.pop_back();
    meter.spend();
    if (-clear.beyond(p) <= -seen.near.signed_distance) continue;
    meter.spend(a_solve);
    const PairAnswer r = least_depth(p);
    if (r.signed_distance < seen.near.signed_distance) clear = pair_.support_plane(r.normal);
    if (r.signed_distance < seen.near.signed_distance) seen.near = r;
  }
}

void ConvexContacts::find(PairAnswer& near, PatchCollector& all, std::vector<Contact>& scratch) const {
  pair_.model().neighbours(pair_.options().limit);  // what follows asks for it
  const double margin = pair_.options().margin;
  ClearPlanes clear;
  const TriangleScreen screen = pair_.screen();
  Seen seen(near, lent_memory(pair_.options()));
  const std::size_t first = scratch.size();
  WorkMeter meter(pair_.options().limit, a_solve);
  const BoxQuery query = pair_.query();
  const int a_visit = query.a_visit() + static_cast<int>(pair_.convex().vertices.size() / 16);
  ScreenedTriangles screened;
  const auto visit = [&](std::uint32_t t, std::size_t lane) {
    if (is_swallowed(t, lane, screened, seen, scratch)) return;
    const Corners p = pair_.corners(t);
    if (clear.separate(p, margin + pair_.slack())) return;
    const Apart apart = find_contacts(t, p, seen, scratch, first);
    if (apart.gap > margin && !apart.normal.isZero()) clear.add(pair_.support_plane(apart.normal));
  };
  query.each_bottom(margin, [&](const MeshNode& node, std::uint32_t within) {
    if (screen.applies()) {
      meter.spend(screen.units());
      screen.look(node, within, screened);
    }
    for (std::uint32_t left = within; left != 0; left &= left - 1) {
      meter.spend(a_visit);
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
      const std::uint32_t t = pair_.model().triangle_of(node, lane);
      visit(t, lane);
      all.add(t, std::span<const Contact>(scratch).subspan(first));
      scratch.resize(first);
    }
    return false;
  });
  find_deepest(seen);
}

void ConvexContacts::append_patches(PatchCollector& all, double limit, std::vector<Contact>& out) const {
  const std::size_t first = out.size();
  all.finish(pair_.centre(), pair_.model().solid, out, limit);
  for (Contact& c : std::span(out).subspan(first)) c.depth = std::max(c.depth, -margin_);
}

}  // namespace tandem
