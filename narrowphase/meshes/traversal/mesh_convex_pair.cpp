// A mesh and a bounded convex shape, triangle by triangle.
#include "meshes/traversal/mesh_convex_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "closed_forms/closed_forms.h"
#include "closed_forms/surface_distance.h"
#include "manifold/manifold.h"
#include "meshes/traversal/point_in_mesh.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "triangles/predicates.h"

namespace tandem {
namespace {

// The view of the convex shape, or of another one's hull. A capsule without an axis is solved as the ball that it is:
// else its side would be a line of no length, which has contacts of its own.
ConvexView view_beside(const Posed& mesh, const Posed& convex, const WorkLimit* limit) {
  const ConvexView v = convex.shape.is_convex() ? view(convex.shape) : view_hull(convex.shape, limit);
  return axis_is_lost(v, mesh.shape.size() + v.size) ? ball_of(v) : v;
}

}  // namespace

MeshConvexPair::MeshConvexPair(const Posed& mesh, const Posed& convex, const NarrowPhaseOptions& options)
    : mesh_(mesh),
      convex_shape_(convex.shape),
      convex_pose_(convex.pose),
      model_(mesh_of(mesh.shape)),
      view_(view_beside(mesh, convex, options.limit)),
      options_(options),
      size_(mesh.shape.size() + convex.shape.size()),
      radius_(core_radius(view_)) {
  const RelativePose r = relative(mesh.pose, convex.pose);
  turn_.rotation = r.rotation;
  shift_ = r.translation;
  const Bounds own = core_bounds(convex.shape, Pose{}, options.limit);
  own_mid_ = (own.lo + own.hi) / 2;
  own_half_ = (own.hi - own.lo) / 2;
  mid_ = turn_.rotation * own_mid_;
  if (!(radius_ > 0)) aligned_ = core_bounds(convex.shape, turn_, options.limit);
}

// Same rotation: only the translation changes.
MeshConvexPair MeshConvexPair::placed(const Pose& convex_pose) const {
  MeshConvexPair pair = *this;
  pair.convex_pose_ = convex_pose;
  pair.shift_ = relative(mesh_.pose, convex_pose).translation;
  return pair;
}

BoxQuery MeshConvexPair::query() const {
  // A triangle with a hull takes longer the more vertices that has.
  const int a_visit = 16 + static_cast<int>(std::min<std::size_t>(view_.vertices.size(), 1024) / 16);
  if (radius_ > 0) {
    const Vec3 half(0, 0, own_half_.z() - radius_), along = (turn_.rotation * half).cwiseAbs();
    return {model_, {shift_ - along, shift_ + along}, shift_, half, turn_.rotation, radius_, options_.limit, a_visit};
  }
  return {
      model_, {aligned_.lo + shift_, aligned_.hi + shift_}, mid_ + shift_, own_half_, turn_.rotation, 0, options_.limit,
      a_visit};
}

PairAnswer MeshConvexPair::solve(const Corners& p, Request request) const {
  if (view_.kind == ShapeKind::sphere && request == Request::distance) {
    const PointDistance d = point_distance(TriangleView(p), Vec3::Zero());
    PairAnswer r;
    r.signed_distance = d.signed_distance - radius_;
    r.collide = r.signed_distance <= 0;
    r.normal = d.normal;
    r.point_a = d.nearest;
    r.point_b = -radius_ * d.normal;
    return r;
  }
  return solve_convex(TriangleView(p), Pose{}, view_, turn_, request, options_, nullptr);
}

void MeshConvexPair::append_patch(const Corners& p, const LocalAnswer& answer, std::vector<Contact>& contacts) const {
  constexpr bool whole = true;
  append_manifold(TriangleView(p), view_, {turn_.rotation, Vec3::Zero()}, answer, options_.margin, Pose{}, contacts,
                  whole);
}

TriangleBound MeshConvexPair::bound(const Corners& p, const Vec3& point) const {
  Vec3 on_surface;
  return bound_by(p, point, on_surface);
}

// The shortest translation that moves a point out of a convex shape is to the nearest point of its surface; one that
// also moves the triangle out is the shortest for both.
TriangleBound MeshConvexPair::bound_by(const Corners& p, const Vec3& point, Vec3& on_surface) const {
  if (view_.kind == ShapeKind::sphere) return {};
  const auto surface = surface_distance(view_, turn_.rotation.transpose() * point, 10 * slack());
  if (!surface) return {};
  TriangleBound b{true, surface->inside, false, point, -(turn_.rotation * surface->normal)};
  on_surface = point + surface->distance * b.normal;
  if (surface->inside) {
    const double top = most_along(b.normal, p) - b.normal.dot(point);
    b.is_depth = top <= 0;
    b.depth = -surface->distance;
    b.gap = surface->distance - std::max(0.0, top);
  } else {
    b.gap = support_plane(b.normal).beyond(p);
  }
  return b;
}

TriangleBound MeshConvexPair::bound(const Corners& p) const {
  if (view_.kind == ShapeKind::ellipsoid) {
    // In units of its radii it is a ball, and the point nearest to its centre decides contact.
    const Vec3 radii{view_.param[0], view_.param[1], view_.param[2]};
    const Mat3 to_own = turn_.rotation.transpose();
    const Corners q{(to_own * p[0]).cwiseQuotient(radii), (to_own * p[1]).cwiseQuotient(radii),
                    (to_own * p[2]).cwiseQuotient(radii)};
    const Vec3 near = point_distance(TriangleView(q), Vec3::Zero()).nearest;
    const Vec3 point = turn_.rotation * near.cwiseProduct(radii);
    if (near.squaredNorm() < 1) return bound(p, point);
    TriangleBound b{true, false, false, point, -(turn_.rotation * unit(near.cwiseQuotient(radii)))};
    b.gap = support_plane(b.normal).beyond(p);
    return b;
  }
  constexpr int steps = 2;  // alternating projections
  Vec3 on_surface;
  TriangleBound best = bound_by(p, (p[0] + p[1] + p[2]) / 3, on_surface);
  for (int i = 0; i < steps && best.known && !best.overlaps && best.gap <= slack(); ++i) {
    const TriangleBound next = bound_by(p, point_distance(TriangleView(p), on_surface).nearest, on_surface);
    if (next.overlaps || next.gap > best.gap) best = next;
  }
  return best;
}

double MeshConvexPair::exit_length(const Vec3& point, const Vec3& d) const {
  const Mat3 to_own = turn_.rotation.transpose();
  return tandem::exit_length(view_, to_own * point, to_own * d);
}

bool MeshConvexPair::touches(const Corners& p, const TriangleBound& bound, Vec3* apart_along) const {
  if (bound.overlaps) return true;
  const auto apart = [&](const Vec3& n) {
    if (apart_along != nullptr) *apart_along = n;
    return false;
  };
  if (bound.gap > slack()) return apart(bound.normal);
  if (view_.kind != ShapeKind::sphere) {
    const TrianglePlane plane = plane_of(p);
    if (gap_along(plane) > slack())
      return apart(plane.normal.dot(mid_) > plane.high ? plane.normal : Vec3(-plane.normal));
    if (view_.kind == ShapeKind::box) {
      const double gap = box_gap(p);
      if (std::abs(gap) > slack()) return gap < 0;
    }
  }
  if (view_.kind == ShapeKind::sphere || view_.kind == ShapeKind::box) {
    const PairAnswer r = solve(p, Request::distance);
    return r.signed_distance <= 0 || apart(r.normal);
  }
  if (solve(p, Request::collide).collide) return true;
  // For contacts the search ends when they are known to be beyond the margin.
  return apart_along != nullptr && apart(solve(p, Request::contacts).normal);
}

// Along 13 axes (Akenine-Moeller, Fast 3D triangle-box overlap testing, 2001).
double MeshConvexPair::box_gap(const Corners& p) const {
  const Mat3 to_box = turn_.rotation.transpose();
  const Corners q{to_box * p[0], to_box * p[1], to_box * p[2]};
  double gap = (q[0].cwiseMin(q[1]).cwiseMin(q[2]) - own_half_)
                   .cwiseMax(-own_half_ - q[0].cwiseMax(q[1]).cwiseMax(q[2]))
                   .maxCoeff();
  if (gap > slack()) return gap;
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3 edge = q[(e + 1) % 3] - q[e];
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      // Axis i x edge: (.., -edge[k], edge[j]).
      const double length = std::sqrt(edge[j] * edge[j] + edge[k] * edge[k]);
      if (!(length > 0)) continue;
      const double extent = own_half_[j] * std::abs(edge[k]) + own_half_[k] * std::abs(edge[j]);
      const auto at = [&](const Vec3& v) { return edge[j] * v[k] - edge[k] * v[j]; };
      const double a = at(q[e]), b = at(q[(e + 2) % 3]);
      gap = std::max(gap, (std::max(std::min(a, b), -std::max(a, b)) - extent) / length);
      if (gap > slack()) return gap;
    }
  }
  const TrianglePlane plane = plane_of(p);
  return std::max(gap, plane.flat ? gap_along(plane) : std::max(0.0, gap_along(plane)));
}

