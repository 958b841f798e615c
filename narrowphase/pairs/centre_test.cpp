// Quick certain tests of two convex shapes by the line between their centres.
#include "pairs/centre_test.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shapes/hull.h"
#include "shapes/kind_rows.h"
#include "shapes/shape_insides.h"
#include "shapes/support_kernel.h"
#include "shapes/unit_vector.h"
#include "shapes/without_hull.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// True if the inscribed ball of the shape is about its origin.
bool is_centred(const Shape& s) {
  constexpr KindSet centred = kinds_where([](const KindRow& row) { return row.centred; });
  return centred.has(s.kind());
}

/// The centre of a ball inside the shape, in its frame.
Vec3 inner_centre(const Shape& s) {
  if (is_centred(s)) return Vec3::Zero();
  return s.kind() == ShapeKind::cone ? Vec3(0, 0, -0.25 * s.length()) : hull_of(s).inside;
}

[[gnu::always_inline]] inline double inner_radius(const Shape& s) {
  switch (s.kind()) {
    case ShapeKind::box:
    case ShapeKind::ellipsoid:
      return s.half_size().minCoeff();  // an ellipsoid's radii
    case ShapeKind::cylinder:
      return std::min(s.radius(), 0.5 * s.length());
    case ShapeKind::cone: {
      const double r = s.radius(), l = s.length();
      return std::min(0.25 * l, 0.75 * l * r / std::sqrt(r * r + l * l));
    }
    case ShapeKind::convex:
    case ShapeKind::triangle:
      return hull_of(s).inner_radius;
    case ShapeKind::sphere:
    case ShapeKind::capsule:
      return s.radius();
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;  // not passed
  }
  return 0;
}

/// For a hull: the cheap upper bound, or the support to rounding.
enum class Reach { at_most, exact };

double reach(const Hull& hull, const Vec3& d, Reach kind) {
  if (!hull.support.empty()) {
    if (kind == Reach::at_most) return reach_kernel()(hull.support, d.data());
    return (hull.vertices[support_kernel()(hull.support, hull.vertices.data(), d.data())] - hull.inside).dot(d);
  }
  double most = -std::numeric_limits<double>::infinity();
  for (const Vec3& v : hull.vertices) most = std::max(most, (v - hull.inside).dot(d));
  return most;
}

/// The support of the shape along d (any length) relative to the centre of its ball, times that length.
[[gnu::always_inline]] inline double reach(const Shape& s, const Vec3& d, Reach kind) {
  const auto across = [&] { return s.radius() * std::sqrt(d[0] * d[0] + d[1] * d[1]); };
  switch (s.kind()) {
    case ShapeKind::sphere:
      return s.radius() * d.norm();
    case ShapeKind::box:
      return s.half_size().dot(d.cwiseAbs());
    case ShapeKind::ellipsoid:
      return s.radii().cwiseProduct(d).norm();
    case ShapeKind::capsule:
      return s.radius() * d.norm() + 0.5 * s.length() * std::abs(d[2]);
    case ShapeKind::cylinder:
      return across() + 0.5 * s.length() * std::abs(d[2]);
    case ShapeKind::cone:
      return std::max(0.75 * s.length() * d[2], across() - 0.25 * s.length() * d[2]);
    case ShapeKind::convex:
    case ShapeKind::triangle:
      return reach(hull_of(s), d, kind);
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;  // not passed
  }
  return std::numeric_limits<double>::infinity();
}

/// The vector between points of A and B, in world directions; exactly the opposite with A and B exchanged.
Vec3 from_to(const Vec3& a, const Pose& pose_a, const Vec3& b, const Pose& pose_b) {
  return (pose_b.translation - pose_a.translation) + (pose_b.rotation * b - pose_a.rotation * a);
}

}  // namespace

CentreTest test_centres(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin) {
  // Rotations are taken as given: they map balls to ellipsoids. Most shapes' centres are their origins, which need no
  // rotation and no square root.
  const bool centred = is_centred(a) && is_centred(b);
  const Vec3 in_a = inner_centre(a), in_b = inner_centre(b);
  const Vec3 between = centred ? Vec3(pose_b.translation - pose_a.translation) : from_to(in_a, pose_a, in_b, pose_b);
  const double length2 = between.squaredNorm();
  const double offset = centred ? 0.0 : in_a.norm() + in_b.norm();
  const double inner = (1 - tolerance::askew) * (inner_radius(a) + inner_radius(b)) - tolerance::certain * offset;
  if (inner > 0 && length2 < inner * inner) return {CentreTest::Verdict::overlapping};

  const double covered = reach(a, pose_a.rotation.transpose() * between, Reach::at_most) +
                         reach(b, -(pose_b.rotation.transpose() * between), Reach::at_most);
  const bool rooted = !centred || margin > 0;
  const double length = rooted ? std::sqrt(length2) : 0.0;
  const double apart = length2 - covered - tolerance::certain * (length2 + std::abs(covered) + length * offset);
  if (!(apart > margin * length)) return {};
  return {CentreTest::Verdict::apart, between};
}

double separation(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& n) {
  return n.dot(from_to(inner_centre(a), pose_a, inner_centre(b), pose_b)) -
         (reach(a, pose_a.rotation.transpose() * n, Reach::exact) +
          reach(b, -(pose_b.rotation.transpose() * n), Reach::exact));
}

namespace {

Vec3 inner_centre(const Hull& hull) { return hull.inside; }
double inner_radius(const Hull& hull) { return hull.inner_radius; }

/// The separation of a mesh's hull from another one, or from a convex shape, along the line between the centres.
/// `size`: of both shapes.
template <class Other>
MeshGap gap_between_centres(const Hull& a, const Pose& pose_a, const Other& b, const Pose& pose_b, double size) {
  const Vec3 in_b = inner_centre(b), between = from_to(a.inside, pose_a, in_b, pose_b);
  const double length2 = between.squaredNorm(), inner = a.inner_radius + inner_radius(b);
  if (length2 < tolerance::balls_overlap2 * inner * inner) return {};
  const double covered = reach(a, pose_a.rotation.transpose() * between, Reach::at_most) +
                         reach(b, -(pose_b.rotation.transpose() * between), Reach::at_most);
  const double length = std::sqrt(length2);
  const double slack = tolerance::certain * (a.inside.norm() + in_b.norm()) + tolerance::outside_of_hull * size;
  const double apart = length2 - covered - tolerance::certain * (length2 + std::abs(covered)) - length * slack;
  if (!(apart > 0)) return {};
  return {apart / length, between / length};
}

}  // namespace

MeshGap test_hulls(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const WorkLimit* limit) {
  if (does_without_hull(mesh_of(a)) || does_without_hull(mesh_of(b))) return {};
  return gap_between_centres(mesh_of(a).hull(limit), pose_a, mesh_of(b).hull(limit), pose_b, a.size() + b.size());
}

double test_hull(const Shape& mesh, const Pose& pose_mesh, const Shape& convex, const Pose& pose_convex,
                 const WorkLimit* limit) {
  if (does_without_hull(mesh_of(mesh))) return 0;
  return gap_between_centres(mesh_of(mesh).hull(limit), pose_mesh, convex, pose_convex, mesh.size() + convex.size())
      .at_least;
}

}  // namespace tandem
