// A mesh and a bounded convex shape: the requests, and the policy of the depth: which of the search's methods are used,
// in which order, and when the answer is accepted.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "meshes/contacts/convex_contacts.h"
#include "meshes/depth/convex_in_mesh.h"
#include "meshes/mesh_solvers.h"
#include "meshes/traversal/mesh_convex_pair.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// Cosines within which a direction counts as one that was tried (0.8 degrees), and as near one (18 degrees).
constexpr double tried_before = 0.9999, tried_nearly = 0.95;

class MeshConvex {
 public:
  /// `margin`: of contacts; that of the pair's options is larger.
  MeshConvex(const MeshConvexPair& pair, double margin) : pair_(pair), margin_(margin), contacts_(pair, margin) {}

  PairAnswer distance() const {
    PairAnswer near = pair_.nearest(pair_.options().cutoff);
    if (near.signed_distance > 0 && !pair_.inside()) return in_world(near);
    if (std::isinf(near.signed_distance)) near = pair_.nearest();  // it lies inside, beyond the cut-off
    return in_world(depth(near));
  }

  PairAnswer contacts(std::vector<Contact>& out) const {
    const std::size_t first = out.size();
    PairAnswer near;
    near.signed_distance = infinity;
    PatchCollector all(pair_.size(), pair_.options());
    contacts_.find(near, all, out);
    contacts_.append_patches(all, infinity, out);
    pair_.decide(near);
    if (near.signed_distance <= 0) return contacts_of_overlap(near, all, first, out);
    // If the shape lies inside, the distances found are to the wrong side of the surface.
    if (pair_.inside()) {
      out.resize(first);
      const PairAnswer answer = distance();
      out.push_back(contact_of(answer));
      return answer;
    }
    return contacts_of_gap(near, first, out);
  }

 private:
  void to_world(std::span<Contact> contacts) const {
    for (Contact& c : contacts) {
      c.point = pair_.to_world(c.point);
      c.normal = pair_.direction_to_world(c.normal);
    }
  }
  PairAnswer in_world(PairAnswer r) const {
    r.point_a = pair_.to_world(r.point_a);
    r.point_b = pair_.to_world(r.point_b);
    r.normal = pair_.direction_to_world(r.normal);
    return r;
  }

  // The deepest of the triangles that overlap, and the normals of all, examined in turn if they may be deeper than the
  // ones before.
  struct Overlap {
    PairAnswer deepest;
    double depth = 0;
    std::vector<Vec3> normals;
  };
  Overlap deepest_triangle(const PairAnswer& near) const {
    Overlap overlap{near, 0, {}};
    double& certain = overlap.depth;
    SupportPlane clear;
    pair_.each_near(0, [&](std::uint32_t t) {
      const Corners p = pair_.corners(t);
      const TrianglePlane plane = pair_.plane_of(p);
      if (pair_.gap_along(plane) > 0) return false;
      // At most the depth along a direction that is known to separate them, or along its own normal.
      const Vec3& n = plane.normal;
      const double along_normal =
          n.isZero() ? infinity : std::min(n.dot(pair_.support(n)) - plane.low, plane.high - n.dot(pair_.support(-n)));
      if (-clear.beyond(p) <= certain || along_normal <= certain) return false;
      if (const TriangleBound bound = pair_.bound(p); bound.known && -bound.gap <= certain) return false;
      if (pair_.convex().kind == ShapeKind::box && pair_.box_gap(p) > 0) return false;
      const PairAnswer r = pair_.solve(p, Request::distance);
      if (r.signed_distance > 0) return false;
      if (-r.signed_distance >= certain) {
        certain = -r.signed_distance;
        overlap.deepest = r;
        clear = pair_.support_plane(r.normal);
      }
      const Vec3 outward = area_vector(p).stableNormalized();
      overlap.normals.push_back(pair_.model().solid || outward.dot(pair_.centre() - p[0]) >= 0 ? outward
                                                                                               : Vec3(-outward));
      return false;
    });
    return overlap;
  }