bool MeshConvexPair::collide(std::span<const Vec3> towards) const {
  bool hit = false;
  ClearPlanes clear;
  const double rounding = undecided();
  bool in_doubt = false;
  for (const Vec3& n : towards) clear.add(support_plane(n));
  query().each_near(0, [&](std::uint32_t t) {
    const Corners p = corners(t);
    if (clear.separate(p, rounding)) return false;
    Vec3 apart_along = Vec3::Zero();
    hit = touches(p, bound(p), &apart_along);
    if (hit) return true;
    SupportPlane plane;
    if (!apart_along.isZero(0)) clear.add(plane = support_plane(apart_along));
    in_doubt = in_doubt || !(plane.beyond(p) > rounding);
    return false;
  });
  return hit || inside() || (in_doubt && thin_parts_meet());
}

// Visits triangles, also without area, that are parts of a body no thicker than rounding, in its frame, until visit
// returns true: the faces of a hull, the line of a rod. None of other bodies.
template <class Visit>
bool MeshConvexPair::any_thin_part(Visit&& visit) const {
  const double rounding = undecided();
  if (view_.hull == nullptr) {
    int longest = 0;
    own_half_.maxCoeff(&longest);
    const Vec3 half = own_half_[longest] * Vec3::Unit(longest), width = own_half_ - half;
    return width.maxCoeff() <= rounding && visit(Corners{own_mid_ - half, own_mid_ + half, own_mid_ + half});
  }
  const Hull& hull = *view_.hull;
  if (hull.inner_radius > rounding) return false;
  if (hull.faces.empty()) return visit(Corners{hull.vertices.front(), hull.vertices.back(), hull.vertices.back()});
  for (const Hull::Face& face : hull.faces) {
    const std::uint32_t* const loop = hull.loop.data() + face.first;
    for (std::uint32_t k = 2; k < face.count; ++k)
      if (visit(Corners{hull.vertices[loop[0]], hull.vertices[loop[k - 1]], hull.vertices[loop[k]]})) return true;
  }
  return false;
}

