// A mesh with any other shape: roles and policy.
#include "meshes/mesh_pair.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>

#include "manifold/manifold.h"
#include "meshes/contacts/gap_contacts.h"
#include "meshes/contacts/mesh_contacts.h"
#include "meshes/mesh_as_convex.h"
#include "meshes/mesh_depth.h"
#include "meshes/mesh_solvers.h"
#include "meshes/traversal/inner_capsule.h"
#include "meshes/traversal/meeting_pairs.h"
#include "meshes/traversal/mesh_nearest.h"
#include "pairs/centre_test.h"
#include "pairs/convex_pair.h"
#include "shapes/lent_memory.h"
#include "shapes/mesh_model.h"
#include "shapes/metered_sort.h"
#include "shapes/pair_order.h"
#include "shapes/shape_insides.h"
#include "tolerances.h"

namespace tandem {
namespace {

// A has triangles.
PairAnswer solve_with_mesh_first(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                                 std::vector<Contact>* contacts) {
  if (has_triangles(b.shape)) return solve_meshes(a, b, request, options, contacts);
  if (b.shape.kind() == ShapeKind::halfspace) return solve_mesh_halfspace(a, {a.pose, b}, request, options, contacts);
  if (b.shape.kind() == ShapeKind::plane) return solve_mesh_plane(a, {a.pose, b}, request, options, contacts);
  return solve_mesh_convex(a, b, request, options, contacts);
}

// True if the hull of a mesh is farther than the margin from a bounded convex shape; nothing more is needed then. The
// hull of an open mesh such as a terrain is not built for that: it takes longer than a query.
bool is_clear_of_hull(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      double margin, const WorkLimit* limit) {
  const bool first = a.kind() == ShapeKind::mesh;
  const Shape &mesh = first ? a : b, &other = first ? b : a;
  if (!mesh_of(mesh).closed && !mesh_of(mesh).is_hull_made()) return false;
  if (request == Request::distance || has_triangles(other) || !other.is_bounded()) return false;
  const double gap = first ? test_hull(a, pose_a, b, pose_b, limit) : test_hull(b, pose_b, a, pose_a, limit);
  return gap > margin + tolerance::alike * (a.size() + b.size());
}

// True: the two intersect, by the capsule inside a solid mesh; false: not known.
bool known_to_meet(const Posed& a, const Posed& b) {
  const bool first = a.shape.kind() == ShapeKind::mesh;
  const Posed &mesh = first ? a : b, &other = first ? b : a;
  return other.shape.is_bounded() && other.shape.kind() != ShapeKind::triangle && meets_inner_capsule(mesh, other);
}

// Two meshes whose triangles `pairs` intersect, or of which one is inside the other; pairs refer to A's frame.
struct Collision {
  const Posed &a, &b;
  const TriangleTest& test;
  std::span<const TrianglePair> pairs;
  const NarrowPhaseOptions& options;

