// The depth of two meshes that collide: the policy of the search.
#include "meshes/mesh_depth.h"

#include <algorithm>
#include <cmath>

#include "manifold/manifold.h"
#include "meshes/contacts/mesh_contacts.h"
#include "meshes/depth/overlapping_meshes.h"
#include "meshes/depth/touching_meshes.h"
#include "meshes/mesh_as_convex.h"
#include "meshes/mesh_solvers.h"
#include "meshes/traversal/mesh_nearest.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

// The bound by the deepest of the pairs of triangles: no shorter translation separates even these.
Separation bound_by_triangles(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                              const NarrowPhaseOptions& options) {
  Separation deepest;
  deepest.certain = -infinity;
  WorkMeter meter(options.limit);
  for (const auto& [i, j] : pairs) {
    meter.spend(16);
    const Corners p = mesh_of(a.shape).corners(i), q = mesh_of(b.shape).corners(j);
    const PairAnswer r =
        solve_convex(TriangleView(p), a.pose, TriangleView(q), b.pose, Request::distance, options, nullptr);
    if (-r.signed_distance > deepest.certain && r.normal.norm() > 0.5)
      deepest = {-r.signed_distance, infinity, r.normal, (r.point_a + r.point_b) / 2};
  }
  deepest.certain = std::max(0.0, deepest.certain);
  return deepest;
}

// The bound for one inside the other: no separating translation is shorter than the distance of the nearest point of
// the surface.
Separation bound_by_surface(const Posed& a, const Posed& b, const NarrowPhaseOptions& options) {
  NearestSearch search(a, b, options.limit);
  Nearest near = search();
  // The inner one leaves through the nearest face of the other.
  const Vec3 out = -search.normal(options, near);
  return {near.distance, infinity, out, (near.on_a + near.on_b) / 2};
}

PairAnswer with_points(PairAnswer answer, const Vec3& middle) {
  answer.point_a = middle + answer.normal * (-answer.signed_distance / 2);
  answer.point_b = middle - answer.normal * (-answer.signed_distance / 2);
  return answer;
}

// The answer with the convex set that one bounds, if that translation is free; else inexact without bound.
PairAnswer depth_as_convex(const Posed& a, const Posed& b, const OverlappingMeshes& overlap,
                           const NarrowPhaseOptions& options) {
  PairAnswer none;
  none.status = Status::inexact;
  none.error_bound = infinity;
  if (!bounds_convex(a, options.limit) && !bounds_convex(b, options.limit)) return none;
  const PairAnswer convex = overlap_as_convex(a, b, Request::distance, options, nullptr);
  const double depth = -convex.signed_distance;
  // For two that only touch, rounding may separate the convex one although it is wedged in.
  constexpr double near = 8;
  const auto is_free_near = [&](const Vec3& end) {
    const auto off = overlap.off_triangles(end);
    return off && (*off - end).norm() <= near * overlap.enough;
  };
  const bool separates =
      holds_as_convex(a, b, depth, options.limit) &&
      (overlap.is_free((overlap.enough + depth) * convex.normal) || is_free_near(depth * convex.normal));
  return separates ? convex : none;
}

// The bounds of two searches hold together. A lower one that exceeds a translation that separates by more than rounding
// would be wrong, and is not taken.
void join_bounds(const PairAnswer& other, double rounding, Separation& known) {
  const double length = -other.signed_distance, certain = length - other.error_bound;
  if (length < known.length) known = {known.certain, length, other.normal, (other.point_a + other.point_b) / 2};
  if (certain <= known.length + rounding) known.certain = std::min(known.length, std::max(known.certain, certain));
}

// A direction that separates the hulls separates the meshes.
void separate_hulls(const Posed& a, const Posed& b, const NarrowPhaseOptions& options, Separation& known) {
  const PairAnswer hulls = solve_convex(view_hull(a.shape, options.limit), a.pose, view_hull(b.shape, options.limit),
                                        b.pose, Request::distance, options, nullptr);
  const double length = std::max(0.0, -hulls.signed_distance);
  if (length < known.length) known = {known.certain, length, hulls.normal, (hulls.point_a + hulls.point_b) / 2};
}

