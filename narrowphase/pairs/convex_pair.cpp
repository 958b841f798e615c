// Answers a pair of convex shapes: chooses the method by the table, and completes its answer.
#include "pairs/convex_pair.h"

#include <algorithm>
#include <array>
#include <utility>

#include "closed_forms/closed_forms.h"
#include "manifold/manifold.h"
#include "pairs/gjk_pair.h"
#include "pairs/round_pair.h"
#include "pairs/solver_table.h"
#include "peers/peer_solvers.h"
#include "shapes/pair_order.h"
#include "tolerances.h"
#include "triangles/triangle_distance.h"

namespace tandem {
namespace {

void finish(const LocalAnswer& local, const Pose& pose_a, double tolerance, PairAnswer& answer) {
  answer.signed_distance = local.signed_distance;
  answer.collide = local.signed_distance <= 0;
  answer.normal = pose_a.rotation * local.normal;
  answer.point_a = pose_a * local.point_a;
  answer.point_b = pose_a * local.point_b;
  answer.error_bound = local.gap;
  answer.status = local.gap <= tolerance ? Status::ok : Status::inexact;
}

PairAnswer sphere_with(double radius, const Vec3& centre, const ConvexView& b, const Pose& pose_b) {
  const PointDistance d = point_distance(b, pose_b.rotation.transpose() * (centre - pose_b.translation));
  PairAnswer r;
  r.normal = -(pose_b.rotation * d.normal);
  r.signed_distance = d.signed_distance - radius;
  r.collide = r.signed_distance <= 0;
  r.point_a = centre + radius * r.normal;
  r.point_b = pose_b * d.nearest;
  return r;
}

/// The plane, or a half-space's plane, in the frame of another shape.
struct SeenPlane {
  Vec3 normal;
  double offset;

