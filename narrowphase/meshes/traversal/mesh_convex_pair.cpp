#include "meshes/traversal/mesh_convex_pair.h"

#include <cmath>
#include <limits>

#include "closed_forms/closed_forms.h"
#include "manifold/manifold.h"
#include "meshes/traversal/point_in_mesh.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"

namespace tandem {

MeshConvexPair::MeshConvexPair(const Posed& mesh, const Posed& convex, const NarrowPhaseOptions& options)
    : mesh_(mesh),
      convex_shape_(convex.shape),
      convex_pose_(convex.pose),
      model_(mesh_of(mesh.shape)),
      view_(convex.shape.is_convex() ? view(convex.shape) : view_hull(convex.shape)),
      options_(options),
      size_(mesh.shape.size() + convex.shape.size()),
      radius_(core_radius(view_)) {
  const RelativePose r = relative(mesh.pose, convex.pose);
  turn_.rotation = r.rotation;
  shift_ = r.translation;
  const Bounds own = core_bounds(convex.shape, Pose{});
  own_mid_ = (own.lo + own.hi) / 2;
  own_half_ = (own.hi - own.lo) / 2;
  mid_ = turn_.rotation * own_mid_;
  if (!(radius_ > 0)) aligned_ = core_bounds(convex.shape, turn_);
}

// Rotated as it is: but for the shift nothing changes.
MeshConvexPair MeshConvexPair::placed(const Pose& convex_pose) const {
  MeshConvexPair pair = *this;
  pair.convex_pose_ = convex_pose;
  pair.shift_ = relative(mesh_.pose, convex_pose).translation;
  return pair;
}

BoxQuery MeshConvexPair::query() const {
  if (radius_ > 0) {
    const Vec3 half(0, 0, own_half_.z() - radius_), along = (turn_.rotation * half).cwiseAbs();
    return {model_, {shift_ - along, shift_ + along}, shift_, half, turn_.rotation, radius_, options_.limit};
  }
  return {model_,        {aligned_.lo + shift_, aligned_.hi + shift_}, mid_ + shift_, own_half_, turn_.rotation, 0,
          options_.limit};
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

bool MeshConvexPair::touches(const Corners& p) const {
  if (view_.kind != ShapeKind::sphere) {
    if (plane_gap(p) > slack()) return false;
    if (view_.kind == ShapeKind::box) {
      const double gap = box_gap(p);
      if (std::abs(gap) > slack()) return gap < 0;
    }
  }
  if (view_.kind == ShapeKind::sphere || view_.kind == ShapeKind::box)
    return solve(p, Request::distance).signed_distance <= 0;
  return solve(p, Request::collide).collide;
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
      const double length = std::hypot(edge[j], edge[k]);
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

bool MeshConvexPair::collide() const {
  bool hit = false;
  SupportPlane clear;
  query().each_near(0, [&](std::uint32_t t) {
    const Corners p = corners(t);
    if (clear.beyond(p) > slack()) return false;
    if (touches(p)) return hit = true;
    // What keeps it from this triangle keeps it from its neighbours as well, more often than not.
    if (view_.kind != ShapeKind::box) clear = support_plane(solve(p, Request::distance).normal);
    return false;
  });
  return hit || inside();
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
    // Of triangles equally near the first by index: whatever order they are found in, it is the same one.
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
  if (!(std::abs(near.signed_distance) <= slack())) return;
  near.collide = collide();
  near.signed_distance = near.collide ? std::min(near.signed_distance, 0.0)
                                      : std::max(near.signed_distance, std::numeric_limits<double>::min());
}

bool MeshConvexPair::inside() const {
  return model_.solid && is_inside(model_, mesh_.pose, own_centre(), convex_pose_, options_.limit);
}

}  // namespace tandem