// Tries the translation that all contacts together require, and the normal of each patch.
void separate_contacts(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                       const NarrowPhaseOptions& options, double slack, SeparationSearch& search) {
  constexpr std::size_t most = 48;
  std::vector<Contact> contacts;
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  TriangleTest test(a.pose, b.pose, reach(mb));
  if (!pairs.empty()) patch_contacts(ma, mb, test, pairs, options, contacts);
  for (Contact& c : contacts) c.normal = (a.pose.rotation * c.normal).normalized();
  std::vector<Constraint> together;
  for (const Contact& c : contacts)
    if (together.size() < most && c.depth > 0) together.push_back({c.normal, c.depth + slack});
  search.beyond(together);
  for (auto at = contacts.begin(); at != contacts.end(); ++at)
    if (std::none_of(contacts.begin(), at, [&](const Contact& o) { return o.normal.dot(at->normal) > one_patch; }))
      search.along(at->normal);
}

// An upper bound on the distance of a point (in the world) from a mesh; < 0 inside a solid: minus the radius of a ball
// about it inside the mesh.
double distance_of_point(const Posed& mesh, const Vec3& point, const NarrowPhaseOptions& options) {
  const Shape ball(Sphere{0});
  const Pose at{Mat3::Identity(), point};
  const PairAnswer r = solve_mesh_convex(mesh, {ball, at}, Request::distance, options, nullptr);
  return mesh_of(mesh.shape).solid ? r.signed_distance + r.error_bound : std::max(0.0, r.signed_distance);
}

// A lower bound on the length of translations that separate two colliding meshes: the deepest of some intersecting
// triangles, and by how much balls about a point, in the one and in the other, exceed its distance outside of either.
double certain_depth(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                     std::span<const Contact> contacts, const NarrowPhaseOptions& options) {
  constexpr std::size_t most_pairs = 32;  // whose depth is examined: each takes as long as a distance of triangles
  double certain = bound_by_triangles(a, b, pairs.first(std::min(pairs.size(), most_pairs)), options).certain;
  for (const Contact& c : contacts) {
    if (!(c.depth > certain)) continue;
    // On A's surface, on B's, and midway, except for contacts that were moved along a face.
    for (const double side : {0.5, -0.5, 0.0}) {
      const Vec3 point = c.point + side * c.depth * c.normal;
      certain = std::max(certain, -distance_of_point(a, point, options) - distance_of_point(b, point, options));
    }
  }
  return certain;
}

// True if one direction pushes all contacts. Several directions, such as those of a floor and a wall, separate only
// together.
bool has_one_normal(std::span<const Contact> contacts) {
  return std::all_of(contacts.begin(), contacts.end(),
                     [&](const Contact& c) { return c.normal.dot(contacts.front().normal) > one_patch; });
}

// Midway between the points of the meshes that separate last; the witnesses of the hulls, or of the deepest triangles,
// are those of another direction. A's translation is zero.
Vec3 point_of_last_touch(const Posed& a, const Posed& b, const Separation& known, double size,
                         const NarrowPhaseOptions& options) {
  const Pose apart{b.pose.rotation, b.pose.translation + (known.length + tolerance::least_apart * size) * known.normal};
  return NearestSearch(a, {b.shape, apart}, options.limit)().on_a - known.normal * (known.length / 2);
}

// The answer for two meshes that only touch, if a translation of about the rounding error `slack` separates them: its
// length is the depth. No translation shorter than `certain` separates.
bool only_touch(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs, double slack, double certain,
                const NarrowPhaseOptions& options, PairAnswer& answer) {
  if (pairs.empty()) return false;
  const auto by = separating_translation(a, b, pairs, certain, slack, options);
  if (!by) return false;
  const double length = by->norm();
  answer = {};
  answer.collide = true;
  answer.normal = *by / length;
  answer.signed_distance = -length;
  answer = with_points(answer, bound_by_triangles(a, b, pairs.first(1), options).point);
  if (length > certain + slack) answer.status = Status::inexact, answer.error_bound = length - certain;
  return true;
}

