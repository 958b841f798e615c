#include "mesh_pair.h"

#include <algorithm>

#include "centre_test.h"
#include "constants.h"
#include "mesh_model.h"
#include "solvers.h"

namespace tandem {
namespace {

// Largest d . x over the posed shape.
double support(const Posed& s, const Vec3& d) {
  if (has_triangles(s.shape)) {
    const MeshModel& mesh = s.shape.mesh();
    const Vec3 local = s.pose.rotation.transpose() * d;
    double most = -infinity;
    for (const std::uint32_t v : mesh.extreme) most = std::max(most, local.dot(mesh.vertices[v]));
    return most + d.dot(s.pose.translation);
  }
  Mat3 turn;  // d becomes the x axis
  const Vec3 u = d.unitOrthogonal();
  turn << d.transpose(), u.transpose(), d.cross(u).transpose();
  return s.shape.bounds({turn * s.pose.rotation, turn * s.pose.translation}).hi.x();
}

// A has triangles.
PairAnswer solve_with_mesh_first(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                                 std::vector<Contact>* contacts) {
  if (has_triangles(b.shape)) return solve_meshes(a, b, request, options, contacts);
  if (b.shape.kind() == ShapeKind::halfspace) return solve_mesh_halfspace(a, b, request, options, contacts);
  return solve_mesh_convex(a, b, request, options, contacts);
}

}  // namespace

bool goes_first(const Posed& a, const Posed& b) {
  const MeshModel &ma = a.shape.mesh(), &mb = b.shape.mesh();
  if (ma.unit != mb.unit) return ma.unit > mb.unit;
  if (ma.triangles.size() != mb.triangles.size()) return ma.triangles.size() > mb.triangles.size();
  const auto before = [](const auto& x, const auto& y) {
    return std::lexicographical_compare(x.data(), x.data() + x.size(), y.data(), y.data() + y.size());
  };
  const Pose &pa = a.pose, &pb = b.pose;
  if (pa.translation != pb.translation) return before(pa.translation, pb.translation);
  if (pa.rotation != pb.rotation) return before(pa.rotation, pb.rotation);
  return !std::lexicographical_compare(mb.vertices.begin(), mb.vertices.end(), ma.vertices.begin(), ma.vertices.end(),
                                       before);
}

ConvexView view_hull(const Shape& mesh) {
  const Hull& hull = mesh.mesh().hull;
  return {.kind = ShapeKind::convex, .param = {}, .vertices = hull.vertices, .hull = &hull, .size = mesh.size()};
}

NarrowPhaseOptions for_triangles(const NarrowPhaseOptions& options) {
  NarrowPhaseOptions o = options;
  o.solver.clear();  // the name was that of a solver for meshes
  return o;
}

PairAnswer with_depth(const Posed& a, const Posed& b, const DepthBound& d, bool solid,
                      const std::function<bool(const Vec3&)>& collide_moved) {
  PairAnswer answer;
  answer.collide = true;
  answer.normal = d.normal;
  const double size = a.shape.size() + b.shape.size();
  double certain = d.certain, separates = certain + 1e-12 * size;
  if (collide_moved(Vec3(d.normal * separates))) {
    const Vec3 t = b.pose.translation - a.pose.translation;
    const Pose at_a{a.pose.rotation, Vec3::Zero()}, at_b{b.pose.rotation, t};
    separates = support({a.shape, at_a}, d.normal) + support({b.shape, at_b}, -d.normal);
    separates = std::max(separates, certain) + 1e-12 * size;
    double blocked = certain;
    for (int i = 0; i < 16; ++i) {
      const double middle = (blocked + separates) / 2;
      (collide_moved(Vec3(d.normal * middle)) ? blocked : separates) = middle;
    }
    answer.status = Status::inexact;
    answer.error_bound = separates - certain;
    if (solid) certain = separates;
  }
  answer.signed_distance = -certain;
  answer.point_a = d.point + d.normal * (certain / 2);
  answer.point_b = d.point - d.normal * (certain / 2);
  return answer;
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
  if (request != Request::distance && has_triangles(a) && has_triangles(b))
    if (const MeshGap gap = test_hulls(a, pose_a, b, pose_b); gap.at_least > 0) {
      PairAnswer apart;
      if (request == Request::contacts) apart.signed_distance = gap.at_least, apart.normal = gap.normal;
      return apart;
    }
  const Posed first{a, pose_a}, second{b, pose_b};
  const bool in_order = has_triangles(a) && (!has_triangles(b) || goes_first(first, second));
  if (in_order) return solve_with_mesh_first(first, second, request, options, contacts);
  const std::size_t begin = contacts ? contacts->size() : 0;
  PairAnswer answer = solve_with_mesh_first(second, first, request, options, contacts);
  swap_answer(answer, contacts, begin);
  return answer;
}

}  // namespace tandem
