// FCL's shapes for the benches.
#include "fcl_shape.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>

#include "shapes/hull.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"

namespace tandem::bench {
namespace {

std::shared_ptr<fcl::CollisionGeometryd> polytope(const Hull& hull) {
  auto vertices = std::make_shared<std::vector<fcl::Vector3d>>(hull.vertices.begin(), hull.vertices.end());
  auto faces = std::make_shared<std::vector<int>>();
  for (const Hull::Face& f : hull.faces) {
    faces->push_back(static_cast<int>(f.count));
    for (std::uint32_t i = 0; i < f.count; ++i) faces->push_back(static_cast<int>(hull.loop[f.first + i]));
  }
  return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(hull.faces.size()), faces);
}

template <class Volume>
std::shared_ptr<fcl::CollisionGeometryd> hierarchy(const MeshModel& mesh) {
  std::vector<fcl::Triangle> triangles;
  for (const auto& [i, j, k] : mesh.triangles) triangles.emplace_back(i, j, k);
  auto model = std::make_shared<fcl::BVHModel<Volume>>();
  model->beginModel();
  model->addSubModel(mesh.vertices, triangles);
  model->endModel();
  return model;
}

}  // namespace

std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const Shape& s) {
  switch (s.kind()) {
    case ShapeKind::sphere:
      return std::make_shared<fcl::Sphered>(s.radius());
    case ShapeKind::box:
      return std::make_shared<fcl::Boxd>(2 * s.half_size());
    case ShapeKind::capsule:
      return std::make_shared<fcl::Capsuled>(s.radius(), s.length());
    case ShapeKind::cylinder:
      return std::make_shared<fcl::Cylinderd>(s.radius(), s.length());
    case ShapeKind::cone:
      return std::make_shared<fcl::Coned>(s.radius(), s.length());
    case ShapeKind::ellipsoid:
      return std::make_shared<fcl::Ellipsoidd>(s.radii());
    case ShapeKind::halfspace:
      return std::make_shared<fcl::Halfspaced>(s.normal(), s.offset());
    case ShapeKind::mesh:
      return hierarchy<fcl::OBBRSSd>(mesh_of(s));
    default:
      return polytope(hull_of(s));
  }
}

std::shared_ptr<fcl::CollisionGeometryd> fcl_spheres_shape(const Shape& mesh) {
  return hierarchy<fcl::RSSd>(mesh_of(mesh));
}

}  // namespace tandem::bench