// The same pair about A's translation: far from the origin, those of moved bodies would be rounded.
struct AboutA {
  AboutA(const Posed& a, const Posed& b)
      : shape_a(a.shape),
        shape_b(b.shape),
        pose_a{a.pose.rotation, Vec3::Zero()},
        pose_b{b.pose.rotation, b.pose.translation - a.pose.translation} {}
  Posed a() const { return {shape_a, pose_a}; }
  Posed b() const { return {shape_b, pose_b}; }
  bool collide_moved(const Vec3& move, const WorkLimit* limit) const {
    const Pose moved{pose_b.rotation, pose_b.translation + move};
    return meshes_collide(a(), {shape_b, moved}, limit);
  }

  const Shape &shape_a, &shape_b;
  const Pose pose_a, pose_b;
};

// A's translation is zero.
PairAnswer depth_about_a(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                         const NarrowPhaseOptions& options) {
  constexpr std::size_t small_meshes = std::size_t{1} << 18;  // product of the numbers of triangles
  const Separation bound = pairs.empty() ? bound_by_surface(a, b, options) : bound_by_triangles(a, b, pairs, options);
  OverlappingMeshes overlap(a, b, pairs, options);
  // Of those that only touch a single pair of triangles may have any direction.
  PairAnswer touch;
  const bool touching = only_touch(a, b, pairs, overlap.enough, bound.certain, options, touch);
  const Vec3& out = touching && touch.status == Status::ok ? touch.normal : bound.normal;
  if (overlap.is_free((bound.certain + overlap.enough) * out)) {
    PairAnswer answer;
    answer.collide = true;
    answer.signed_distance = -bound.certain;
    answer.normal = out;
    return with_points(answer, bound.point);
  }
  if (touching) return touch;
  SeparationSearch search(overlap, {.certain = bound.certain});
  Separation& known = search.known;
  search.beyond_obstacles();
  if (!search.is_shortest())
    if (const auto off = overlap.off_triangles(Vec3::Zero()); off && off->norm() < known.length) {
      search.take(*off);
      known.point = point_of_last_touch(a, b, known, overlap.size, options);
    }
  known.certain = std::min(known.certain, known.length);  // because of rounding a sliver's depth may be larger
  if (!search.is_shortest()) {
    const PairAnswer convex = depth_as_convex(a, b, overlap, options);
    if (convex.status == Status::ok) return convex;
    separate_hulls(a, b, options, known);
    search.along(bound.normal);
    // Small meshes are worth more work.
    if (mesh_of(a.shape).triangles.size() * mesh_of(b.shape).triangles.size() <= small_meshes) {
      separate_contacts(a, b, pairs, options, overlap.slack, search);
      search.shorten();
      search.confirm();
    }
    known.point = point_of_last_touch(a, b, known, overlap.size, options);
    if (std::isfinite(convex.error_bound)) join_bounds(convex, overlap.enough, known);
  }
  return with_points(search.answer(), known.point);
}

// If two meshes only touch, along several faces at once, the patches do not bound an overlap: contacts deeper than the
// touch are removed, and one replaces them unless the deepest of the others separates.
bool take_touch(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs, double slack,
                const NarrowPhaseOptions& options, std::size_t first, std::vector<Contact>& contacts,
                PairAnswer& answer) {
  const AboutA about(a, b);
  PairAnswer touch;
  if (!only_touch(about.a(), about.b(), pairs, slack, 0, for_triangles(options), touch)) return false;
  move_answer(a.pose.translation, touch, nullptr, 0);
  const double depth = -touch.signed_distance;
  const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
  contacts.erase(std::remove_if(begin, contacts.end(), [&](const Contact& c) { return c.depth > depth; }),
                 contacts.end());
  const auto left = std::span(contacts).subspan(first);
  const auto deepest =
      std::max_element(left.begin(), left.end(), [](const Contact& x, const Contact& y) { return x.depth < y.depth; });
  const auto separates = [&](const Contact& c) {
    return c.depth >= 0 && !about.collide_moved((c.depth + slack) * c.normal, options.limit);
  };
  if (deepest == left.end() || !separates(*deepest)) contacts.push_back(contact_of(touch, of_no_feature));
  answer = from_deepest(contacts, first);
  answer.collide = true;
  answer.status = touch.status;
  answer.error_bound = touch.error_bound;
  return true;
}

