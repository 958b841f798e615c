// Patches of contacts in concave corners of a mesh.
#include "meshes/contacts/concave_corner.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "closed_forms/closed_forms.h"
#include "manifold/manifold.h"
#include "tolerances.h"

namespace tandem {
namespace {

// A contact moved along a face may have left the other mesh, where that leans away. A contact farther from a mesh than
// half its depth is moved to the nearest point of the curve, which lies on both; of two moved to the same point the
// deeper one stays.
void keep_on_both(const PosedMeshes& m, const PatchPoints& points, std::size_t first, std::vector<Contact>& contacts) {
  const double size = (m.a.half + m.b.half).norm();
  WorkMeter meter(m.limit);
  const auto is_near = [&](const Contact& c, std::span<const Facet> facets) {
    return std::any_of(facets.begin(), facets.end(), [&](const Facet& f) {
      meter.spend();
      const TriangleView triangle(f.p);
      return point_distance(triangle, c.point).signed_distance <= c.depth / 2 + tolerance::in_plane * size;
    });
  };
  for (Contact& c : std::span(contacts).subspan(first)) {
    if (is_near(c, points.facets[0]) && is_near(c, points.facets[1])) continue;
    const Vec3 from = c.point;
    double least = infinity;
    for (const std::span<const Candidate> edges : points.edges)
      for (const Candidate& e : edges)
        if (const double away = (e.point - from).norm(); away < least - tolerance::alike * size)
          least = away, c.point = e.point;
  }
  std::size_t end = first;
  for (std::size_t k = first; k < contacts.size(); ++k) {
    std::size_t same = first;
    while (same < end && !((contacts[same].point - contacts[k].point).norm() < tolerance::same_place * size)) ++same;
    if (same == end)
      contacts[end++] = contacts[k];
    else if (contacts[k].depth > contacts[same].depth)
      contacts[same] = contacts[k];
  }
  contacts.resize(end);
}

}  // namespace

ConcaveCorner find_corner(const PosedMeshes& m, std::span<const Facet> facets, bool of_a, Memory memory) {
  constexpr std::size_t most = 4;
  struct Plane {
    Vec3 n;
    double level;
  };
  const double slack = tolerance::in_plane * (m.a.half + m.b.half).norm(), side = of_a ? 1 : -1;
  std::array<Plane, most> planes;
  std::size_t count = 0;
  // The least and largest height of a triangle in front of a plane.
  const auto heights = [&](const Plane& f, const std::array<Vec3, 3>& p) {
    return std::minmax(
        {side * (f.n.dot(p[0]) - f.level), side * (f.n.dot(p[1]) - f.level), side * (f.n.dot(p[2]) - f.level)});
  };
  ConcaveCorner corner(memory);
  corner.of_a = of_a;
  bool is_bent = false;
  WorkMeter meter(m.limit);
  for (const Facet& facet : facets) {
    meter.spend();
    bool is_known = false;
    for (std::size_t k = 0; k < count && !is_known; ++k) {
      const auto [low, high] = heights(planes[k], facet.p);
      if (low < -slack) return corner;
      is_known = high <= slack;
    }
    if (is_known) continue;
    if (count == most) return corner;
    for (std::size_t k = 0; k < count; ++k) is_bent = is_bent || planes[k].n.dot(facet.n) < one_patch;
    planes[count++] = {facet.n, facet.n.dot(facet.p[0])};
  }
  if (!is_bent) return corner;
  for (const Plane& f : std::span(planes).first(count)) corner.faces.push_back({f.n, f.level, List<Facet>(memory)});
  for (const Facet& facet : facets) {
    meter.spend();
    for (std::size_t k = 0; k < count; ++k) {
      const auto [low, high] = heights(planes[k], facet.p);
      if (low < -slack) {
        corner.faces.clear();
        return corner;
      }
      if (high <= slack) corner.faces[k].facets.push_back(facet);
    }
  }
  return corner;
}

void add_corner_face(const PosedMeshes& m, const PatchPoints& points, const ConcaveCorner& corner,
                     const ConcaveCornerFace& face, Memory memory, std::vector<Contact>& contacts) {
  const std::size_t own = corner.of_a ? 1 : 0;
  const double slack = tolerance::in_plane * (m.a.half + m.b.half).norm(), side = corner.of_a ? 1 : -1;
  Facets facets = points.facets;
  facets[own] = face.facets;
  const auto is_beside = [&](const Vec3& p) { return std::abs(face.n.dot(p) - face.level) > slack; };
  const auto there = [&](std::span<const Candidate> from, bool is_own) {
    List<Candidate> to(memory);
    for (Candidate c : from) {
      if (is_own && is_beside(c.point)) continue;
      for (const ConcaveCornerFace& other : corner.faces) {
        const double ahead = other.n.dot(c.point) - other.level;
        const Vec3 across = other.n - other.n.dot(face.n) * face.n;
        if (!is_own && side * ahead < 0 && across.squaredNorm() > tolerance::slanting2)
          c.point -= (ahead / across.squaredNorm()) * across;
      }
      to.push_back(c);
    }
    return to;
  };
  const std::array<List<Candidate>, 2> vertices{there(points.vertices[0], own == 0),
                                                there(points.vertices[1], own == 1)},
      edges{there(points.edges[0], own == 0), there(points.edges[1], own == 1)};
  // An edge in a face, or between two, is no ridge on which another edge could lie.
  const PatchPoints on_it{{vertices[0], vertices[1]}, {edges[0], edges[1]}, {}, facets};
  const std::size_t first = contacts.size();
  add_points(m, on_it, face.n, memory, contacts);
  keep_on_both(m, points, first, contacts);
}

}  // namespace tandem