  const MeshModel& mesh_a() const { return mesh_of(a.shape); }
  const MeshModel& mesh_b() const { return mesh_of(b.shape); }
  PatchSides add_patches(std::vector<Contact>& contacts) const {
    return patch_contacts(mesh_a(), mesh_b(), test, pairs, options, contacts);
  }
  // If the normals of the patches are in doubt, those of surfaces that only touch replace them.
  void take_touch(const PatchSides& sides, std::size_t first, std::vector<Contact>& contacts) const {
    if (!sides.sure) touching_contacts(a, b, test, pairs, options, first, contacts);
  }
};

// They do not touch, exactly: the distance must not be 0.
double no_touch(double distance) { return std::max(distance, std::numeric_limits<double>::min()); }

PairAnswer distance_apart(const Posed& a, const Posed& b, const NarrowPhaseOptions& options) {
  NearestSearch search(a, b, options.limit);
  Nearest near = search(options.cutoff);
  PairAnswer answer;
  answer.signed_distance = no_touch(near.distance);
  if (std::isinf(near.distance)) return answer;
  answer.normal = search.normal(for_triangles(options), near);
  answer.point_a = near.on_a + a.pose.translation;
  answer.point_b = near.on_b + a.pose.translation;
  return answer;
}

// The contacts of two meshes that do not intersect; `gap` is null if it is not needed.
PairAnswer contacts_apart(const Posed& a, const Posed& b, const TriangleTest& test, const GapBound* gap,
                          const NarrowPhaseOptions& options, std::vector<Contact>& contacts) {
  const std::size_t first = contacts.size();
  const double least = gap != nullptr ? gap_of(mesh_of(a.shape), mesh_of(b.shape), test, *gap) : 0;
  PairAnswer answer;
  if (options.margin > 0 && (a.shape.is_convex() || b.shape.is_convex())) {
    answer = solve_as_convex(a, b, Request::contacts, options, &contacts);
    // A contact by rounding is a small distance.
    for (Contact& c : std::span(contacts).subspan(first)) c.depth = -no_touch(-c.depth);
    answer.signed_distance = no_touch(answer.signed_distance);
    answer.collide = false;
  } else if (options.mesh_margin && options.margin > least) {
    answer = gap_contacts(a, b, {}, options, contacts);
  }
  if (contacts.size() == first) answer.signed_distance = least;
  return answer;
}

// The contacts of their hulls, unless these hardly touch and are separated by rounding: then false, without contacts.
bool contacts_of_hulls(const Collision& c, PairAnswer& answer, std::vector<Contact>& contacts) {
  if (!c.mesh_a().own_hull(c.options.limit) || !c.mesh_b().own_hull(c.options.limit)) return false;
  const std::size_t first = contacts.size();
  answer = overlap_of_hulls(c.a, c.b, Request::contacts, c.options, &contacts);
  if (contacts.size() > first && holds_as_hulls(c.a, c.b, -answer.signed_distance, c.options.limit)) return true;
  contacts.resize(first);
  return false;
}

// The contacts with the convex set that one bounds; false, with the contacts of their patches, if that set does not
// represent it.
bool contacts_as_convex(const Collision& c, PairAnswer& answer, PatchSides& sides, std::vector<Contact>& contacts) {
  const std::size_t first = contacts.size();
  answer = overlap_as_convex(c.a, c.b, Request::contacts, c.options, &contacts);
  if (contacts.size() == first) return false;
  if (holds_as_convex(c.a, c.b, -answer.signed_distance, c.options.limit)) return true;
  contacts.resize(first);
  sides = c.add_patches(contacts);
  c.take_touch(sides, first, contacts);
  // The translation through the surface into its interior may be shorter.
  const PairAnswer shortest = solve_meshes(c.a, c.b, Request::distance, c.options, nullptr);
  const double slack = tolerance::translation_slack * (c.a.shape.size() + c.b.shape.size());
  if (shortest.status != Status::ok ||
      !(from_deepest(contacts, first).signed_distance < shortest.signed_distance - slack))
    return false;
  contacts.resize(first);
  contacts.push_back(contact_of(shortest));
  answer = shortest;
  return true;
}

PairAnswer contacts_of_collision(const Collision& c, std::vector<Contact>& contacts) {
  const std::size_t first = contacts.size();
  PairAnswer answer;
  for (const MeshModel* mesh : {&c.mesh_a(), &c.mesh_b()})
    mesh->neighbours(c.options.limit);  // needed in the following
  if (contacts_of_hulls(c, answer, contacts)) return answer;
  // The orientation of a single triangle, or of a surface with a border, is meaningless: it has no interior.
  const bool has_convex = bounds_convex(c.a, c.options.limit) || bounds_convex(c.b, c.options.limit);
  PatchSides sides;
  if (!has_convex || (c.mesh_a().closed && c.mesh_b().closed)) sides = c.add_patches(contacts);
  if (has_convex && (!sides.sure || sides.in_corner)) {
    contacts.resize(first);
    if (contacts_as_convex(c, answer, sides, contacts)) return answer;
  }
  c.take_touch(sides, first, contacts);
  for (Contact& contact : std::span(contacts).subspan(first)) {
    contact.point = c.a.pose * contact.point;
    contact.normal = (c.a.pose.rotation * contact.normal).normalized();
  }
  return bounded_contacts(c.a, c.b, c.pairs, c.options, first, contacts);
}

PairAnswer distance_of_collision(const Collision& c) {
  if (c.a.shape.is_convex() || c.b.shape.is_convex()) {
    const PairAnswer convex = solve_as_convex(c.a, c.b, Request::distance, c.options, nullptr);
    // Where rounding parts what touches, the nearest triangle's direction may lead into another one.
    if (convex.collide) return convex;
    return depth_of_meshes(c.a, c.b, c.pairs, c.options);
  }
  if (c.mesh_a().own_hull(c.options.limit) && c.mesh_b().own_hull(c.options.limit)) {
    const PairAnswer hulls = overlap_of_hulls(c.a, c.b, Request::distance, c.options, nullptr);
    if (holds_as_hulls(c.a, c.b, -hulls.signed_distance, c.options.limit)) return hulls;
  }
  return depth_of_meshes(c.a, c.b, c.pairs, c.options);
}

}  // namespace

bool goes_first(const Posed& a, const Posed& b) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  // A mesh that is a point has a unit that does not scale with it.
  const auto unit = [](const MeshModel& m) { return m.half.isZero(0) ? 0 : m.unit; };
  if (unit(ma) != unit(mb)) return unit(ma) > unit(mb);
  if (ma.triangles.size() != mb.triangles.size()) return ma.triangles.size() > mb.triangles.size();
  const auto before = [](const auto& x, const auto& y) {
    return std::lexicographical_compare(x.data(), x.data() + x.size(), y.data(), y.data() + y.size());
  };
  // The relative positions, which depend neither on a common motion nor on the order of vertices, along generic
  // directions.
  const Pose &pa = a.pose, &pb = b.pose;
  const Vec3 between = pb.translation - pa.translation, g(0.3613, 0.4789, 0.8001), h(0.8171, -0.5471, 0.1829);
  const double b_of_a = g.dot(pa.rotation.transpose() * between), a_of_b = -g.dot(pb.rotation.transpose() * between);
  if (std::abs(b_of_a - a_of_b) > tolerance::alike * (a.shape.size() + b.shape.size())) return b_of_a > a_of_b;
  const double turn = (pa.rotation * g).dot(pb.rotation * h), back = (pb.rotation * g).dot(pa.rotation * h);
  if (std::abs(turn - back) > tolerance::alike) return turn > back;
  if (pa.translation != pb.translation) return before(pa.translation, pb.translation);
  if (pa.rotation != pb.rotation) return before(pa.rotation, pb.rotation);
  if (&ma == &mb) return true;
  return !std::lexicographical_compare(mb.vertices.begin(), mb.vertices.end(), ma.vertices.begin(), ma.vertices.end(),
                                       before);
}