// Contacts as deep as a body is wide may lead along a face that the other only touches: those deeper than a translation
// that separates are left out, and one replaces them if none remains. In a slot exactly as wide as the body there is no
// such translation: then those deeper than its triangles.
void leave_out_deeper(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                      const NarrowPhaseOptions& options, double slack, std::size_t first,
                      std::vector<Contact>& contacts) {
  constexpr double deep = 0.25;  // of the smaller body's size
  const double depth = -from_deepest(contacts, first).signed_distance;
  if (!(depth > deep * std::min(a.shape.size(), b.shape.size()))) return;
  if (pairs.empty() || pairs.size() > OverlappingMeshes::few_pairs) return;
  const AboutA about(a, b);
  const OverlappingMeshes overlap(about.a(), about.b(), pairs, options);
  Separation known = bound_by_triangles(about.a(), about.b(), pairs, options);
  known.length = known.certain;
  if (const auto off = overlap.off_triangles(Vec3::Zero())) {
    known.length = off->norm(), known.normal = *off / known.length;
    known.point = point_of_last_touch(about.a(), about.b(), known, overlap.size, options);
  } else if (known.certain > slack) {
    return;
  }
  const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
  contacts.erase(
      std::remove_if(begin, contacts.end(), [&](const Contact& c) { return c.depth > known.length + slack; }),
      contacts.end());
  if (contacts.size() == first)
    contacts.push_back({known.point + a.pose.translation, known.normal, known.length, of_no_feature});
}

}  // namespace

PairAnswer depth_of_meshes(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                           const NarrowPhaseOptions& options) {
  const AboutA about(a, b);
  PairAnswer answer = depth_about_a(about.a(), about.b(), pairs, for_triangles(options));
  move_answer(a.pose.translation, answer, nullptr, 0);
  return answer;
}

PairAnswer bounded_contacts(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                            const NarrowPhaseOptions& options, std::size_t first, std::vector<Contact>& contacts) {
  // Of triangles that are hardly larger than the rounding of their places no patch may be left.
  if (contacts.size() == first)
    contacts.push_back(contact_of(solve_meshes(a, b, Request::distance, options, nullptr), of_no_feature));
  const double slack = tolerance::translation_slack * (a.shape.size() + b.shape.size());
  leave_out_deeper(a, b, pairs, for_triangles(options), slack, first, contacts);
  PairAnswer answer = from_deepest(contacts, first);
  answer.collide = true;
  const double depth = -answer.signed_distance;
  if (depth > slack && take_touch(a, b, pairs, slack, options, first, contacts, answer)) return answer;
  if (!options.mesh_bounds) {
    answer.status = Status::unproven;
    return answer;
  }
  const auto found = [&] { return std::span(contacts).subspan(first); };
  double shortest = depth, certain = 0;  // the true depth lies between
  const bool separates = !AboutA(a, b).collide_moved((depth + slack) * answer.normal, options.limit);
  if (separates) {
    certain = certain_depth(a, b, pairs, found(), for_triangles(options));
  } else {
    const PairAnswer out = solve_meshes(a, b, Request::distance, options, nullptr);
    shortest = -out.signed_distance;
    certain = shortest - out.error_bound;
    if (depth > shortest + slack || (certain > depth + slack && has_one_normal(found()))) {
      const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
      contacts.erase(std::remove_if(begin, contacts.end(), [&](const Contact& c) { return c.depth >= shortest; }),
                     contacts.end());
      contacts.push_back(contact_of(out, of_no_feature));
      return out;
    }
  }
  const double off = std::max(depth - certain, shortest - depth);
  if (off > slack || !separates) {
    answer.status = Status::inexact;
    answer.error_bound = std::max(off, slack);
  }
  return answer;
}

}  // namespace tandem
