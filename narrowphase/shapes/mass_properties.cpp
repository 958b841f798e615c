#include "shapes/mass_properties.h"

#include <algorithm>

#include "tolerances.h"

namespace tandem {
namespace {

MassProperties bounding_box_mass(const Vec3& lo, const Vec3& hi) {
  const Vec3 s = hi - lo;
  MassProperties m = box_mass(s.cwiseMax(s.norm() / 100));
  m.centre = lo + s / 2;
  return m;
}

// Sums the signed tetrahedra that the triangles span with a point near them; false if they enclose no volume.
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

MassProperties symmetric(double volume, double xx, double yy, double zz, double z) {
  return {volume, {0, 0, z}, Vec3(xx, yy, zz).asDiagonal()};
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
  const bool closed = std::all_of(mesh.neighbours.begin(), mesh.neighbours.end(), [](const auto& beside) {
    return std::find(beside.begin(), beside.end(), no_index) == beside.end();
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