  // The depth of an overlap, in the pair's coordinates; `near` is the nearest triangle's answer.
  PairAnswer depth(const PairAnswer& near) const {
    ConvexInMesh overlapping(pair_);
    SeparationSearch search(overlapping, {.normal = near.normal});
    Separation& known = search.known;
    std::vector<Vec3> tried;
    const auto along = [&](const Vec3& d, double alike = tried_before) {
      if (search.is_shortest() || !(d.norm() > 0.5)) return;
      if (std::any_of(tried.begin(), tried.end(), [&](const Vec3& o) { return o.dot(d) > alike; })) return;
      tried.push_back(d);
      search.along(d);
    };
    const auto by_deep_points = [&](const Vec3& n) {
      if (!search.is_shortest()) along(overlapping.raise_by_deep_points(n, known));
    };
    const bool is_inside = near.signed_distance > 0;
    const Overlap overlap = is_inside ? Overlap{near, near.signed_distance, {}} : deepest_triangle(near);
    known.certain = overlap.depth;
    if (const auto off = overlapping.off_triangles()) search.take(*off);
    along(is_inside ? Vec3(-near.normal) : overlap.deepest.normal);
    if (!is_inside && !search.is_shortest()) search.beyond_obstacles();
    by_deep_points(tried.empty() ? known.normal : tried[0]);
    constexpr std::size_t most_directions = 5;
    for (const Vec3& n : overlap.normals)
      if (tried.size() < most_directions) along(n, tried_nearly);
    // Deep inside, the separation from the hull may be as good as any.
    const double small = 0.1 * std::min(pair_.mesh().shape.size(), pair_.posed_convex().shape.size());
    if (!search.is_shortest() && known.length > small && pair_.model().hull(pair_.options().limit).dimension == 3)
      along(normal_of_hull());
    along_surface(search, along);
    if (!search.is_shortest() && std::isfinite(known.length)) {
      search.shorten();
      const double before = known.length;
      by_deep_points(known.normal);
      if (known.length < before && !search.is_shortest()) search.shorten();
    }
    if (!std::isfinite(known.length)) leave_bounds(known);
    return with_points(search.answer());
  }

  // The first translation found that separates, for an overlap without a requested bound: off the deepest triangle,
  // along the contacts' normals, beyond obstacles, out of the hull.
  PairAnswer some_translation(const PairAnswer& near, std::span<const Contact> contacts) const {
    ConvexInMesh overlapping(pair_);
    SeparationSearch search(overlapping, {.normal = near.normal});
    const auto found = [&] { return std::isfinite(search.known.length); };
    search.along(near.normal);
    std::vector<Vec3> tried{near.normal};
    constexpr std::size_t most_directions = 5;
    for (const Contact& c : contacts) {
      if (found() || tried.size() == most_directions) break;
      if (std::any_of(tried.begin(), tried.end(), [&](const Vec3& o) { return o.dot(c.normal) > 0.95; })) continue;
      tried.push_back(c.normal);
      search.along(c.normal);
    }
    if (!found()) search.beyond_obstacles();
    if (!found() && pair_.model().hull(pair_.options().limit).dimension == 3) search.along(normal_of_hull());
    if (!found()) leave_bounds(search.known);
    return with_points(search.answer());
  }

  // The direction that separates it from the mesh's hull.
  Vec3 normal_of_hull() const {
    const Posed &mesh = pair_.mesh(), convex = pair_.posed_convex();
    const PairAnswer hull = solve_convex(view_hull(mesh.shape, pair_.options().limit), mesh.pose, pair_.convex(),
                                         convex.pose, Request::distance, pair_.options(), nullptr);
    return mesh.pose.rotation.transpose() * hull.normal;
  }

  // At the point where the convex shape separates last, the surface's normal is a better direction.
  template <class Along>
  void along_surface(SeparationSearch& search, const Along& along) const {
    constexpr int most_turns = 6;
    const Separation& known = search.known;
    for (int i = 0; i < most_turns && !search.is_shortest() && std::isfinite(known.length); ++i) {
      const PairAnswer r = pair_.moved((known.length + tolerance::far_apart * pair_.size()) * known.normal).nearest();
      if (!(r.signed_distance > 0) || r.normal.dot(known.normal) > tolerance::one_direction) break;
      const double before = known.length;
      along(r.normal);
      if (!(known.length < before * (1 - tolerance::no_shorter))) break;
    }
  }

  // If no translation that was tried is free, takes one beyond the whole mesh.
  void leave_bounds(Separation& known) const {
    known.length = -infinity;
    for (const std::uint32_t v : pair_.model().extreme(pair_.options().limit))
      known.length = std::max(known.length, known.normal.dot(pair_.vertex(v)));
    known.length -= known.normal.dot(pair_.support(-known.normal));
  }

  // Adds the points that separate last: on the mesh there, and the same point of the convex shape in its present pose.
  PairAnswer with_points(PairAnswer answer) const {
    const Vec3 translation = -answer.signed_distance * answer.normal;
    answer.point_a = pair_.moved(translation).nearest().point_a + translation;
    answer.point_b = answer.point_a - translation;
    return answer;
  }

  static double deepest_of(std::span<const Contact> contacts) {
    double deepest = -infinity;
    for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
    return deepest;
  }

  // If no bound is requested: true if a translation by the deepest contact separates.
  bool deepest_separates(std::span<const Contact> contacts) const {
    if (pair_.options().mesh_bounds || contacts.empty()) return false;
    const Contact& c = *std::max_element(contacts.begin(), contacts.end(),
                                         [](const Contact& x, const Contact& y) { return x.depth < y.depth; });
    return c.depth > 0 && !pair_.moved((c.depth + pair_.translation_slack()) * c.normal).collide({&c.normal, 1});
  }

