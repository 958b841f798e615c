#include "meshes/mesh_pair.h"

#include <algorithm>

#include "manifold/manifold.h"
#include "pairs/centre_test.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
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

// Is a mesh by its hull farther than the margin from a bounded convex shape? Nothing more is asked then. The hull of an
// open one, a terrain, is not made for that: it takes longer than a query.
bool is_clear_of_hull(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      double margin, const WorkLimit* limit) {
  const bool first = a.kind() == ShapeKind::mesh;
  const Shape &mesh = first ? a : b, &other = first ? b : a;
  if (!mesh_of(mesh).closed && !mesh_of(mesh).is_hull_made()) return false;
  if (request == Request::distance || has_triangles(other) || !other.is_bounded()) return false;
  const double gap = first ? test_hull(a, pose_a, b, pose_b, limit) : test_hull(b, pose_b, a, pose_a, limit);
  return gap > margin + tolerance::alike * (a.size() + b.size());
}

}  // namespace

bool goes_first(const Posed& a, const Posed& b) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  // One that is a point has a unit that does not grow with it.
  const auto unit = [](const MeshModel& m) { return m.half.isZero(0) ? 0 : m.unit; };
  if (unit(ma) != unit(mb)) return unit(ma) > unit(mb);
  if (ma.triangles.size() != mb.triangles.size()) return ma.triangles.size() > mb.triangles.size();
  const auto before = [](const auto& x, const auto& y) {
    return std::lexicographical_compare(x.data(), x.data() + x.size(), y.data(), y.data() + y.size());
  };
  // Where each lies as seen from the other, which neither a common motion nor the order of vertices changes, along
  // directions of no shape.
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

NarrowPhaseOptions for_triangles(const NarrowPhaseOptions& options) {
  NarrowPhaseOptions o = options;
  o.solver.clear();  // the name was that of a solver for meshes
  return o;
}

PairAnswer from_deepest(const std::vector<Contact>& contacts, std::size_t first) {
  PairAnswer answer;
  const Contact* deepest = nullptr;
  for (std::size_t i = first; i < contacts.size(); ++i)
    if (!deepest || contacts[i].depth > deepest->depth) deepest = &contacts[i];
  if (!deepest) return answer;
  answer.collide = deepest->depth >= 0;
  answer.signed_distance = -deepest->depth;
  answer.normal = deepest->normal;
  answer.point_a = deepest->point + deepest->normal * (deepest->depth / 2);
  answer.point_b = deepest->point - deepest->normal * (deepest->depth / 2);
  return answer;
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
  const bool in_order = has_triangles(a) && (!has_triangles(b) || goes_first(first, second));
  if (in_order) return solve_with_mesh_first(first, second, request, options, contacts);
  const std::size_t begin = contacts ? contacts->size() : 0;
  PairAnswer answer = solve_with_mesh_first(second, first, request, options, contacts);
  swap_answer(answer, contacts, begin);
  return answer;
}

}  // namespace tandem
