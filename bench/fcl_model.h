// A mesh as FCL's hierarchy of oriented boxes.
#pragma once
#include <fcl/geometry/bvh/BVH_model.h>

#include <memory>
#include <vector>

#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

inline std::shared_ptr<::fcl::BVHModel<::fcl::OBBRSS<double>>> fcl_model(const Mesh& mesh) {
  auto model = std::make_shared<::fcl::BVHModel<::fcl::OBBRSS<double>>>();
  model->beginModel(static_cast<int>(mesh.triangles.size()), static_cast<int>(mesh.vertices.size()));
  std::vector<::fcl::Triangle> all;
  for (const auto& t : mesh.triangles) all.emplace_back(t[0], t[1], t[2]);
  model->addSubModel(mesh.vertices, all);
  model->endModel();
  return model;
}

}  // namespace tandem::bench