  // For separated shapes with the distance of `near`: no contact is nearer, and one has that distance.
  PairAnswer contacts_of_gap(const PairAnswer& near, std::size_t first, std::vector<Contact>& out) const {
    if (near.signed_distance > margin_) {
      out.resize(first);
      return {};
    }
    const double gap = near.signed_distance;
    for (Contact& c : std::span(out).subspan(first)) c.depth = std::min(c.depth, -gap);
    if (!(deepest_of(std::span(out).subspan(first)) >= -gap - pair_.slack())) out.push_back(contact_of(near));
    to_world(std::span(out).subspan(first));
    PairAnswer answer = from_deepest(out, first);
    answer.collide = false;
    answer.status = near.status;
    answer.error_bound = near.error_bound;
    return answer;
  }

  // For overlapping triangles, of which `near` is the deepest: no shorter translation separates. If a contact has that
  // depth and none is deeper, a translation by it is tried; otherwise the separating translation is searched for, and
  // contacts deeper than that are removed.
  PairAnswer contacts_of_overlap(const PairAnswer& near, PatchCollector& all, std::size_t first,
                                 std::vector<Contact>& out) const {
    const auto deepest = [&] { return deepest_of(std::span(out).subspan(first)); };
    double certain = -near.signed_distance, shortest = infinity;
    const double slack = pair_.translation_slack() + tolerance::no_shorter * certain;
    const auto find_shortest = [&] {
      const PairAnswer translation =
          pair_.options().mesh_bounds ? depth(near) : some_translation(near, std::span(out).subspan(first));
      shortest = -translation.signed_distance;
      if (pair_.options().mesh_bounds) certain = std::max(certain, shortest - translation.error_bound);
      return translation;
    };
    const bool deeper = deepest() > certain + slack;
    if (!(std::abs(deepest() - certain) <= slack) && !(deeper && deepest_separates(std::span(out).subspan(first)))) {
      const PairAnswer translation = find_shortest();
      if (deepest() > shortest + slack) {
        out.resize(first);
        contacts_.append_patches(all, shortest + slack, out);
      }
      if (!(deepest() >= certain - slack)) out.push_back(contact_of(translation));
    }
    to_world(std::span(out).subspan(first));
    PairAnswer answer = from_deepest(out, first);
    answer.collide = true;
    const double depth = -answer.signed_distance;
    bool separates = true;
    if (pair_.size() == 0) return answer;  // two points at one position: any translation separates
    if (!pair_.options().mesh_bounds) {
      answer.status = Status::unproven;
      return answer;
    }
    separates = !collide_moved((depth + pair_.translation_slack()) * answer.normal);
    if (!separates && std::isinf(shortest)) find_shortest();
    const double off = std::max(depth - certain, std::isinf(shortest) ? 0.0 : shortest - depth);
    if (off > pair_.translation_slack() || !separates) {
      answer.status = Status::inexact;
      answer.error_bound = std::max(off, slack);
    }
    return answer;
  }

  // True if the two collide with the convex shape translated (world axes).
  bool collide_moved(const Vec3& move) const {
    const Pose& pose = pair_.posed_convex().pose;
    const Vec3 along = pair_.mesh().pose.rotation.transpose() * unit(move, move.norm());
    return pair_.placed({pose.rotation, pose.translation + move}).collide({&along, 1});
  }

  const MeshConvexPair& pair_;
  const double margin_;
  const ConvexContacts contacts_;
};

}  // namespace

PairAnswer solve_mesh_convex(const Posed& mesh, const Posed& convex, Request request, const NarrowPhaseOptions& options,
                             std::vector<Contact>* contacts) {
  const MeshModel& model = mesh_of(mesh.shape);
  constexpr std::size_t small_hull = 64;
  NarrowPhaseOptions of_triangles = for_triangles(options);
  const WorkLimit* const limit = options.limit;
  if (model.convex(limit) && (model.hull(limit).vertices.size() <= small_hull || request == Request::contacts))
    return solve_convex(view_hull(mesh.shape, limit), mesh.pose,
                        convex.shape.is_convex() ? view(convex.shape) : view_hull(convex.shape, limit), convex.pose,
                        request, of_triangles, contacts);
  // Triangles of two faces that touch to rounding are all included.
  of_triangles.margin += tolerance::alike * (mesh.shape.size() + convex.shape.size());
  // Relative to the mesh's translation: far from the origin, poses that are tried would be rounded.
  const Vec3& origin = mesh.pose.translation;
  const Pose at{mesh.pose.rotation, Vec3::Zero()}, convex_at{convex.pose.rotation, convex.pose.translation - origin};
  const MeshConvexPair pair({mesh.shape, at}, {convex.shape, convex_at}, of_triangles);
  PairAnswer answer;
  if (request == Request::collide) {
    answer.collide = pair.collide();
    return answer;
  }
  const std::size_t first = contacts != nullptr ? contacts->size() : 0;
  const MeshConvex solver(pair, options.margin);
  answer = request == Request::contacts ? solver.contacts(*contacts) : solver.distance();
  move_answer(origin, answer, request == Request::contacts ? contacts : nullptr, first);
  return answer;
}

}  // namespace tandem
