// Direct solvers: pairs of simple shapes from their parameters to the answer.
#include "pairs/simple_pairs.h"

#include <bit>
#include <span>

#include "boxes/box_manifold.h"
#include "boxes/segment_box.h"
#include "closed_forms/closed_forms.h"
#include "manifold/manifold.h"
#include "shapes/pair_order.h"
#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// True if length - reach <= 0, from the squared length: takes a square root only where rounding could decide.
bool within(double length2, double reach) {
  const double reach2 = reach * reach;
  if (length2 < reach2 * (1 - tolerance::squares_rounding)) return true;
  if (length2 > reach2 * (1 + tolerance::squares_rounding)) return false;
  return std::sqrt(length2) - reach <= 0;
}

void place(const LocalAnswer& local, const Pose& pose_a, PairAnswer& answer) {
  answer.signed_distance = local.signed_distance;
  answer.collide = local.signed_distance <= 0;
  answer.normal = pose_a.rotation * local.normal;
  answer.point_a = pose_a * local.point_a;
  answer.point_b = pose_a * local.point_b;
}

/// The distance of segments that are neither short nor nearly parallel, and whose gap is well above rounding; false for
/// others. The first is centred at the origin. Inlined, so that results stay in registers and unused ones are not
/// computed.
[[gnu::always_inline]] inline bool clear_segment_distance(const Vec3& half_a, const Vec3& centre_b, const Vec3& half_b,
                                                          SegmentDistance& d) {
  const Vec3 r = -centre_b;
  const double uu = half_a.squaredNorm(), vv = half_b.squaredNorm(), uv = half_a.dot(half_b);
  const double ru = r.dot(half_a), rv = r.dot(half_b), det = uu * vv - uv * uv;
  if (!(det > tolerance::clearly_crossing2 * (uu * vv) && det > tolerance::shortest_squared)) return false;
  // The best s overall; the best t for it; if that is an end, the best s for that (Ericson 2005, 5.1.9).
  const double by_uu = 1 / uu, by_vv = 1 / vv;
  const auto within = [](double x) { return std::min(std::max(x, -1.0), 1.0); };
  const double t = within((within((uv * rv - vv * ru) / det) * uv + rv) * by_vv), s = within((t * uv - ru) * by_uu);
  const bool inside_a = std::abs(s) < 1, inside_b = std::abs(t) < 1, inside = inside_a && inside_b;
  Vec3 gap = t * half_b - s * half_a - r;
  // Inside a segment the normal is made perpendicular to it, despite the rounding of a small difference.
  if (gap.squaredNorm() < tolerance::short_gap2 * (r.squaredNorm() + uu + vv)) {
    gap -= ((inside_a ? by_uu : 0.0) * gap.dot(half_a)) * half_a;
    gap -= ((inside_b ? by_vv : 0.0) * gap.dot(half_b)) * half_b;
  }
  // Inside both segments it is perpendicular to both, also where they cross.
  const Vec3 axis = inside ? Vec3(half_a.cross(half_b)) : gap, from = inside ? Vec3(-r) : gap;
  const double length2 = axis.squaredNorm();
  if (!(length2 > (inside ? tolerance::shortest_squared : tolerance::lost_of_three2 * (r.squaredNorm() + uu + vv))))
    return false;
  // The division by the length comes last, so that the distance does not wait for the normal.
  const double along = axis.dot(from), length = std::sqrt(length2);
  d.distance = std::abs(along) / length;
  d.normal = axis / std::copysign(length, along);
  d.point_a = s * half_a;
  d.point_b = centre_b + t * half_b;
  return true;
}

[[gnu::always_inline]] inline SegmentDistance axes_distance(const Pose& pose_a, double length_a, const Pose& pose_b,
                                                            double length_b) {
  // Relative to A's centre, in world directions: far from the origin nothing is lost.
  const Vec3 half_a = 0.5 * length_a * pose_a.rotation.col(2), half_b = 0.5 * length_b * pose_b.rotation.col(2);
  const Vec3 between = pose_b.translation - pose_a.translation;
  SegmentDistance d;
  if (clear_segment_distance(half_a, between, half_b, d)) return d;
  return segment_distance(Vec3::Zero(), half_a, between, half_b);
}

/// Two boxes in canonical order whose face axes separate them by no more than the margin.
void append_near_boxes(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b,
                       const BoxAxes& axes, double margin, std::vector<Contact>& contacts, PairAnswer& r) {
  const BoxAnswer answer = box_box_overlap(half_a, pose_a, half_b, pose_b, axes, margin);
  if (answer.local.signed_distance <= margin) {
    append_boxes(half_a, pose_a, half_b, pose_b, answer, margin, contacts, r);
    return;
  }
  r.signed_distance = answer.local.signed_distance;
  r.normal = pose_a.rotation * answer.local.normal;
}

}  // namespace

