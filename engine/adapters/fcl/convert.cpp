// Shapes of FCL's geometries, by their node types (fcl/geometry/collision_geometry.h).
#include "tandem/fcl/convert.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/plane.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/geometry/shape/triangle_p.h>

#include <algorithm>

namespace tandem::fcl {
namespace {

template <class S>
Vec3 to_vec(const ::fcl::Vector3<S>& v) {
  return v.template cast<double>();
}

template <class Volume>
std::optional<Shape> to_mesh(const ::fcl::CollisionGeometry<typename Volume::S>& geometry) {
  const auto& model = static_cast<const ::fcl::BVHModel<Volume>&>(geometry);
  if (model.getModelType() != ::fcl::BVH_MODEL_TRIANGLES) return std::nullopt;
  Mesh mesh;
  mesh.vertices.reserve(static_cast<std::size_t>(model.num_vertices));
  for (int i = 0; i < model.num_vertices; ++i) mesh.vertices.push_back(to_vec<typename Volume::S>(model.vertices[i]));
  mesh.triangles.reserve(static_cast<std::size_t>(model.num_tris));
  for (int i = 0; i < model.num_tris; ++i) {
    const ::fcl::Triangle& t = model.tri_indices[i];
    mesh.triangles.push_back(
        {static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]), static_cast<std::uint32_t>(t[2])});
  }
  return Shape(std::move(mesh));
}

template <class S>
Shape to_hull(const ::fcl::Convex<S>& convex) {
  Convex hull;
  for (const auto& vertex : convex.getVertices()) hull.vertices.push_back(to_vec<S>(vertex));
  return Shape(hull);
}

template <class S>
std::optional<Shape> any_to_shape(const ::fcl::CollisionGeometry<S>& g) {
  switch (g.getNodeType()) {
    case ::fcl::GEOM_SPHERE:
      return Shape(Sphere{static_cast<const ::fcl::Sphere<S>&>(g).radius});
    case ::fcl::GEOM_BOX:
      return Shape(Box{to_vec<S>(static_cast<const ::fcl::Box<S>&>(g).side)});
    case ::fcl::GEOM_CAPSULE: {
      const auto& capsule = static_cast<const ::fcl::Capsule<S>&>(g);
      return Shape(Capsule{capsule.radius, capsule.lz});
    }
    case ::fcl::GEOM_CYLINDER: {
      const auto& cylinder = static_cast<const ::fcl::Cylinder<S>&>(g);
      return Shape(Cylinder{cylinder.radius, cylinder.lz});
    }
    case ::fcl::GEOM_CONE: {
      const auto& cone = static_cast<const ::fcl::Cone<S>&>(g);
      return Shape(Cone{cone.radius, cone.lz});
    }
    case ::fcl::GEOM_ELLIPSOID:
      return Shape(Ellipsoid{to_vec<S>(static_cast<const ::fcl::Ellipsoid<S>&>(g).radii)});
    case ::fcl::GEOM_HALFSPACE: {
      const auto& half = static_cast<const ::fcl::Halfspace<S>&>(g);
      return Shape(HalfSpace{to_vec<S>(half.n), half.d});
    }
    case ::fcl::GEOM_PLANE: {
      const auto& plane = static_cast<const ::fcl::Plane<S>&>(g);
      return Shape(Plane{to_vec<S>(plane.n), plane.d});
    }
    case ::fcl::GEOM_TRIANGLE: {
      const auto& t = static_cast<const ::fcl::TriangleP<S>&>(g);
      return Shape(Triangle{{to_vec<S>(t.a), to_vec<S>(t.b), to_vec<S>(t.c)}});
    }
    case ::fcl::GEOM_CONVEX:
      return to_hull(static_cast<const ::fcl::Convex<S>&>(g));
    case ::fcl::BV_AABB:
      return to_mesh<::fcl::AABB<S>>(g);
    case ::fcl::BV_OBB:
      return to_mesh<::fcl::OBB<S>>(g);
    case ::fcl::BV_RSS:
      return to_mesh<::fcl::RSS<S>>(g);
    case ::fcl::BV_kIOS:
      return to_mesh<::fcl::kIOS<S>>(g);
    case ::fcl::BV_OBBRSS:
      return to_mesh<::fcl::OBBRSS<S>>(g);
    case ::fcl::BV_KDOP16:
      return to_mesh<::fcl::KDOP<S, 16>>(g);
    case ::fcl::BV_KDOP18:
      return to_mesh<::fcl::KDOP<S, 18>>(g);
    case ::fcl::BV_KDOP24:
      return to_mesh<::fcl::KDOP<S, 24>>(g);
    default:
      return std::nullopt;
  }
}

}  // namespace

template <>
std::optional<Shape> to_shape(const ::fcl::CollisionGeometry<float>& geometry) {
  return any_to_shape(geometry);
}
template <>
std::optional<Shape> to_shape(const ::fcl::CollisionGeometry<double>& geometry) {
  return any_to_shape(geometry);
}

void ShapeCache::drop_the_dead() {
  std::erase_if(kept_, [](const auto& entry) { return entry.second.geometry.expired(); });
  drop_at_ = std::max<std::size_t>(64, 2 * kept_.size());
}

}  // namespace tandem::fcl
