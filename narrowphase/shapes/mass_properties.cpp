// Volumes, centres of mass and inertia tensors.
#include "shapes/mass_properties.h"

#include <algorithm>
#include <numbers>

#include "shapes/shape_insides.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr double pi = std::numbers::pi;

/// The mass properties of a body symmetric about the z axis, with the centre of mass at z.
MassProperties symmetric(double volume, double xx, double yy, double zz, double z = 0) {
  return {volume, {0, 0, z}, Vec3(xx, yy, zz).asDiagonal()};
}

MassProperties ellipsoid_mass(const Vec3& radii) {
  const double v = 4.0 / 3 * pi * radii.prod();
  const Vec3 q = radii.cwiseProduct(radii) * (v / 5);
  return symmetric(v, q.y() + q.z(), q.x() + q.z(), q.x() + q.y());
}

MassProperties capsule_mass(double r, double l) {
  const double core = pi * r * r * l, ball = 4.0 / 3 * pi * r * r * r;
  const double zz = core * r * r / 2 + ball * 0.4 * r * r;
  const double xx = core * (r * r / 4 + l * l / 12) + ball * (0.4 * r * r + l * l / 4 + 3.0 / 8 * l * r);
  return symmetric(core + ball, xx, xx, zz);
}

MassProperties sphere_mass(double r) {
  const double v = 4.0 / 3 * pi * r * r * r, i = 0.4 * v * r * r;
  return symmetric(v, i, i, i);
}

MassProperties cylinder_mass(double r, double l) {
  const double v = pi * r * r * l, xx = v * (r * r / 4 + l * l / 12);
  return symmetric(v, xx, xx, v * r * r / 2);
}

MassProperties cone_mass(double r, double l) {
  const double v = pi * r * r * l / 3, xx = v * (0.15 * r * r + 0.0375 * l * l);
  return symmetric(v, xx, xx, 0.3 * v * r * r, -l / 4);
}

MassProperties bounding_box_mass(const Vec3& lo, const Vec3& hi) {
  const Vec3 s = hi - lo;
  MassProperties m = box_mass(s.cwiseMax(s.norm() / 100));
  m.centre = lo + s / 2;
  return m;
}

// Sums the signed tetrahedra of the triangles and a point near them; false if they enclose no volume.
class VolumeSum {
 public:
  explicit VolumeSum(const Vec3& base) : base_(base) {}

  void add(const Vec3& p, const Vec3& q, const Vec3& r) {
    const Vec3 a = p - base_, b = q - base_, c = r - base_;
    const double det = a.dot(b.cross(c));
    const Vec3 s = a + b + c;
    volume_ += det / 6;
    first_ += det / 24 * s;
    second_ += det / 120 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }

  bool finish(double size, MassProperties& mass) const {
    if (!(volume_ > tolerance::no_volume * size * size * size)) return false;
    const Vec3 c = first_ / volume_;
    const Mat3 spread = second_ - volume_ * c * c.transpose();
    mass = {volume_, base_ + c, spread.trace() * Mat3::Identity() - spread};
    return true;
  }

 private:
  Vec3 base_, first_ = Vec3::Zero();
  double volume_ = 0;
  Mat3 second_ = Mat3::Zero();
};

}  // namespace

MassProperties mass_of(const Shape& shape) {
  switch (shape.kind()) {
    case ShapeKind::sphere:
      return sphere_mass(shape.radius());
    case ShapeKind::box:
      return box_mass(2 * shape.half_size());
    case ShapeKind::capsule:
      return capsule_mass(shape.radius(), shape.length());
    case ShapeKind::cylinder:
      return cylinder_mass(shape.radius(), shape.length());
    case ShapeKind::cone:
      return cone_mass(shape.radius(), shape.length());
    case ShapeKind::ellipsoid:
      return ellipsoid_mass(shape.radii());
    case ShapeKind::halfspace:
    case ShapeKind::plane:
      break;
    case ShapeKind::convex:
    case ShapeKind::triangle:
      return hull_mass(hull_of(shape));
    case ShapeKind::mesh:
      return mesh_mass(mesh_of(shape));
    case ShapeKind::voxels:
      return voxel_mass(voxels_of(shape));
  }
  return symmetric(0, 0, 0, 0);
}

MassProperties box_mass(const Vec3& s) {
  const double v = s.prod();
  const Vec3 q = s.cwiseProduct(s) / 12 * v;
  return symmetric(v, q.y() + q.z(), q.x() + q.z(), q.x() + q.y());
}

Bounds bounds_of(std::span<const Vec3> vertices) {
  Bounds b{vertices[0], vertices[0]};
  for (const Vec3& v : vertices) b = {b.lo.cwiseMin(v), b.hi.cwiseMax(v)};
  return b;
}

MassProperties hull_mass(const Hull& hull) {
  const Bounds b = bounds_of(hull.vertices);
  MassProperties mass;
  VolumeSum sum(hull.inside);
  for (const auto& face : hull.faces)
    for (std::uint32_t k = 2; k < face.count; ++k)
      sum.add(hull.vertices[hull.loop[face.first]], hull.vertices[hull.loop[face.first + k - 1]],
              hull.vertices[hull.loop[face.first + k]]);
  return hull.dimension == 3 && sum.finish((b.hi - b.lo).norm(), mass) ? mass : bounding_box_mass(b.lo, b.hi);
}

MassProperties mesh_mass(const MeshModel& mesh) {
  MassProperties mass;
  VolumeSum sum(mesh.centre);
  const bool closed = mesh.closed && std::none_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) {
                        const std::uint32_t p = mesh.representative(t[0]), q = mesh.representative(t[1]),
                                            r = mesh.representative(t[2]);
                        return p == q || q == r || r == p;
                      });
  for (std::uint32_t i = 0; closed && i < mesh.triangles.size(); ++i) {
    const auto [p, q, r] = mesh.corners(i);
    sum.add(p, q, r);
  }
  return closed && sum.finish(2 * mesh.half.norm(), mass)
             ? mass
             : bounding_box_mass(mesh.centre - mesh.half, mesh.centre + mesh.half);
}

}  // namespace tandem