void answer_by_deepest(std::span<const Contact> contacts, double signed_distance, PairAnswer& r) {
  const Contact* deepest = contacts.data();
  for (const Contact& c : contacts)
    if (c.depth > deepest->depth) deepest = &c;
  r.signed_distance = signed_distance;
  r.collide = true;
  r.normal = deepest->normal;
  r.point_a = deepest->point - 0.5 * r.signed_distance * r.normal;
  r.point_b = deepest->point + 0.5 * r.signed_distance * r.normal;
}

void append_boxes(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b,
                  const BoxAnswer& answer, double margin, std::vector<Contact>& contacts, PairAnswer& r) {
  const std::size_t first = contacts.size();
  if (answer.axis >= 0 && (answer.axis < 6 || answer.facing >= carries_patch)) {
    append_box_manifold(half_a, pose_a, half_b, pose_b, answer, margin, contacts);
    const bool flush = answer.axis < 6 || answer.facing > tolerance::flush_face;
    if (flush && answer.local.signed_distance <= 0 && contacts.size() > first) {
      answer_by_deepest(std::span(contacts).subspan(first), answer.local.signed_distance, r);
      return;
    }
  }
  place(answer.local, pose_a, r);
  if (contacts.size() > first) return;
  // Two edges that cross touch in one point.
  const bool edges_alone = answer.axis >= 6 && answer.edges_cosine <= clearly_crossing && answer.facing < carries_patch;
  const bool rounded_off = answer.axis >= 0 && (answer.axis < 6 || answer.facing > tolerance::flush_face);
  if (!edges_alone && !rounded_off)
    append_manifold(view_box(half_a), view_box(half_b), relative(pose_a, pose_b), answer.local, margin, pose_a,
                    contacts);
  // Rounding may remove the only point of a patch.
  if (contacts.size() == first) append_single(r, margin, &contacts);
}

PairAnswer solve_spheres(const Parameters& a, const Pose& pose_a, const Parameters& b, const Pose& pose_b,
                         Request request, double margin, std::vector<Contact>* contacts) {
  const double radius_a = a[0], radius_b = b[0];
  const Vec3 d = pose_b.translation - pose_a.translation;
  const double length2 = d.squaredNorm(), reach = radius_a + radius_b;
  PairAnswer r;
  if (request == Request::collide) {
    r.collide = within(length2, reach);
    return r;
  }
  const double length = std::sqrt(length2);
  r.normal = length > 0 ? unit(d, length) : Vec3(radius_a > radius_b ? -1.0 : 1.0, 0, 0);
  r.signed_distance = length - reach;
  r.point_a = pose_a.translation + radius_a * r.normal;
  r.point_b = pose_b.translation - radius_b * r.normal;
  // Separated by more than the margin: known without the square root.
  const double far = reach + margin;
  if (request == Request::contacts && length2 > far * far * (1 + tolerance::certain)) return r;
  r.collide = r.signed_distance <= 0;
  if (request == Request::contacts) append_single(r, margin, contacts);
  return r;
}

PairAnswer solve_sphere_box(const Parameters& a, const Pose& pose_a, const Parameters& b, const Pose& pose,
                            Request request, double margin, std::vector<Contact>* contacts) {
  const double radius = a[0], half[3] = {b[0], b[1], b[2]};
  const Vec3& centre = pose_a.translation;
  const Vec3 d = centre - pose.translation;
  Vec3 p, out;
  for (int i = 0; i < 3; ++i) {
    p[i] = pose.rotation.col(i).dot(d);
    out[i] = p[i] - std::clamp(p[i], -half[i], half[i]);
  }
  const double length2 = out.squaredNorm();
  PairAnswer r;
  if (request == Request::collide) {
    r.collide = within(length2, radius);
    return r;
  }
  double distance;  // of the centre
  Vec3 nearest;     // point of the box, relative to its centre in world directions
  if (length2 > 0) {
    distance = std::sqrt(length2);
    const Vec3 axis = pose.rotation * out;
    r.normal = -unit(axis, distance);
    nearest = d - axis;
  } else {
    int axis = 0;
    for (int i = 1; i < 3; ++i)
      if (half[i] - std::abs(p[i]) < half[axis] - std::abs(p[axis])) axis = i;
    distance = std::abs(p[axis]) - half[axis];
    r.normal = std::copysign(1.0, -p[axis]) * pose.rotation.col(axis);
    nearest = d + distance * r.normal;
  }
  r.signed_distance = distance - radius;
  r.collide = r.signed_distance <= 0;
  r.point_a = centre + radius * r.normal;
  r.point_b = pose.translation + nearest;
  if (request == Request::contacts) append_single(r, margin, contacts);
  return r;
}

