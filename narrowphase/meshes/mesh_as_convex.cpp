// Meshes that bound a convex set, solved as that set.
#include "meshes/mesh_as_convex.h"

#include <algorithm>

#include "meshes/mesh_solvers.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/pair_order.h"
#include "shapes/shape_insides.h"
#include "shapes/work_meter.h"

namespace tandem {
namespace {

// Chooses the shape that is replaced by the convex set that it bounds: a triangle before a mesh, a solid before a
// surface, otherwise the second, which is no larger.
bool first_is_convex(const Posed& a, const Posed& b, const WorkLimit* limit) {
  const auto rank = [limit](const Posed& s) {
    const MeshModel& mesh = mesh_of(s.shape);
    return mesh.convex(limit) ? 2 : mesh.own_hull(limit) ? 1 : 0;
  };
  return a.shape.is_convex() || (!b.shape.is_convex() && rank(a) > rank(b));
}

PairAnswer of_collision(PairAnswer answer) {
  answer.collide = true;
  answer.signed_distance = std::min(answer.signed_distance, 0.0);
  return answer;
}

// True if a vertex of each component of the other mesh stays outside `outer`'s hull under every translation by at most
// `length`: then no component can get inside.
bool stays_outside(const Posed& outer, const Posed& other, double length, const WorkLimit* limit) {
  WorkMeter meter(limit);
  const MeshModel &o = mesh_of(outer.shape), &m = mesh_of(other.shape);
  const Hull& hull = o.hull(limit);
  const auto is_outside = [&](std::uint32_t v) {
    meter.spend(1 + static_cast<int>(hull.faces.size() / 64));
    const Vec3 p = outer.pose.rotation.transpose() *
                   (other.pose.rotation * m.vertices[v] + (other.pose.translation - outer.pose.translation));
    return std::any_of(hull.faces.begin(), hull.faces.end(),
                       [&](const Hull::Face& f) { return f.normal.dot(p) - f.offset > length; });
  };
  const std::vector<MeshModel::Component>& components = m.components(limit);
  if (components.size() == 1) return std::ranges::any_of(m.extreme(limit), is_outside);
  return std::ranges::all_of(
      components, [&](const MeshModel::Component& component) { return std::ranges::any_of(component, is_outside); });
}

bool is_convex_for(const Posed& s, const Posed& other, double length, const WorkLimit* limit) {
  return s.shape.is_convex() || mesh_of(s.shape).convex(limit) || stays_outside(s, other, length, limit);
}

}  // namespace

bool bounds_convex(const Posed& s, const WorkLimit* limit) {
  return s.shape.is_convex() || mesh_of(s.shape).own_hull(limit);
}

PairAnswer solve_as_convex(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                           std::vector<Contact>* contacts) {
  const bool exchanged = first_is_convex(a, b, options.limit);
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  PairAnswer answer =
      solve_mesh_convex(exchanged ? b : a, exchanged ? a : b, request, for_triangles(options), contacts);
  if (exchanged) swap_answer(answer, contacts, first);
  return answer;
}

PairAnswer overlap_as_convex(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts) {
  return of_collision(solve_as_convex(a, b, request, options, contacts));
}

PairAnswer overlap_of_hulls(const Posed& a, const Posed& b, Request request, const NarrowPhaseOptions& options,
                            std::vector<Contact>* contacts) {
  return of_collision(solve_convex(view_hull(a.shape, options.limit), a.pose, view_hull(b.shape, options.limit), b.pose,
                                   request, for_triangles(options), contacts));
}

bool holds_as_convex(const Posed& a, const Posed& b, double length, const WorkLimit* limit) {
  return first_is_convex(a, b, limit) ? is_convex_for(a, b, length, limit) : is_convex_for(b, a, length, limit);
}

bool holds_as_hulls(const Posed& a, const Posed& b, double length, const WorkLimit* limit) {
  return is_convex_for(a, b, length, limit) && is_convex_for(b, a, length, limit);
}

}  // namespace tandem
