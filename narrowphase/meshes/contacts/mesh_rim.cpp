#include "meshes/contacts/mesh_rim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "closed_forms/closed_forms.h"
#include "meshes/traversal/mesh_query.h"
#include "tolerances.h"

namespace tandem {
namespace {

using tolerance::flush;       // sine of an angle that is none
constexpr int most_neighbours = 64;  // about a corner

}  // namespace

// Walks from edge to edge.
bool overtopped(const MeshModel& mesh, std::uint32_t t, std::size_t k, const Vec3& n) {
  const Vec3 corner = mesh.corners(t)[k];
  for (const bool forth : {true, false}) {
    std::uint32_t at = t;
    std::size_t c = k;
    for (int i = 0; i < most_neighbours; ++i) {
      const std::uint32_t next = mesh.neighbours[at][forth ? (c + 2) % 3 : c];
      if (next == no_index || next == t) break;
      const auto p = mesh.corners(next);
      std::size_t same = 3;
      for (std::size_t j = 0; j < 3; ++j) {
        if (p[j] == corner) same = j;
        const Vec3 away = p[j] - corner;
        if (n.dot(away) > flush * away.norm()) return true;
      }
      if (same == 3) break;
      at = next;
      c = same;
    }
  }
  return false;
}

bool bears(const MeshModel& mesh, std::uint32_t t, const Vec3& n, const Vec3& at, double slack) {
  const auto p = mesh.corners(t);
  std::array<double, 3> height;
  for (std::size_t k = 0; k < 3; ++k) height[k] = n.dot(p[k] - p[0]);
  const double top = *std::max_element(height.begin(), height.end());
  const double longest = std::max({(p[1] - p[0]).norm(), (p[2] - p[0]).norm(), (p[2] - p[1]).norm()});
  std::array<bool, 3> high;
  for (std::size_t k = 0; k < 3; ++k) high[k] = height[k] >= top - flush * longest;
  if (high[0] && high[1] && high[2]) return true;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t to = (k + 1) % 3;
    if (!high[k] || !high[to]) continue;
    // Along an edge what lies around its corners tells only of these.
    const std::uint32_t next = mesh.neighbours[t][k];
    if (next != no_index)
      for (const Vec3& v : mesh.corners(next))
        if (const Vec3 away = v - p[k]; n.dot(away) > flush * away.norm()) return false;
    for (const std::size_t end : {k, to})
      if ((at - p[end]).norm() <= slack) return !overtopped(mesh, t, end, n);
    return true;
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (high[k] && overtopped(mesh, t, k, n)) return false;
  return true;
}

// From triangle to triangle over edges whose other side lies in the same plane; what was not reached is border.
double flat_about(const MeshModel& mesh, std::uint32_t t, const Vec3& p, double slack) {
  constexpr std::size_t most = 16;
  const auto own = mesh.corners(t);
  const Vec3 area = (own[1] - own[0]).cross(own[2] - own[0]), n = area.stableNormalized();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 edge = own[(k + 1) % 3] - own[k];
    if (!(n.cross(edge).dot(p - own[k]) >= -slack * edge.norm())) return -1;
  }
  std::array<std::uint32_t, most> flat{t};
  std::size_t count = 1;
  const auto is_known = [&](std::uint32_t i) {
    return std::find(flat.begin(), flat.begin() + count, i) != flat.begin() + count;
  };
  for (std::size_t i = 0; i < count; ++i)
    for (const std::uint32_t next : mesh.neighbours[flat[i]]) {
      if (count == most || next == no_index || is_known(next)) continue;
      const auto c = mesh.corners(next);
      const auto in_plane = [&](const Vec3& v) { return std::abs(n.dot(v - own[0])) <= slack; };
      // Not one that folds back.
      if (in_plane(c[0]) && in_plane(c[1]) && in_plane(c[2]) && n.dot((c[1] - c[0]).cross(c[2] - c[0])) > 0)
        flat[count++] = next;
    }
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const auto c = mesh.corners(flat[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t next = mesh.neighbours[flat[i]][k];
      if (next != no_index && is_known(next)) continue;
      const Vec3 edge = c[(k + 1) % 3] - c[k];
      const double part = std::clamp((p - c[k]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (p - c[k] - part * edge).norm());
    }
  }
  return nearest;
}

SurfacePoint nearest_point(const MeshModel& mesh, const Vec3& p) {
  SurfacePoint best{std::numeric_limits<double>::infinity(), p};
  BoxQuery(mesh, {p, p}, p, Vec3::Zero(), Mat3::Identity()).nearest_first(best.distance, [&](std::uint32_t t) {
    const auto c = mesh.corners(t);
    const PointDistance d = point_distance(TriangleView(c), p);
    if (d.signed_distance < best.distance) best = {d.signed_distance, d.nearest};
    return best.distance;
  });
  return best;
}

double first_crossing(const MeshModel& mesh, const Vec3& p, const Vec3& d) {
  double first = std::numeric_limits<double>::infinity();
  const double reach = 4 * (mesh.half.norm() + (p - mesh.centre).norm());
  const Vec3 end = p + reach * d, u = d.unitOrthogonal();
  Mat3 axes;
  axes << d, u, d.cross(u);
  const BoxQuery query(mesh, {p.cwiseMin(end), p.cwiseMax(end)}, (p + end) / 2, Vec3(reach / 2, 0, 0), axes);
  query.each_near(0, [&](std::uint32_t t) {
    // Moeller and Trumbore, Fast, minimum storage ray-triangle intersection, 1997; edges belong to both sides.
    const auto c = mesh.corners(t);
    const Vec3 e = c[1] - c[0], f = c[2] - c[0], h = d.cross(f), r = p - c[0], q = r.cross(e);
    const double det = e.dot(h);
    if (det == 0) return false;
    const double s = r.dot(h) / det, w = d.dot(q) / det, at = f.dot(q) / det;
    if (s >= -tolerance::on_edge && w >= -tolerance::on_edge && s + w <= 1 + tolerance::on_edge && at > 0) first = std::min(first, at);
    return false;
  });
  return first;
}

}  // namespace tandem