PairAnswer solve_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      const NarrowPhaseOptions& options, std::vector<Contact>* contacts) {
  const bool has_margin = options.mesh_margin || a.is_convex() || b.is_convex();
  const double margin = request == Request::contacts && has_margin ? options.margin : 0;
  if (request != Request::distance && has_triangles(a) && has_triangles(b))
    if (const MeshGap gap = test_hulls(a, pose_a, b, pose_b, options.limit); gap.at_least > margin) {
      PairAnswer apart;
      if (request == Request::contacts) apart.signed_distance = gap.at_least, apart.normal = gap.normal;
      return apart;
    }
  if (is_clear_of_hull(a, pose_a, b, pose_b, request, margin, options.limit)) return {};
  const Posed first{a, pose_a}, second{b, pose_b};
  if (request == Request::collide && known_to_meet(first, second)) {
    PairAnswer meet;
    meet.collide = true;
    return meet;
  }
  const bool in_order = has_triangles(a) && (!has_triangles(b) || goes_first(first, second));
  if (in_order) return solve_with_mesh_first(first, second, request, options, contacts);
  const std::size_t begin = contacts ? contacts->size() : 0;
  PairAnswer answer = solve_with_mesh_first(second, first, request, options, contacts);
  swap_answer(answer, contacts, begin);
  return answer;
}

PairAnswer solve_meshes(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                        std::vector<Contact>* contacts) {
  if (request == Request::collide) {
    PairAnswer answer;
    answer.collide = meshes_collide(a, b, options.limit);
    return answer;
  }
  TriangleTest test(a.pose, b.pose, reach(mesh_of(b.shape)));
  PairMemory memory(lent_memory(options));
  GapBound bound;
  GapBound* gap = request == Request::contacts && (options.mesh_gaps || (options.mesh_margin && options.margin > 0))
                      ? &bound
                      : nullptr;
  const TrianglePairs pairs = meeting_pairs(a, b, test, options, memory, gap);
  const bool collide = !pairs.empty() || is_contained(a, b, options.limit);
  const Collision collision{a, b, test, pairs, options};
  if (request == Request::contacts)
    return collide ? contacts_of_collision(collision, *contacts) : contacts_apart(a, b, test, gap, options, *contacts);
  return collide ? distance_of_collision(collision) : distance_apart(a, b, options);
}

std::vector<std::array<std::uint32_t, 2>> mesh_triangle_pairs(const Shape& a, const Pose& pose_a, const Shape& b,
                                                              const Pose& pose_b, const NarrowPhaseOptions& options) {
  if (test_hulls(a, pose_a, b, pose_b, options.limit).at_least > 0) return {};
  const Posed first{a, pose_a}, second{b, pose_b};
  const bool in_order = goes_first(first, second);
  const Posed &p = in_order ? first : second, &q = in_order ? second : first;
  TriangleTest test(p.pose, q.pose, reach(mesh_of(q.shape)));
  PairMemory memory(lent_memory(options));
  const TrianglePairs found = meeting_pairs(p, q, test, options, memory, nullptr);
  std::vector<std::array<std::uint32_t, 2>> pairs;
  pairs.reserve(found.size());
  WorkMeter meter(options.limit);
  for (const auto& [i, j] : found) {
    meter.spend();
    pairs.push_back(in_order ? TrianglePair{i, j} : TrianglePair{j, i});
  }
  if (!in_order) sort_metered(meter, pairs.begin(), pairs.end(), std::less<TrianglePair>());
  return pairs;
}

}  // namespace tandem
