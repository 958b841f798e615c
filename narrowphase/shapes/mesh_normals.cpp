// The cones of a mesh's normals, computed at their first use.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "shapes/triangle_fan.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

using Direction = Eigen::Vector3f;

constexpr auto all_around = std::numbers::pi_v<float>;

// Visits the triangles about corner k of t other than t; false if they do not go all around, or are too many.
template <class Visit>
bool each_around_corner(const MeshModel& mesh, std::uint32_t t, std::size_t k, Visit&& visit) {
  TriangleCorner at{t, k};
  for (std::size_t i = 0; i < most_about_corner; ++i) {
    at = next_about_corner(mesh, at);
    if (at.triangle == t) return true;
    if (at.corner == 3) return false;
    visit(at.triangle);
  }
  return false;
}

float angle_between(const Direction& x, const Direction& y) { return std::atan2(x.cross(y).norm(), x.dot(y)); }

// The cone about the sum of the axes; one wider than half a space becomes all directions.
NormalCone around(std::span<const NormalCone> cones) {
  Direction sum = Direction::Zero();
  for (const NormalCone& cone : cones) {
    if (!(cone.angle < all_around / 2)) return {};
    sum += cone.axis;
  }
  if (!(sum.norm() > static_cast<float>(tolerance::flush))) return {};
  NormalCone out{sum.normalized(), 0};
  for (const NormalCone& cone : cones) out.angle = std::max(out.angle, angle_between(out.axis, cone.axis) + cone.angle);
  return out;
}

NormalCone of_triangle(const MeshModel& mesh, std::uint32_t t, std::span<const Direction> normals,
                       std::vector<NormalCone>& scratch) {
  scratch.assign(1, {normals[t], 0});
  bool closed = !normals[t].isZero();
  for (std::size_t k = 0; k < 3 && closed; ++k)
    closed = each_around_corner(mesh, t, k, [&](std::uint32_t next) {
      scratch.push_back({normals[next], normals[next].isZero() ? all_around : 0});
    });
  if (!closed) return {};
  NormalCone cone = around(scratch);
  cone.angle += static_cast<float>(tolerance::cone_slack);
  return cone;
}

}  // namespace

const NormalCones& MeshModel::normal_cones(const WorkLimit* limit) const {
  return cones_.get(limit, [&](const WorkLimit* own) {
    neighbours(own);  // needed to find the triangles about a corner
    WorkMeter meter(own);
    std::vector<Direction> normals(triangles.size());
    for (std::uint32_t t = 0; t < normals.size(); ++t) {
      meter.spend();
      normals[t] = triangle_normal(*this, t, tolerance::flush).value_or(Vec3::Zero()).cast<float>();
    }
    std::vector<NormalCone> cones(nodes.size() * mesh_lanes), scratch;
    const auto add = [&](const auto& self, std::uint32_t at) -> NormalCone {
      meter.spend(mesh_lanes);
      const MeshNode& node = nodes[at];
      const std::span own = std::span(cones).subspan(at * mesh_lanes, node.lanes());
      for (std::uint32_t k = 0; k < node.lanes(); ++k)
        own[k] = node.bottom() ? of_triangle(*this, triangle_of(node, k), normals, scratch)
                               : self(self, boxes_of(node).child[k]);
      return around(own);
    };
    add(add, 0);
    return NormalCones(std::move(cones), mesh_lanes);
  });
}

}  // namespace tandem
