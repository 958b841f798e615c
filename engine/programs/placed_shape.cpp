#include "placed_shape.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "hull.h"
#include "mesh_model.h"

namespace tandem {
namespace {

/// A cylinder or cone with a rest, from inside.
class InnerHull {
 public:
  explicit InnerHull(const PlacedShape& placed) : of_(placed) {
    constexpr int around = 24;
    constexpr double turn = 2 * 3.14159265358979323846 / around;
    if (is_cone()) points_.push_back(rest() * Vec3(0, 0, half()));
    for (int i = 0; i < around; ++i) add_sides(i * turn);
  }

  Shape shape() const { return Convex{points_}; }

  /// How much farther along n, in world axes, the shape reaches than it would without the rest.
  double rest_adds(const Vec3& n) const {
    const Vec3 local = of_.pose.rotation.transpose() * n;
    return reach(rest().transpose() * local) - reach(local);
  }

  /// How much farther than the hull the shape reaches along n, in world axes; its points there are added, and those
  /// `beside` them, radians around the axis.
  double grow(const Vec3& n, double beside) {
    const Vec3 local = of_.pose.rotation.transpose() * n, m = rest().transpose() * local;
    double known = local.dot(points_[0]);
    for (const Vec3& p : points_) known = std::max(known, local.dot(p));
    const double beyond = std::max(reach(m) - known, 0.0);
    if (m[0] == 0 && m[1] == 0) return beyond;
    const double angle = std::atan2(m[1], m[0]);
    add_sides(angle);
    if (beside > 0) add_sides(angle - beside), add_sides(angle + beside);
    return beyond;
  }

 private:
  bool is_cone() const { return of_.shape.kind() == ShapeKind::cone; }
  double half() const { return 0.5 * of_.shape.length(); }
  const Mat3& rest() const { return *of_.rest; }

  /// How far the shape as it is, in its own frame, reaches along m.
  double reach(const Vec3& m) const {
    const double side = of_.shape.radius() * std::hypot(m[0], m[1]);
    return is_cone() ? std::max(side - half() * m[2], half() * m[2]) : side + half() * std::abs(m[2]);
  }

  void add_sides(double angle) {
    const double x = of_.shape.radius() * std::cos(angle), y = of_.shape.radius() * std::sin(angle);
    points_.push_back(rest() * Vec3(x, y, -half()));
    if (!is_cone()) points_.push_back(rest() * Vec3(x, y, half()));
  }

  const PlacedShape& of_;
  std::vector<Vec3> points_;
};

}  // namespace

PlacedShape place(const Shape& shape, const Pose& pose) {
  PlacedShape out{shape, orthonormalized(pose), {}};
  if (out.pose.rotation == pose.rotation) return out;
  const Mat3 rest = out.pose.rotation.transpose() * pose.rotation;
  switch (shape.kind()) {
    case ShapeKind::sphere:
      break;
    case ShapeKind::box: {
      Convex corners;
      for (unsigned i = 0; i < 8; ++i)
        corners.vertices.push_back(
            rest * shape.half_size().cwiseProduct(Vec3(i & 1u ? 1 : -1, i & 2u ? 1 : -1, i & 4u ? 1 : -1)));
      out.shape = corners;
      break;
    }
    case ShapeKind::capsule: {
      const Vec3 along = rest.col(2);
      out.pose.rotation *= Quat::FromTwoVectors(Vec3::UnitZ(), along).toRotationMatrix();
      out.shape = Capsule{shape.radius(), shape.length() * along.norm()};
      break;
    }
    case ShapeKind::ellipsoid: {
      const Eigen::JacobiSVD<Mat3> svd(rest * shape.radii().asDiagonal(), Eigen::ComputeFullU);
      Mat3 axes = svd.matrixU();
      if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
      out.pose.rotation *= axes;
      out.shape = Ellipsoid{svd.singularValues()};
      break;
    }
    case ShapeKind::convex: {
      Convex corners{shape.hull().vertices};
      for (Vec3& v : corners.vertices) v = rest * v;
      out.shape = corners;
      break;
    }
    case ShapeKind::triangle:
    case ShapeKind::mesh: {
      const MeshModel& model = shape.mesh();
      Mesh mesh{model.vertices, model.triangles, model.solid};
      for (Vec3& v : mesh.vertices) v = rest * v;
      if (shape.kind() == ShapeKind::mesh)
        out.shape = Shape(std::move(mesh));
      else
        out.shape = Triangle{{mesh.vertices[0], mesh.vertices[1], mesh.vertices[2]}};
      break;
    }
    case ShapeKind::halfspace:
      out.shape = HalfSpace{rest.transpose().inverse() * shape.normal(), shape.offset()};
      break;
    case ShapeKind::cylinder:
    case ShapeKind::cone:
      out.rest = rest;
      break;
  }
  return out;
}

PairAnswer solve(const NarrowPhase& narrow_phase, const PlacedShape& a, const PlacedShape& b, Request request,
                 std::vector<Contact>* contacts) {
  if (!a.rest && !b.rest) return narrow_phase.solve(a.shape, a.pose, b.shape, b.pose, request, contacts);
  constexpr int most_rounds = 40;
  const double size = std::max(a.shape.size(), b.shape.size());
  std::optional<InnerHull> hull_a, hull_b;
  if (a.rest) hull_a.emplace(a);
  if (b.rest) hull_b.emplace(b);
  // Along the normal without the rests, and how far apart the bodies are along it with them: never too much.
  PairAnswer along = narrow_phase.solve(a.shape, a.pose, b.shape, b.pose, Request::distance);
  along.signed_distance -=
      (hull_a ? hull_a->rest_adds(along.normal) : 0.0) + (hull_b ? hull_b->rest_adds(-along.normal) : 0.0);
  double beside = 1e-2;
  for (int round = 0;; ++round) {
    const Shape in_a = hull_a ? hull_a->shape() : a.shape, in_b = hull_b ? hull_b->shape() : b.shape;
    PairAnswer answer = narrow_phase.solve(in_a, a.pose, in_b, b.pose, Request::distance);
    double beyond = 0;
    if (hull_a) beyond += hull_a->grow(answer.normal, beside);
    if (hull_b) beyond += hull_b->grow(-answer.normal, beside);
    const bool fine = beside == 0;
    beside = beside > 2e-8 ? 0.1 * beside : 0;
    if (round < most_rounds && !(fine && beyond <= 1e-14 * size)) continue;
    if (request == Request::contacts) (void)narrow_phase.solve(in_a, a.pose, in_b, b.pose, request, contacts);
    if (beyond > 1e-14 * size) {
      // So many ways out are alike that the hull cannot follow all: known is the best of those looked at.
      const double least = answer.signed_distance - beyond, above = answer.signed_distance;
      if (along.signed_distance > least) answer = along;
      answer.signed_distance = std::max(least, along.signed_distance);
      answer.point_b = answer.point_a + answer.signed_distance * answer.normal;
      answer.error_bound += std::max(above - answer.signed_distance, 0.0);
    }
    answer.collide = answer.signed_distance <= 0;
    answer.status = answer.error_bound > 1e-9 * size ? Status::inexact : Status::ok;
    return answer;
  }
}

}  // namespace tandem
