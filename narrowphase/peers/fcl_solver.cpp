// FCL as a solver of two convex shapes.
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <exception>
#include <memory>

#include "peers/peer_solvers.h"
#include "shapes/hull.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// FCL's shape for ours; null if it has none. Built anew for each query: FCL is used for comparison and as a fallback.
std::unique_ptr<fcl::CollisionGeometryd> geometry(const ConvexView& v) {
  switch (v.kind) {
    case ShapeKind::sphere:
      return std::make_unique<fcl::Sphered>(v.param[0]);
    case ShapeKind::box:
      return std::make_unique<fcl::Boxd>(2 * v.param[0], 2 * v.param[1], 2 * v.param[2]);
    case ShapeKind::capsule:
      return std::make_unique<fcl::Capsuled>(v.param[0], v.param[1]);
    case ShapeKind::cylinder:
      return std::make_unique<fcl::Cylinderd>(v.param[0], v.param[1]);
    case ShapeKind::cone:
      return std::make_unique<fcl::Coned>(v.param[0], v.param[1]);
    case ShapeKind::ellipsoid:
      return std::make_unique<fcl::Ellipsoidd>(v.param[0], v.param[1], v.param[2]);
    case ShapeKind::convex:
    case ShapeKind::triangle: {
      auto vertices = std::make_shared<std::vector<fcl::Vector3d>>(v.vertices.begin(), v.vertices.end());
      auto faces = std::make_shared<std::vector<int>>();
      int count = 0;
      if (v.hull != nullptr) {
        for (const Hull::Face& f : v.hull->faces) {
          faces->push_back(static_cast<int>(f.count));
          for (std::uint32_t i = 0; i < f.count; ++i) faces->push_back(static_cast<int>(v.hull->loop[f.first + i]));
          ++count;
        }
      } else if (vertices->size() == 3) {
        *faces = {3, 0, 1, 2, 3, 0, 2, 1};
        count = 2;
      }
      if (count == 0) return nullptr;
      return std::make_unique<fcl::Convexd>(vertices, count, faces);
    }
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  return nullptr;
}

fcl::Transform3d transform(const Mat3& rotation, const Vec3& translation) {
  fcl::Transform3d t = fcl::Transform3d::Identity();
  t.linear() = rotation;
  t.translation() = translation;
  return t;
}

}  // namespace

std::optional<bool> fcl_collide(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b) {
  const auto ga = geometry(a), gb = geometry(b);
  if (!ga || !gb) return std::nullopt;
  try {
    fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    fcl::collide(ga.get(), transform(pose_a.rotation, pose_a.translation), gb.get(),
                 transform(pose_b.rotation, pose_b.translation), request, result);
    return result.isCollision();
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::optional<LocalAnswer> fcl_signed_distance(const ConvexView& a, const ConvexView& b, const RelativePose& pose) {
  const auto ga = geometry(a), gb = geometry(b);
  if (!ga || !gb) return std::nullopt;
  try {
    fcl::DistanceRequestd request(true, true);
    request.distance_tolerance = tolerance::peer_accuracy;
    fcl::DistanceResultd result;
    fcl::distance(ga.get(), fcl::Transform3d::Identity(), gb.get(), transform(pose.rotation, pose.translation), request,
                  result);
    LocalAnswer answer;
    answer.signed_distance = result.min_distance;
    answer.point_a = result.nearest_points[0];
    answer.point_b = result.nearest_points[1];
    const Vec3 between =
        result.min_distance >= 0 ? Vec3(answer.point_b - answer.point_a) : Vec3(answer.point_a - answer.point_b);
    const double length = between.norm();
    if (!std::isfinite(result.min_distance) || !between.allFinite()) return std::nullopt;
    // FCL gives no normal here; where the points coincide the centres' direction is used.
    if (length > 0)
      answer.normal = between / length;
    else if (pose.translation.squaredNorm() > 0)
      answer.normal = pose.translation.normalized();
    return answer;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace tandem
