// A mesh and a convex shape that overlap: queries of the search for a separating translation.
#include "meshes/depth/convex_in_mesh.h"

#include <algorithm>
#include <cmath>

#include "closed_forms/surface_distance.h"
#include "meshes/depth/off_parts.h"
#include "meshes/traversal/coplanar_region.h"
#include "meshes/traversal/point_in_mesh.h"
#include "meshes/traversal/point_queries.h"

namespace tandem {
namespace {

constexpr SearchEffort effort_of_convex{
    .least_reach = 0.5, .rounds = 8, .plane_reach = infinity, .margin = 0, .plane_slack = 1, .trust_planes = true};

}  // namespace

ConvexInMesh::ConvexInMesh(const MeshConvexPair& pair) : OverlappingPair(pair.size(), effort_of_convex), pair_(pair) {}

// True if a slightly longer translation along d is free, too. In a wedge it is not, since the other side blocks it.
bool ConvexInMesh::leads_on(double length, const Vec3& d) const {
  const double little = tolerance::alike * size;
  const Vec3 farther = (length + little) * d;
  if (!collide(farther)) return true;
  const PairAnswer side = pair_.moved(farther).nearest();
  const double depth = -side.signed_distance;
  return depth >= 0 && depth <= little && !collide(farther + (depth + little) * side.normal);
}

// Planes across the direction push the convex shape beyond one layer of triangles after the other.
double ConvexInMesh::free_length(const Vec3& d, const Separation& known) const {
  constexpr int layers = 64;
  const double low = d.dot(pair_.support(-d)), clearance = pair_.translation_slack();  // beyond mere contact
  double length = 0;
  for (int i = 0; i < layers; ++i) {
    const MeshConvexPair there = pair_.moved((length + clearance) * d);
    double next = -infinity;
    ClearPlanes clear;
    there.each_near(0, [&](std::uint32_t t) {
      const Corners p = there.corners(t);
      const double level = most_along(d, p) - low;
      if (!(level > next) || clear.separate(p, pair_.slack())) return false;
      const TriangleBound bound = there.bound(p);
      if (!bound.overlaps && bound.gap > pair_.slack()) {
        clear.add(there.support_plane(bound.normal));
        return false;
      }
      if (there.touches(p, bound, nullptr)) next = level;
      return length + next > known.length;
    });
    if (next == -infinity) {
      if (there.inside()) {
        // The part of the convex shape behind its centre has to cross the surface, too.
        next = first_crossing(pair_.model(), there.in_mesh(there.centre()), d, pair_.options().limit) +
               pair_.exit_length(pair_.centre(), -d);
      } else {
        if (leads_on(length, d)) return length;
        next = tolerance::alike * size;
      }
    }
    length += std::max(clearance + next, slack);
    if (!(length < known.length)) return infinity;
  }
  return infinity;
}

bool ConvexInMesh::separating_planes(const Vec3& at, double reach, std::vector<Constraint>& planes) {
  constexpr std::size_t most = 48;
  const MeshConvexPair there = pair_.moved(at);
  struct Known {
    SupportPlane plane;
    double gap;
  };
  std::vector<Known> known;
  planes.clear();
  bool separated = true;
  there.each_near(reach, [&](std::uint32_t t) {
    const Corners p = there.corners(t);
    if (std::any_of(known.begin(), known.end(), [&](const Known& k) { return k.plane.beyond(p) >= k.gap; }))
      return false;
    if (const TriangleBound bound = there.bound(p); bound.gap > reach) return false;
    const PairAnswer r = there.solve(p, Request::distance);
    if (r.signed_distance > reach) return false;
    const SupportPlane own = there.support_plane(r.normal);
    const double gap = own.beyond(p);
    if (!(r.signed_distance > 0 && gap > 0) || planes.size() == most) {
      separated = false;
      return true;
    }
    known.push_back({own, gap});
    planes.push_back({r.normal, r.normal.dot(at) - gap});
    return false;
  });
  return separated;
}

bool ConvexInMesh::add_constraints(const Vec3& at, LocalConstraints& constraints) const {
  const MeshConvexPair there = pair_.moved(at);
  bool is_new = false;
  there.each_near(0, [&](std::uint32_t t) {
    const Corners p = there.corners(t);
    const TrianglePlane plane = there.plane_of(p);
    if (!plane.flat) return false;
    Vec3 n = plane.normal;
    double height = n.dot(there.centre() - p[0]);
    if (height < 0 && pair_.model().solid) return false;
    if (height < 0) n = -n, height = -height;
    const Vec3 lowest = there.support(-n);
    const double depth = n.dot(p[0] - lowest);
    constexpr double ample = 16;
    if (!(depth > 0) || constraints.imply({{n, n.dot(at) + depth}, ample * depth, Vec3::Zero()})) return false;
    LocalConstraint found;
    if (chord_constraint(there, t, n, lowest, at, found)) is_new = constraints.add(found) || is_new;
    return false;
  });
  return is_new;
}

// Translated by `at`, off each triangle that touches there.
bool ConvexInMesh::add_off_triangles(const Vec3& at, LocalConstraints& constraints) const {
  struct Touching {
    Corners corners;
    PairAnswer answer;
    Vec3 outside;
  };
  constexpr std::size_t most = 256;
  std::vector<Touching> touching;
  const MeshConvexPair there = pair_.moved(at);
  there.each_near(slack, [&](std::uint32_t t) {
    const Corners p = there.corners(t);
    if (there.bound(p).gap > slack) return false;
    const PairAnswer r = there.solve(p, Request::distance);
    const TrianglePlane plane = there.plane_of(p);
    if (r.signed_distance <= slack)
      touching.push_back({p, r, pair_.model().solid && plane.flat ? plane.normal : Vec3(Vec3::Zero())});
    return touching.size() == most;
  });
  OffParts off(at, slack / 8, constraints);
  for (const Touching& t : touching) off.add_outside(t.outside);
  for (const Touching& t : touching) {
    const auto gap_along = [&](const Vec3& n) { return there.support_plane(n).beyond(t.corners); };
    if (!off.leave(t.outside, gap_along)) off.add(t.answer, t.outside, gap_along);
  }
  if (touching.empty() && there.inside()) {
    // Through the nearest triangle.
    const PairAnswer near = there.nearest();
    off.add(-near.normal, there.support_plane(-near.normal).low + near.normal.dot(near.point_a));
  }
  return off.finish();
}

std::optional<Vec3> ConvexInMesh::off_triangles() const {
  const auto add = [&](const Vec3& at, int, LocalConstraints& off) { return add_off_triangles(at, off); };
  return translation_off_all(Vec3::Zero(), off_precision(), add, [&](const Vec3& at) { return collide(at); });
}

// A chord of the convex shape, from its deepest point over the triangle to its centre, passes through the triangle. It
// still does after a translation smaller than the height of the chord's end above the plane, and smaller than what
// moves the crossing beyond the triangle's edges.
bool ConvexInMesh::chord_constraint(const MeshConvexPair& there, std::uint32_t t, const Vec3& n, const Vec3& lowest,
                                    const Vec3& at, LocalConstraint& found) const {
  const Corners p = there.corners(t);
  const double depth = n.dot(p[0] - lowest);
  // The middle of the deepest points over the triangle.
  std::vector<Contact> points;
  there.append_patch(p, {-depth, lowest + depth * n, lowest, n, 0}, points);
  double deepest = -infinity;
  for (const Contact& c : points) deepest = std::max(deepest, c.depth);
  Vec3 low = Vec3::Zero();
  double count = 0;
  for (const Contact& c : points)
    if (c.depth >= deepest - slack) low += c.point - (0.5 * c.depth) * n, ++count;
  if (!(count > 0)) return false;
  low /= count;
  // A face nearly parallel to the triangle counts as parallel in a patch, whose points may then lie outside the shape:
  // the middle is moved onto it. For flat shapes and large hulls, with no surface to move it to, the deepest point.
  if (const auto off = surface_distance(pair_.convex(), pair_.turn().transpose() * low, 0))
    low -= std::max(0.0, off->distance) * (pair_.turn() * off->normal);
  else if (pair_.convex().kind != ShapeKind::sphere)
    low = lowest;
  const double below = n.dot(p[0] - low);
  const Vec3 chord = there.centre() - low;
  const double rise = n.dot(chord), slope = rise / chord.norm();
  if (!(below > 0 && rise > 0)) return false;
  const Vec3 crossing = there.in_mesh(low + (below / rise) * chord);
  pair_.model().neighbours(pair_.options().limit);  // computed here, where a limit is known
  const double inside = distance_to_region_border(pair_.model(), t, there.plane_of(p).normal, crossing, slack);
  if (!(inside > 0)) return false;
  const double height = n.dot(there.centre() - p[0]);
  found = {{n, n.dot(at) + below}, std::min(height, inside * slope) - at.norm(), Vec3::Zero()};
  return true;
}

// The bound by a point of the convex shape with an inscribed ball: if `leads_out`, no translation that separates ends
// inside.
ConvexInMesh::DeepPoint ConvexInMesh::deep_point(const Vec3& p, double ball, bool leads_out) const {
  const Vec3 in_mesh = pair_.in_mesh(p);
  const SurfacePoint near = nearest_point(pair_.model(), in_mesh, pair_.options().limit);
  // Not over near.distance: on an edge both are rounding errors, of different sizes.
  const Vec3 out = unit(near.at - in_mesh);
  if (leads_out && is_inside(pair_.model(), in_mesh, pair_.options().limit)) return {ball + near.distance, out};
  return {ball - near.distance, -out};
}

// True if every translation that separates and is not longer than this leads out of the closed surface, not into it. A
// point of the convex shape farther outside than that stays there, and the rest with it. A translation that leads
// inside is, to rounding, at least as long as the farthest point is outside.
bool ConvexInMesh::leads_out(double length, const Vec3& normal) const {
  const MeshModel& model = pair_.model();
  if (model.solid) return true;
  if (!model.closed || !std::isfinite(length)) return false;
  for (const Vec3& p : {pair_.centre(), pair_.support(normal)}) {
    const Vec3 in_mesh = pair_.in_mesh(p);
    if (nearest_point(model, in_mesh, pair_.options().limit).distance > length + pair_.translation_slack() &&
        !is_inside(model, in_mesh, pair_.options().limit))
      return true;
  }
  return false;
}

Vec3 ConvexInMesh::raise_by_deep_points(const Vec3& normal, Separation& known) const {
  constexpr std::size_t most_corners = 32;
  const ConvexView& convex = pair_.convex();
  const Mat3& turn = pair_.turn();
  const bool out = leads_out(known.length, normal);
  DeepPoint deepest = deep_point(pair_.centre(), core_radius(convex) + core_inner_radius(convex), out);
  const auto consider = [&](const Vec3& p, double ball) {
    if (const DeepPoint here = deep_point(p, ball, out); here.depth > deepest.depth) deepest = here;
  };
  if (convex.kind != ShapeKind::sphere) consider(pair_.support(-normal), 0);
  if (convex.kind == ShapeKind::capsule)
    for (const double s : {-0.5, 0.5}) consider(turn.col(2) * (s * convex.param[1]), pair_.radius());
  if (out && convex.kind == ShapeKind::box)
    for (unsigned i = 0; i < 8; ++i) {
      const Vec3 s(i & 1u ? 1 : -1, i & 2u ? 1 : -1, i & 4u ? 1 : -1);
      consider(turn * s.cwiseProduct(pair_.box_half()), 0);
    }
  if (out && convex.hull != nullptr && convex.vertices.size() <= most_corners)
    for (const Vec3& v : convex.vertices) consider(turn * v, 0);
  known.certain = std::max(known.certain, deepest.depth);
  return deepest.out;
}

}  // namespace tandem
