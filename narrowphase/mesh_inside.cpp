#include "mesh_inside.h"

#include <cmath>
#include <numbers>
#include <optional>

namespace tandem {
namespace {

// Crossings outward less crossings inward of the ray from p along d; nothing where it passes too near an edge to tell.
std::optional<int> winding(const MeshModel& mesh, const Vec3& p, const Vec3& d) {
  int sum = 0;
  const Vec3 from = (p - mesh.centre) / mesh.unit, inverse = d.cwiseInverse();
  std::vector<std::uint32_t> stack{0};
  while (!stack.empty()) {
    const MeshNode& n = mesh.nodes[stack.back()];
    stack.pop_back();
    for (std::uint32_t k = 0; k < n.lanes; ++k) {
      double enter = 0, leave = std::numeric_limits<double>::infinity();
      for (int i = 0; i < 3; ++i) {
        const double mid = static_cast<double>(n.mid[i][k]) - from[i];
        const double half = static_cast<double>(n.half[i][k]) * (1 + 1e-9) + 1e-12;
        const double x = (mid - half) * inverse[i], y = (mid + half) * inverse[i];
        enter = std::max(enter, std::min(x, y));
        leave = std::min(leave, std::max(x, y));
      }
      if (enter > leave) continue;
      if (n.count[k] == 0) {
        stack.push_back(n.child[k]);
        continue;
      }
      for (std::uint32_t i = 0; i < n.count[k]; ++i) {
        auto c = mesh.corners(mesh.order[n.child[k] + i]);
        for (Vec3& v : c) v = (v - p) / mesh.unit;
        int positive = 0, negative = 0;
        for (std::size_t e = 0; e < 3; ++e) {
          const Vec3 &u = c[e], &w = c[(e + 1) % 3];
          const double volume = d.dot(u.cross(w));
          const double bound = 1e-14 * (u.lpNorm<1>() * w.lpNorm<1>());
          if (volume > bound) ++positive;
          if (volume < -bound) ++negative;
        }
        if (positive > 0 && negative > 0) continue;
        const Vec3 normal = (c[1] - c[0]).cross(c[2] - c[0]);
        const double height = normal.dot(c[0]), slope = normal.dot(d);
        if (positive < 3 && negative < 3) {
          // On the line of an edge, or a triangle without area. Behind the point it does not matter.
          if (c[0].dot(d) < 0 && c[1].dot(d) < 0 && c[2].dot(d) < 0) continue;
          return std::nullopt;
        }
        if (height * slope > 0) sum += slope > 0 ? 1 : -1;
      }
    }
  }
  return sum;
}

// Sum of the solid angles of all triangles: no direction to choose, but every triangle is looked at.
// Van Oosterom and Strackee, The solid angle of a plane triangle, 1983.
double solid_angle(const MeshModel& mesh, const Vec3& p) {
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    auto c = mesh.corners(t);
    for (Vec3& v : c) v = (v - p) / mesh.unit;
    const double x = c[0].norm(), y = c[1].norm(), z = c[2].norm();
    sum += 2 * std::atan2(c[0].dot(c[1].cross(c[2])),
                          x * y * z + c[0].dot(c[1]) * z + c[1].dot(c[2]) * x + c[2].dot(c[0]) * y);
  }
  return sum;
}

}  // namespace

bool is_inside(const MeshModel& mesh, const Vec3& p) {
  if (((p - mesh.centre).cwiseAbs() - mesh.half).maxCoeff() > 0) return false;
  // Directions that meshes made by hand have no edges along.
  static constexpr double directions[4][3] = {
      {0.8017, 0.3571, 0.4793}, {-0.2918, 0.9104, 0.2931}, {0.1237, -0.4729, 0.8723}, {-0.6131, -0.5273, -0.5883}};
  for (const auto& d : directions)
    if (const auto w = winding(mesh, p, {d[0], d[1], d[2]})) return *w != 0;
  return std::abs(solid_angle(mesh, p)) > 2 * std::numbers::pi;
}

}  // namespace tandem