PairAnswer solve_sphere_capsule(const Parameters& a, const Pose& pose_a, const Parameters& b, const Pose& pose,
                                Request request, double margin, std::vector<Contact>* contacts) {
  const double radius = a[0], capsule_radius = b[0], length = b[1];
  const Vec3& centre = pose_a.translation;
  const Vec3 d = centre - pose.translation, axis = pose.rotation.col(2);
  const double half = 0.5 * length, along = std::clamp(axis.dot(d), -half, half);
  Vec3 out = d - along * axis;
  // Beside the axis the normal is made perpendicular to it, despite rounding.
  if (std::abs(along) < half) out -= axis.dot(out) * axis;
  const double length2 = out.squaredNorm();
  PairAnswer r;
  if (request == Request::collide) {
    r.collide = within(length2, radius + capsule_radius);
    return r;
  }
  const double distance = std::sqrt(length2);
  r.normal = distance > 0 ? Vec3(-unit(out, distance)) : Vec3(-pose.rotation.col(0));
  r.signed_distance = distance - (radius + capsule_radius);
  r.collide = r.signed_distance <= 0;
  r.point_a = centre + radius * r.normal;
  r.point_b = pose.translation + (along * axis - capsule_radius * r.normal);
  if (request == Request::contacts) append_single(r, margin, contacts);
  return r;
}

PairAnswer solve_capsules(const Parameters& a, const Pose& pose_a, const Parameters& b, const Pose& pose_b,
                          Request request, double margin, std::vector<Contact>* contacts) {
  // Which comes first is unpredictable: no branch.
  struct Side {
    double radius, length;
    const Pose* pose;
  } const sides[2] = {{a[0], a[1], &pose_a}, {b[0], b[1], &pose_b}};
  const double parameters = a[0] != b[0] ? a[0] - b[0] : a[1] - b[1];
  const std::size_t first = reversed(parameters, pose_a, pose_b) ? 1 : 0, second = 1 - first;
  const Side &p = sides[first], &q = sides[second];
  const SegmentDistance s = axes_distance(*p.pose, p.length, *q.pose, q.length);
  PairAnswer r;
  const double signed_distance = s.distance - p.radius - q.radius;
  r.collide = signed_distance <= 0;
  if (request == Request::collide) return r;
  r.signed_distance = signed_distance;
  const double sign = first == 0 ? 1.0 : -1.0;
  r.normal = sign * s.normal;
  const Vec3 points[2] = {p.pose->translation + (s.point_a + p.radius * s.normal),
                          p.pose->translation + (s.point_b - q.radius * s.normal)};
  r.point_a = points[first];
  r.point_b = points[second];
  if (request != Request::contacts || contacts == nullptr || signed_distance > margin) return r;
  const std::size_t begin = contacts->size();
  if (!append_parallel_capsules(s, p.radius, p.length, *p.pose, q.radius, q.length, *q.pose, margin, *contacts)) {
    append_single(r, margin, contacts);
  } else {
    for (Contact& c : std::span(*contacts).subspan(begin)) c.normal = sign * c.normal;
  }
  return r;
}

namespace {

/// The answer along the face axis of largest separation of two boxes, which exceeds the margin.
void answer_apart(const BoxAxes& axes, const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b,
                  const Pose& pose_b, PairAnswer& r) {
  unsigned parting = axes.parting;
  // Faces of both separate equally: take that of the first box in canonical order.
  if (parting >= 16 && parting % 16 != 0) parting &= boxes_reversed(half_a, pose_a, half_b, pose_b) ? 0xf0u : 0x0fu;
  const auto face = static_cast<unsigned>(std::countr_zero(parting));
  const Pose* const poses[2] = {&pose_a, &pose_b};
  // Which side is unpredictable: no branch.
  constexpr double senses[2] = {1, -1};
  r.signed_distance = axes.most_face;
  r.normal = senses[axes.against >> face & 1u] * poses[face / 4]->rotation.col(face % 4);
}

/// Two boxes that no face axis separates by more than the margin, with their axes.
[[gnu::noinline]] void solve_near_boxes(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b,
                                        const Pose& pose_b, BoxAxes& axes, double margin,
                                        std::vector<Contact>& contacts, PairAnswer& r) {
  const std::size_t first = contacts.size();
  if (!boxes_reversed(half_a, pose_a, half_b, pose_b)) {
    append_near_boxes(half_a, pose_a, half_b, pose_b, axes, margin, contacts, r);
    return;
  }
  // The rounding of the edges' separations depends on the order.
  measure_axes(half_b.data(), &pose_b, half_a.data(), &pose_a, margin, &axes);
  append_near_boxes(half_b, pose_b, half_a, pose_a, axes, margin, contacts, r);
  swap_answer(r, &contacts, first);
}

}  // namespace