// By rounded distances from single triangles a body without thickness may pass between two with a common edge.
bool MeshConvexPair::thin_parts_meet() const {
  TriangleTest test(mesh_.pose, convex_pose_, (own_mid_.cwiseAbs() + own_half_).maxCoeff());
  return any_thin_part([&](const Corners& b) {
    const Corners in_a{test.in_a(b[0]), test.in_a(b[1]), test.in_a(b[2])};
    bool meets = false;
    query().each_near(0, [&](std::uint32_t t) { return meets = test(model_.corners(t), b, in_a); });
    return meets;
  });
}

PairAnswer MeshConvexPair::nearest(double cutoff) const {
  PairAnswer best;
  best.signed_distance = infinity;
  std::uint32_t nearest = 0;
  SupportPlane clear;
  const double within = cutoff + slack();
  query().nearest_first(within, [&](std::uint32_t t) {
    if (best.signed_distance <= 0) return -1.0;
    const Corners p = corners(t);
    const double interest = std::min(best.signed_distance, within) + slack();
    if (clear.beyond(p) > interest || plane_gap(p) > interest) return interest;
    if (bound(p).gap > interest) return interest;
    // The first by index of equally near triangles, so that the order of the search does not matter.
    const PairAnswer r = solve(p, Request::distance);
    if (r.signed_distance < best.signed_distance || (r.signed_distance == best.signed_distance && t < nearest)) {
      best = r;
      nearest = t;
      clear = support_plane(best.normal);
    }
    return std::min(best.signed_distance, within) + slack();
  });
  decide(best);
  return best;
}

void MeshConvexPair::decide(PairAnswer& near) const {
  if (!(std::abs(near.signed_distance) <= undecided())) return;
  near.collide = collide();
  near.signed_distance = near.collide ? std::min(near.signed_distance, 0.0)
                                      : std::max(near.signed_distance, std::numeric_limits<double>::min());
}

bool MeshConvexPair::inside() const {
  return model_.solid && is_inside(model_, mesh_.pose, own_centre(), convex_pose_, options_.limit);
}

}  // namespace tandem
