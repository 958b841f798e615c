// Depths of points in a mesh, and inscribed balls.
#include "meshes/depth/inner_balls.h"

#include <algorithm>
#include <cmath>

#include "meshes/traversal/point_in_mesh.h"
#include "meshes/traversal/point_queries.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

// A point of the surface with the unit normal of its triangle.
struct SurfaceSample {
  Vec3 at, outward;
};

// Sample points that each stand for an equal area, in the order of the hierarchy, so that they cover the surface.
std::vector<SurfaceSample> surface_samples(const MeshModel& mesh, std::size_t most) {
  double total = 0;
  for (const std::uint32_t t : mesh.order) total += area_vector(mesh.corners(t)).norm();
  std::vector<SurfaceSample> samples;
  double passed = 0;
  for (const std::uint32_t t : mesh.order) {
    const Corners c = mesh.corners(t);
    const Vec3 area = area_vector(c);
    const double size = area.norm();
    passed += size;
    while (size > 0 && samples.size() < most &&
           passed * static_cast<double>(most) >= (static_cast<double>(samples.size()) + 0.5) * total) {
      // Distributed over the triangle by a quasirandom sequence (Roberts, The unreasonable effectiveness of quasirandom
      // sequences, 2018).
      const auto k = static_cast<double>(samples.size());
      double u = std::fmod(0.5 + 0.7548776662466927 * k, 1), v = std::fmod(0.5 + 0.5698402909980532 * k, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      samples.push_back({c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]), area / size});
    }
  }
  return samples;
}

// The centre of the largest inscribed ball that touches the surface at the sample.
Vec3 centre_of_touching(const MeshModel& mesh, const SurfaceSample& sample, double radius) {
  constexpr int rounds = 12;
  constexpr double enough = 0.99;  // of the radius: the remaining steps change little
  for (int i = 0; i < rounds; ++i) {
    const Vec3 centre = sample.at - radius * sample.outward;
    const SurfacePoint near = nearest_point(mesh, centre);
    if (near.distance >= enough * radius) break;
    const Vec3 offset = near.at - sample.at;
    const double down = -offset.dot(sample.outward);
    if (!(down > 0)) break;
    radius = std::min(radius, offset.squaredNorm() / (2 * down));
  }
  return sample.at - radius * sample.outward;
}

}  // namespace

DepthField::DepthField(const Posed& mesh, double slack, const WorkLimit* limit)
    : mesh_(mesh_of(mesh.shape)),
      pose_(mesh.pose),
      box_(mesh.shape.bounds(mesh.pose)),
      inverse_(mesh.pose.rotation.inverse()),
      slack_(slack),
      least_stretch_(1 - 3 * (pose_.rotation.transpose() * pose_.rotation - Mat3::Identity()).cwiseAbs().maxCoeff()),
      limit_(limit) {}

DepthAt DepthField::at(const Vec3& place) const {
  WorkMeter(limit_).spend();
  const Vec3 p = inverse_ * (place - pose_.translation);
  const SurfacePoint near = nearest_point(mesh_, p, limit_);
  // On the surface exact arithmetic would take long.
  const bool inside = mesh_.solid && near.distance > slack_ && is_inside(mesh_, p, limit_);
  const Vec3 away = unit(pose_.rotation * (p - near.at));
  return inside ? DepthAt{std::max(0.0, near.distance * least_stretch_ - slack_), away}
                : DepthAt{-near.distance / least_stretch_ - slack_, -away};
}

std::vector<Ball> inner_balls(const DepthField& field, std::size_t most) {
  const MeshModel& mesh = field.mesh();
  std::vector<Ball> balls;
  for (const SurfaceSample& sample : surface_samples(mesh, most)) {
    const Vec3 centre = field.placed(mesh.solid ? centre_of_touching(mesh, sample, mesh.half.norm()) : sample.at);
    const double depth = field.at(centre).depth;
    if (depth > 0 || !mesh.solid) balls.push_back({centre, depth});
  }
  return balls;
}

}  // namespace tandem
