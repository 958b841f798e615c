// The exact support function of a posed convex shape.
#include "posed_core.h"

namespace tandem::reference {

PosedCore::PosedCore(const Shape& shape, const Pose& pose, const Vec3& origin)
    : shape_(shape), translation_(Vec(pose.translation) - Vec(origin)) {
  for (int k = 0; k < 3; ++k) columns_[k] = Vec(Vec3(pose.rotation.col(k)));
  Real farthest = shape.size();
  if (shape.kind() == ShapeKind::convex || shape.kind() == ShapeKind::triangle)
    for (const Vec3& v : shape.vertices()) farthest = max(farthest, norm(Vec(v)));
  reach_ = norm(translation_) + Real(1.00001) * farthest;
}

Real PosedCore::radius() const {
  return shape_.kind() == ShapeKind::sphere || shape_.kind() == ShapeKind::capsule ? Real(shape_.radius()) : Real(0);
}

bool PosedCore::is_polytope() const {
  switch (shape_.kind()) {  // no default case: a new kind must be added here
    case ShapeKind::cylinder:
    case ShapeKind::cone:
    case ShapeKind::ellipsoid:
      return false;
    case ShapeKind::sphere:
    case ShapeKind::box:
    case ShapeKind::capsule:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::convex:
    case ShapeKind::triangle:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  return true;
}

Vec PosedCore::hull_support(const Vec& d) const {
  // A scan in doubles; vertices within its rounding of the best are compared again in full precision.
  const auto vertices = shape_.vertices();
  const Real length = max(max(abs(d.x), abs(d.y)), abs(d.z));
  if (!(length > 0)) return Vec(vertices[0]);
  const Vec3 coarse = (d / length).rounded();
  double best = vertices[0].dot(coarse), farthest = 0;
  for (const Vec3& v : vertices) {
    best = std::max(best, v.dot(coarse));
    farthest = std::max(farthest, v.cwiseAbs().maxCoeff());
  }
  const double near = best - 1e-14 * farthest;
  const Vec3* chosen = nullptr;
  Real most = 0;
  for (const Vec3& v : vertices)
    if (v.dot(coarse) >= near) {
      const Real along = dot(Vec(v), d);
      if (chosen == nullptr || along > most) most = along, chosen = &v;
    }
  return Vec(*chosen);
}

Vec PosedCore::support(const Vec& world) const {
  const Vec d{dot(columns_[0], world), dot(columns_[1], world), dot(columns_[2], world)};
  const auto signed_as = [](Real x, Real sign) { return sign < 0 ? -x : x; };
  Vec p;
  switch (shape_.kind()) {
    case ShapeKind::box: {
      const Vec h(shape_.half_size());
      p = {signed_as(h.x, d.x), signed_as(h.y, d.y), signed_as(h.z, d.z)};
      break;
    }
    case ShapeKind::capsule:
      p = {0, 0, signed_as(Real(shape_.length()) / 2, d.z)};
      break;
    case ShapeKind::cylinder:
    case ShapeKind::cone: {
      const Real half = Real(shape_.length()) / 2, r = shape_.radius();
      const Real rho = sqrt(d.x * d.x + d.y * d.y);
      const Real s = rho > 0 ? r / rho : Real(0);
      const bool apex = shape_.kind() == ShapeKind::cone && d.z * 2 * half > rho * r;
      if (apex)
        p = {0, 0, half};
      else
        p = {d.x * s, d.y * s, shape_.kind() == ShapeKind::cone ? -half : signed_as(half, d.z)};
      break;
    }
    case ShapeKind::ellipsoid: {
      const Vec r(shape_.radii());
      const Vec q{r.x * d.x, r.y * d.y, r.z * d.z};
      const Real length = norm(q);
      if (length > 0) p = Vec{r.x * q.x, r.y * q.y, r.z * q.z} / length;
      break;
    }
    case ShapeKind::convex:
    case ShapeKind::triangle:
      p = hull_support(d);
      break;
    case ShapeKind::sphere:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  return p.x * columns_[0] + p.y * columns_[1] + p.z * columns_[2] + translation_;
}

}  // namespace tandem::reference