PairAnswer solve_boxes(const Parameters& half_a, const Pose& pose_a, const Parameters& half_b, const Pose& pose_b,
                       Request request, double margin, std::vector<Contact>* contacts) {
  PairAnswer r;
  if (request == Request::collide) {
    r.collide = box_box_collide(half_a, pose_a, half_b, pose_b);
  } else if (request == Request::contacts && contacts != nullptr) {
    BoxAxes axes;
    if (measure_axes(half_a.data(), &pose_a, half_b.data(), &pose_b, margin, &axes))
      answer_apart(axes, half_a, pose_a, half_b, pose_b, r);
    else
      solve_near_boxes(half_a, pose_a, half_b, pose_b, axes, margin, *contacts, r);
  } else if (boxes_reversed(half_a, pose_a, half_b, pose_b)) {
    place(box_box_distance(half_b, pose_b, half_a, pose_a).local, pose_b, r);
    swap_answer(r, nullptr, 0);
  } else {
    place(box_box_distance(half_a, pose_a, half_b, pose_b).local, pose_a, r);
  }
  return r;
}

PairAnswer solve_box_capsule(const Parameters& half, const Pose& pose_a, const Parameters& b, const Pose& pose_b,
                             Request request, double margin, std::vector<Contact>* contacts) {
  const double radius = b[0], length = b[1];
  const Vec3 d = pose_b.translation - pose_a.translation;
  Vec3 centre, along;
  for (int i = 0; i < 3; ++i) {
    centre[i] = pose_a.rotation.col(i).dot(d);
    along[i] = pose_a.rotation.col(i).dot(pose_b.rotation.col(2));
  }
  PairAnswer r;
  if (request == Request::collide) {
    r.collide = within(segment_box_distance2(half, centre, along, 0.5 * length), radius);
    return r;
  }
  LocalAnswer local = segment_box_distance(half, centre, along, 0.5 * length);
  local.signed_distance -= radius;
  local.point_b -= radius * local.normal;
  place(local, pose_a, r);
  if (request == Request::contacts && contacts != nullptr && r.signed_distance <= margin) {
    const ConvexView capsule{.kind = ShapeKind::capsule,
                             .param = {radius, length, 0, 0},
                             .vertices = {},
                             .hull = nullptr,
                             .size = std::sqrt(8 * radius * radius + (length + 2 * radius) * (length + 2 * radius))};
    append_manifold(view_box(half), capsule, relative(pose_a, pose_b), local, margin, pose_a, *contacts);
  }
  return r;
}

namespace {

/// The half-space's normal in the world.
Vec3 world_normal(const Parameters& halfspace, const Pose& pose) {
  return pose.rotation * Vec3(halfspace[0], halfspace[1], halfspace[2]);
}

}  // namespace

PairAnswer solve_halfspace_sphere(const Parameters& a, const Pose& pose_a, const Parameters& b, const Pose& pose_b,
                                  Request request, double margin, std::vector<Contact>* contacts) {
  const double offset = a[3], radius = b[0];
  PairAnswer r;
  r.normal = world_normal(a, pose_a);
  r.signed_distance = r.normal.dot(pose_b.translation - pose_a.translation) - offset - radius;
  r.collide = r.signed_distance <= 0;
  r.point_b = pose_b.translation - radius * r.normal;
  r.point_a = r.point_b - r.signed_distance * r.normal;
  if (request == Request::contacts) append_single(r, margin, contacts);
  return r;
}

PairAnswer solve_halfspace_box(const Parameters& a, const Pose& pose_a, const Parameters& half, const Pose& pose_b,
                               Request request, double margin, std::vector<Contact>* contacts) {
  PairAnswer r;
  r.normal = world_normal(a, pose_a);
  const double height = r.normal.dot(pose_b.translation - pose_a.translation) - a[3];
  Vec3 slope, lowest;
  for (int i = 0; i < 3; ++i) {
    slope[i] = pose_b.rotation.col(i).dot(r.normal);
    lowest[i] = std::copysign(half[static_cast<std::size_t>(i)], -slope[i]);
  }
  r.signed_distance = height + slope.dot(lowest);
  r.collide = r.signed_distance <= 0;
  r.point_b = pose_b * lowest;
  r.point_a = r.point_b - r.signed_distance * r.normal;
  if (request == Request::contacts && contacts != nullptr && r.signed_distance <= margin) {
    const std::size_t first = contacts->size();
    append_halfspace_box(half, pose_b, r.normal, slope, height, margin, *contacts);
    // Rounding may remove the only corner of a patch that just touches.
    if (contacts->size() == first) append_single(r, margin, contacts);
  }
  return r;
}

}  // namespace tandem