  SeenPlane(const ConvexView& plane, const Pose& pose, const Pose& frame) {
    const Vec3 n{plane.param[0], plane.param[1], plane.param[2]};
    normal = frame.rotation.transpose() * (pose.rotation * n);
    offset = plane.param[3] - n.dot(pose.rotation.transpose() * (frame.translation - pose.translation));
  }
};

PairAnswer halfspace_with(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b,
                          Request request, const NarrowPhaseOptions& options, std::vector<Contact>* contacts) {
  const auto [n, offset] = SeenPlane(a, pose_a, pose_b);
  const Vec3 lowest = core_support(b, -n) - core_radius(b) * n;
  PairAnswer r;
  r.signed_distance = n.dot(lowest) - offset;
  r.collide = r.signed_distance <= 0;
  r.normal = pose_a.rotation * Vec3(a.param[0], a.param[1], a.param[2]);
  r.point_b = pose_b * lowest;
  r.point_a = r.point_b - r.signed_distance * r.normal;
  if (request == Request::contacts && contacts != nullptr && r.signed_distance <= options.margin) {
    const std::size_t first = contacts->size();
    append_halfspace_manifold(b, pose_b, n, offset, options.margin, *contacts);
    // Rounding may remove the only corner of a patch that just touches.
    if (contacts->size() == first) append_single(r, options.margin, contacts);
  }
  return r;
}

/// `warm`: takes a separating direction.
std::optional<bool> collide_by(Method method, const MinkowskiDifference& d, const Pose& pose_a, const Pose& pose_b,
                               double tolerance, const Vec3* start, WarmStart* warm) {
  switch (method) {
    case Method::fcl:
      return fcl_collide(d.a, pose_a, d.b, pose_b);
    case Method::libccd:
      return ccd_collide(d.a, d.b, d.pose, false);
    case Method::mpr:
      return ccd_collide(d.a, d.b, d.pose, true);
    case Method::newton:
      return round_collide(d);
    case Method::sat:
      if (const auto answer = triangle_distance(d, 0)) return answer->signed_distance <= 0;
      break;
    default:
      break;
  }
  return gjk_collide(d, tolerance, start, warm != nullptr ? &warm->direction : nullptr);
}

std::optional<LocalAnswer> distance_by(Method method, const MinkowskiDifference& d, double tolerance, const Vec3* start,
                                       double beyond) {
  switch (method) {
    case Method::fcl:
      return fcl_signed_distance(d.a, d.b, d.pose);
    case Method::libccd:
      return ccd_depth(d.a, d.b, d.pose, false);
    case Method::mpr:
      return ccd_depth(d.a, d.b, d.pose, true);
    case Method::newton:
      return round_signed_distance(d, start, beyond);
    case Method::sat:
      if (auto answer = triangle_distance(d, beyond)) return answer;
      break;
    default:
      break;
  }
  return gjk_signed_distance(d, tolerance, start, beyond);
}

/// True for an ellipsoid whose radii are equal to rounding. As an ellipsoid its least depth in a concentric shape would
/// be the same in all directions, or all around an axis, and no few points bound that from below.
bool is_round(const ConvexView& view) {
  if (view.kind != ShapeKind::ellipsoid) return false;
  const auto [least, most] = std::minmax({view.param[0], view.param[1], view.param[2]});
  return most - least <= 4 * epsilon * most;
}

/// True for a hull with so few vertices that it is a triangle, whose edges the solvers of round bodies know.
bool is_triangle(const ConvexView& view) { return view.kind == ShapeKind::convex && view.vertices.size() <= 3; }

ConvexView triangle_of(ConvexView body) {
  body.kind = ShapeKind::triangle;
  return body;
}

/// A pair of which one shape is, to rounding, something simpler: a ball, or a triangle. Empty if neither is.
struct SimplerPair {
  ConvexView a, b;
};
std::optional<SimplerPair> simplified(const ConvexView& a, const Pose& pose_a, const ConvexView& b,
                                      const Pose& pose_b) {
  if (a.kind == ShapeKind::capsule || b.kind == ShapeKind::capsule) {
    const double reach = a.size + b.size + (pose_b.translation - pose_a.translation).lpNorm<Eigen::Infinity>();
    if (axis_is_lost(a, reach)) return SimplerPair{ball_of(a), b};
    if (axis_is_lost(b, reach)) return SimplerPair{a, ball_of(b)};
  }
  if (is_triangle(a)) return SimplerPair{triangle_of(a), b};
  if (is_triangle(b)) return SimplerPair{a, triangle_of(b)};
  if (is_round(a)) return SimplerPair{ball_of(a), b};
  if (is_round(b)) return SimplerPair{a, ball_of(b)};
  return std::nullopt;
}

/// The measured error, relative to the size, of solvers that give no bound themselves.
double measured_error(const MethodChoice& choice) { return choice.row != nullptr ? choice.row->error : 0; }

PairAnswer verdict_by(const MethodChoice& choice, const MinkowskiDifference& d, const Pose& pose_a, const Pose& pose_b,
                      const Vec3* start, WarmStart* warm) {
  const double size = d.a.size + d.b.size;
  PairAnswer answer;
  answer.error_bound = measured_error(choice) * size;
  std::optional<bool> collide = collide_by(choice.method, d, pose_a, pose_b, choice.tolerance, start, warm);
  if (!collide) {  // the other library gave up: answer all the same, and report it
    collide = collide_by(Method::gjk, d, pose_a, pose_b, choice.tolerance, start, warm);
    answer.status = Status::inexact;
    answer.error_bound = size;
  }
  answer.collide = *collide;
  return answer;
}

PairAnswer answer_by(const MethodChoice& choice, const MinkowskiDifference& d, const Pose& pose_a, Request request,
                     const NarrowPhaseOptions& options, const Vec3* start, std::vector<Contact>* contacts,
                     WarmStart* warm) {
  const double size = d.a.size + d.b.size, accepted = std::max(options.tolerance, tolerance::accepted_error) * size;
  const double beyond = request == Request::contacts ? options.margin : infinity;
  const Method method = choice.method;
  std::optional<LocalAnswer> local = distance_by(method, d, choice.tolerance, start, beyond);
  if (!local) {
    local = gjk_signed_distance(d, choice.tolerance);
    local->gap = std::max(local->gap, size);
  }
  local->gap = std::max(local->gap, measured_error(choice) * size);
  if (warm != nullptr && (method == Method::sat || method == Method::gjk || method == Method::newton))
    warm->direction = local->normal;
  PairAnswer answer;
  finish(*local, pose_a, accepted, answer);
  if (request == Request::contacts && contacts != nullptr)
    append_manifold(d.a, d.b, d.pose, *local, options.margin, pose_a, *contacts);
  return answer;
}

/// The half-space on one side of a plane: the one on the side from which B comes, or beyond which B reaches least,
/// which is the one farther from B.
ConvexView nearer_side(const ConvexView& plane, const Pose& pose, const ConvexView& b, const Pose& pose_b) {
  const auto [n, offset] = SeenPlane(plane, pose, pose_b);
  const double above = n.dot(core_support(b, -n)) - offset, below = offset - n.dot(core_support(b, n));
  ConvexView side = plane;
  side.kind = ShapeKind::halfspace;
  if (below > above)
    for (double& p : side.param) p = -p;
  return side;
}

}  // namespace

PairAnswer solve_convex(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b,
                        Request request, const NarrowPhaseOptions& options, std::vector<Contact>* contacts,
                        WarmStart* warm) {
  if (rank(a.kind) > rank(b.kind) || (a.kind == b.kind && comes_after(a, pose_a, b, pose_b))) {
    const std::size_t first = contacts != nullptr ? contacts->size() : 0;
    WarmStart other;
    if (warm != nullptr) other.direction = -(pose_b.rotation.transpose() * (pose_a.rotation * warm->direction));
    PairAnswer answer = solve_convex(b, pose_b, a, pose_a, request, options, contacts, &other);
    if (warm != nullptr) warm->direction = -(pose_a.rotation.transpose() * (pose_b.rotation * other.direction));
    swap_answer(answer, contacts, first);
    return answer;
  }
  if (a.kind == ShapeKind::plane)
    return solve_convex(nearer_side(a, pose_a, b, pose_b), pose_a, b, pose_b, request, options, contacts, warm);
  const MethodChoice choice = choose_method(a.kind, b.kind, request, options);
  const Method method = choice.method;
  if (const PairSolver& pair = pair_solver(a.kind, b.kind); pair.direct != nullptr && method == pair.method)
    return pair.direct(a.param, pose_a, b.param, pose_b, request, options.margin, contacts);
  if (method == Method::closed) {
    if (a.kind == ShapeKind::halfspace) return halfspace_with(a, pose_a, b, pose_b, request, options, contacts);
    const PairAnswer answer = sphere_with(a.param[0], pose_a.translation, b, pose_b);
    if (request == Request::contacts) append_single(answer, options.margin, contacts);
    return answer;
  }
  if (const std::optional<SimplerPair> simpler = simplified(a, pose_a, b, pose_b))
    return solve_convex(simpler->a, pose_a, simpler->b, pose_b, request, options, contacts, warm);
  Vec3 from;
  const Vec3* start = nullptr;
  if (warm != nullptr && warm->direction.allFinite() && !warm->direction.isZero(0)) {
    from = unit(warm->direction);
    start = &from;
  }
  const MinkowskiDifference d{a, b, relative(pose_a, pose_b), options.limit};
  if (request == Request::collide) return verdict_by(choice, d, pose_a, pose_b, start, warm);
  return answer_by(choice, d, pose_a, request, options, start, contacts, warm);
}

}  // namespace tandem
