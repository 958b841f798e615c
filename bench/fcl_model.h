// A mesh as FCL's hierarchy of oriented boxes.
#pragma once
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "triangle_pairs.h"

namespace tandem::bench {

using FclModel = ::fcl::BVHModel<::fcl::OBBRSS<double>>;

inline std::shared_ptr<FclModel> fcl_model(std::span<const Vec3> vertices,
                                           std::span<const std::array<std::uint32_t, 3>> triangles) {
  auto model = std::make_shared<FclModel>();
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
  std::vector<::fcl::Triangle> all;
  for (const auto& t : triangles) all.emplace_back(t[0], t[1], t[2]);
  model->addSubModel({vertices.begin(), vertices.end()}, all);
  model->endModel();
  return model;
}
inline std::shared_ptr<FclModel> fcl_model(const Mesh& mesh) { return fcl_model(mesh.vertices, mesh.triangles); }

/// All pairs of triangles that FCL finds, in order; of a mesh with itself (`itself`, else null) those that count.
inline TrianglePairs fcl_pairs(const FclModel& a, const FclModel& b, const Mesh* itself) {
  const ::fcl::Transform3d home = ::fcl::Transform3d::Identity();
  ::fcl::CollisionResultd result;
  ::fcl::collide(&a, home, &b, home, ::fcl::CollisionRequestd(std::size_t{1} << 28, false), result);
  TrianglePairs pairs;
  for (std::size_t k = 0; k < result.numContacts(); ++k) {
    const auto i = static_cast<std::uint32_t>(result.getContact(k).b1),
               j = static_cast<std::uint32_t>(result.getContact(k).b2);
    if (itself == nullptr || counts(*itself, i, j)) pairs.push_back({i, j});
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace tandem::bench
