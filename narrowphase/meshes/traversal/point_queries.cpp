// Queries of a mesh's surface by a point.
#include "meshes/traversal/point_queries.h"

#include <cmath>
#include <limits>

#include "closed_forms/closed_forms.h"
#include "meshes/traversal/mesh_query.h"
#include "tolerances.h"

namespace tandem {

SurfacePoint nearest_point(const MeshModel& mesh, const Vec3& p, const WorkLimit* limit) {
  SurfacePoint best{std::numeric_limits<double>::infinity(), p, 0};
  BoxQuery(mesh, {p, p}, p, Vec3::Zero(), Mat3::Identity(), 0, limit)
      .nearest_first(best.distance, [&](std::uint32_t t) {
        const auto c = mesh.corners(t);
        const PointDistance d = point_distance(TriangleView(c), p);
        if (d.signed_distance < best.distance) best = {d.signed_distance, d.nearest, t};
        return best.distance;
      });
  return best;
}

std::uint32_t nearest_triangle(const MeshModel& mesh, const Vec3& p, const Vec3& outward) {
  const double reach = mesh.half.norm() + (p - mesh.centre).norm();
  const double as_near = nearest_point(mesh, p).distance + tolerance::place_rounding * reach;
  std::uint32_t best = 0;
  double most = -infinity;
  BoxQuery(mesh, {p, p}, p, Vec3::Zero(), Mat3::Identity()).each_near(as_near, [&](std::uint32_t t) {
    const auto c = mesh.corners(t);
    if (point_distance(TriangleView(c), p).signed_distance > as_near) return false;
    const Vec3 area = area_vector(c);
    const double length = area.norm(), along = length > 0 ? area.dot(outward) / length : 0;
    const double facing = mesh.solid ? along : std::abs(along);
    if (facing > most || (facing == most && t < best)) most = facing, best = t;
    return false;
  });
  return best;
}

double first_crossing(const MeshModel& mesh, const Vec3& p, const Vec3& d, const WorkLimit* limit) {
  double first = std::numeric_limits<double>::infinity();
  const double reach = 4 * (mesh.half.norm() + (p - mesh.centre).norm());
  const Vec3 end = p + reach * d, u = d.unitOrthogonal();
  Mat3 axes;
  axes << d, u, d.cross(u);
  const BoxQuery query(mesh, {p.cwiseMin(end), p.cwiseMax(end)}, (p + end) / 2, Vec3(reach / 2, 0, 0), axes, 0, limit);
  query.each_near(0, [&](std::uint32_t t) {
    // Moeller and Trumbore, Fast, minimum storage ray-triangle intersection, 1997; edges belong to both triangles.
    const auto c = mesh.corners(t);
    const Vec3 e = c[1] - c[0], f = c[2] - c[0], h = d.cross(f), r = p - c[0], q = r.cross(e);
    const double det = e.dot(h);
    if (det == 0) return false;
    const double s = r.dot(h) / det, w = d.dot(q) / det, at = f.dot(q) / det;
    if (s >= -tolerance::on_edge && w >= -tolerance::on_edge && s + w <= 1 + tolerance::on_edge && at > 0)
      first = std::min(first, at);
    return false;
  });
  return first;
}

}  // namespace tandem
