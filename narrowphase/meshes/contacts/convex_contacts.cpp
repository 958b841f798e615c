#include "meshes/contacts/convex_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "closed_forms/closed_forms.h"
#include "meshes/contacts/normal_cone.h"
#include "shapes/mesh_model.h"

namespace tandem {

// Is the translation off the triangle's plane to the side of the convex shape's centre, along n (unit), provably the
// shortest? The point that is deepest, w below the plane, lies over the triangle at least rho from its edges. So a disc
// of it holds the shape back along any direction at an angle x to n by w cos x + rho sin x, which is less than w only
// beyond pi - 2 atan(w / rho). There the centre, h above the plane and l away from the deepest point along it, holds it
// back by -h cos x - l sin x. Apart, the deepest point need only lie over the triangle.
bool ConvexContacts::depth_is_along(const Vec3& n, const Corners& p, const Vec3& deepest, double w) const {
  double rho2 = infinity;
  const double turn = n.dot(area_vector(p)) > 0 ? 1 : -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = p[(i + 1) % 3] - p[i];
    const double beside = turn * n.cross(edge).dot(deepest - p[i]), length2 = edge.squaredNorm();
    if (!(beside > 0)) return false;
    if (w > 0 && !(beside * beside > 16 * w * w * length2)) return false;
    rho2 = std::min(rho2, beside * beside / length2);
  }
  if (!(w > 0)) return true;
  const Vec3 up = pair_.centre() - deepest;
  const double k2 = w * w / rho2, h = up.dot(n) - w, l2 = (up - up.dot(n) * n).squaredNorm();
  const double spare = h * (1 - k2) - w * (1 + k2);
  return spare > 0 && spare * spare > 4 * k2 * l2;
}

// Do all of the points lie on an edge or a corner of the triangle beyond which its neighbours reach farther along n?
bool ConvexContacts::neighbours_reach_farther(std::uint32_t t, const Corners& p, const Vec3& n,
                                              std::span<const Contact> points) const {
  const double slack = tolerance::alike * pair_.size();
  const MeshModel& model = pair_.model();
  const auto all = [&](auto&& are_there) {
    return std::all_of(points.begin(), points.end(), [&](const Contact& c) { return are_there(c.point); });
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &from = p[k], &to = p[(k + 1) % 3];
    if (all([&](const Vec3& q) { return (q - from).norm() <= slack; })) return has_higher_neighbour(model, t, k, n);
    const std::uint32_t next = model.neighbours[t][k];
    if (next == no_index) continue;
    const Corners other = pair_.corners(next);
    const double highest = std::max({n.dot(other[0]), n.dot(other[1]), n.dot(other[2])});
    if (highest - std::max(n.dot(from), n.dot(to)) <= slack) continue;
    const Vec3 along = (to - from).stableNormalized();
    if (all([&](const Vec3& q) { return (q - from).cross(along).norm() <= slack; })) return true;
  }
  return false;
}

// Is an answer's normal a direction along which the surface pushes at the triangle? What only touches is pushed by the
// neighbours where it lies behind the triangle, or where they go on along the normal.
bool ConvexContacts::pushes(std::uint32_t t, const Corners& p, const TrianglePlane& plane, const PairAnswer& answer,
                            std::span<const Contact> points) const {
  const MeshModel& model = pair_.model();
  const double slack = tolerance::alike * pair_.size();
  if (model.solid && plane.flat && !(answer.normal.dot(plane.normal) > -tolerance::flush)) return false;
  if (answer.signed_distance >= -slack && neighbours_reach_farther(t, p, answer.normal, points)) return false;
  return in_normal_cone(model, t, answer.normal, pair_.in_mesh(answer.point_a), slack);
}

// Adds the triangle's contacts but those deeper than `limit`; `near` is the nearest triangle's answer. `room`: what it
// holds stays as it is.
ConvexContacts::Apart ConvexContacts::add_contacts(std::uint32_t t, const Corners& p, double limit, PairAnswer& near,
                                                   PatchCollector& patches, std::vector<Contact>& room) const {
  const std::size_t first = room.size();
  const Apart apart = find_contacts(t, p, near, room, first);
  const auto is_too_deep = [&](const Contact& c) { return c.depth > limit; };
  room.erase(std::remove_if(room.begin() + static_cast<std::ptrdiff_t>(first), room.end(), is_too_deep), room.end());
  if (room.size() > first) patches.add(t, std::span<const Contact>(room).subspan(first));
  room.resize(first);
  return apart;
}

// The triangle's contacts, appended to `found`, which holds `first` of others.
ConvexContacts::Apart ConvexContacts::find_contacts(std::uint32_t t, const Corners& p, PairAnswer& near,
                                                    std::vector<Contact>& found, std::size_t first) const {
  const double margin = pair_.options().margin;
  const TrianglePlane plane = pair_.plane_of(p);
  if (const double gap = pair_.box_gap_along(plane); gap > margin) return {gap};
  PairAnswer r;
  bool is_known = false;
  if (plane.flat) {
    const Vec3 n = plane.normal.dot(pair_.centre() - p[0]) < 0 ? Vec3(-plane.normal) : plane.normal;
    const Vec3 deepest = pair_.support(-n);
    const double depth = n.dot(p[0] - deepest);
    if (depth < -margin) return {-depth};
    is_known = pair_.convex().kind != ShapeKind::sphere && depth_is_along(n, p, deepest, depth);
    if (is_known) {
      r.signed_distance = -depth;
      r.normal = n;
      r.point_a = deepest + depth * n;
      r.point_b = deepest;
    }
  }
  if (!is_known) r = pair_.solve(p, Request::contacts);
  pair_.append_patch(p, {r.signed_distance, r.point_a, r.point_b, r.normal, 0}, found);
  if (r.signed_distance < near.signed_distance) near = r;
  const Apart apart{r.signed_distance, r.normal};
  if (found.size() == first || pushes(t, p, plane, r, std::span<const Contact>(found).subspan(first))) return apart;
  // Its neighbours lie there. What the face bears counts of what has gone through it.
  found.resize(first);
  if (plane.flat && r.signed_distance < -tolerance::alike * pair_.size()) append_along_plane(p, plane, r.normal, found);
  return apart;
}

// Those along the triangle's normal, to the outer side; of a surface to that of the convex shape's centre.
void ConvexContacts::append_along_plane(const Corners& p, const TrianglePlane& plane, const Vec3& normal,
                                        std::vector<Contact>& found) const {
  const std::size_t first = found.size();
  const double side = plane.normal.dot(pair_.centre() - p[0]);
  const bool as_wound = pair_.model().solid || side > 0 || (side == 0 && plane.normal.dot(normal) >= 0);
  const Vec3 n = as_wound ? plane.normal : Vec3(-plane.normal);
  const Vec3 low = pair_.support(-n);
  const double depth = n.dot(p[0] - low);
  if (depth < -pair_.options().margin) return;
  const LocalAnswer along{-depth, low + depth * n, low, n, 0};
  pair_.append_patch(p, along, found);
  const double outside = point_distance(TriangleView(p), along.point_a).signed_distance;
  if (outside <= tolerance::in_plane * pair_.size()) return;
  const auto is_made_up = [](const Contact& c) { return c.feature == 0xffffffffu; };
  found.erase(std::remove_if(found.begin() + static_cast<std::ptrdiff_t>(first), found.end(), is_made_up), found.end());
}

void ConvexContacts::gather(double limit, PairAnswer& near, std::vector<Contact>& out) const {
  const double margin = pair_.options().margin;
  PatchCollector patches(pair_.size(), pair_.options().limit);
  const std::size_t first = out.size();
  // What keeps it from one triangle keeps it from others near that.
  std::array<SupportPlane, 4> clear;
  std::size_t next = 0;
  pair_.each_near(margin, [&](std::uint32_t t) {
    const Corners p = pair_.corners(t);
    for (const SupportPlane& known : clear)
      if (known.beyond(p) > margin + pair_.slack()) return false;
    const Apart apart = add_contacts(t, p, limit, near, patches, out);
    if (apart.gap > margin && !apart.normal.isZero()) clear[next++ % clear.size()] = pair_.support_plane(apart.normal);
    return false;
  });
  patches.finish(pair_.centre(), pair_.model().solid, out);
  for (Contact& c : std::span(out).subspan(first)) c.depth = std::max(c.depth, -margin_);
}

}  // namespace tandem
