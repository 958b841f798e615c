// Computes a capsule inside a solid mesh, and its intersection with other shapes.
#include "meshes/traversal/inner_capsule.h"

#include <algorithm>
#include <cmath>

#include "closed_forms/closed_forms.h"
#include "closed_forms/surface_distance.h"
#include "meshes/traversal/mesh_convex_pair.h"
#include "meshes/traversal/point_in_mesh.h"
#include "shapes/convex_view.h"
#include "shapes/shape_insides.h"
#include "shapes/support.h"
#include "tolerances.h"

namespace tandem {
namespace {

// In a tube all triangles are equally near to the axis, so each of them is solved.
constexpr std::size_t most_triangles = 8192;

/// The radius of the largest ball about each point of the segment from -half to half about the box's middle that keeps
/// to one side of the surface, to rounding.
double inner_radius(const Shape& mesh, const Vec3& half, const WorkLimit* limit) {
  const MeshModel& model = mesh_of(mesh);
  NarrowPhaseOptions options;
  options.limit = limit;
  const double thin = tolerance::askew_in_floats * mesh.size();
  const Shape along = half.isZero(0) ? Shape(Sphere{thin}) : Shape(Capsule{thin, 2 * half.norm()});
  Pose pose{Mat3::Identity(), model.centre};
  pose.rotation = Quat::FromTwoVectors(Vec3::UnitZ(), half.isZero(0) ? Vec3::UnitZ() : Vec3(half)).toRotationMatrix();
  return MeshConvexPair({mesh, Pose{}}, {along, pose}, options).nearest().signed_distance;
}

InnerCapsule find_inner_capsule(const Shape& mesh, const WorkLimit* limit) {
  const MeshModel& model = mesh_of(mesh);
  InnerCapsule best{model.centre, Vec3::Zero(), 0};
  if (!model.solid || model.triangles.size() > most_triangles || !is_inside(model, model.centre, limit)) return best;
  Eigen::Index axis;
  const double longest = model.half.maxCoeff(&axis);
  // The thin shapes below must have allowed sizes.
  if (!(tolerance::askew_in_floats * mesh.size() >= tolerance::shortest_length) ||
      !(2 * longest <= tolerance::longest_length))
    return best;
  double most = 0;
  for (const double part : {0.0, 0.5, 0.75, 0.9}) {
    const Vec3 half = part * longest * Vec3::Unit(axis);
    const double radius = inner_radius(mesh, half, limit);
    const double volume = radius * radius * (2 * part * longest + 4.0 / 3 * radius);  // over pi
    if (radius > 0 && volume > most) most = volume, best = {model.centre, half, radius};
  }
  return best;
}

/// The radius, less the errors of rotations that are not quite orthonormal and of positions.
double certain(double radius, const InnerCapsule& inner, const Vec3& own, const Posed& mesh, const Posed& other) {
  return radius -
         tolerance::askew_in_floats * (mesh.shape.size() + other.shape.size() + inner.centre.norm() + own.norm());
}

bool meets_other(const InnerCapsule& inner, const Posed& mesh, const Posed& other) {
  const RelativePose to_mesh = relative(mesh.pose, other.pose);
  if (other.shape.kind() == ShapeKind::mesh) {
    const InnerCapsule* const in_other = mesh_of(other.shape).inner_capsule().made();
    if (in_other == nullptr || !(in_other->radius > 0)) return false;
    const double distance =
        segment_distance(inner.centre, inner.half, to_mesh.rotation * in_other->centre + to_mesh.translation,
                         to_mesh.rotation * in_other->half)
            .distance;
    return distance < certain(inner.radius + in_other->radius, inner, in_other->centre, mesh, other);
  }
  const ConvexView convex = view(other.shape);
  const Vec3 own = convex.hull != nullptr ? convex.hull->inside : Vec3(0, 0, 0);
  const Vec3 middle = to_mesh.rotation * own + to_mesh.translation;
  const double square = inner.half.squaredNorm();
  const double along = square > 0 ? std::clamp(inner.half.dot(middle - inner.centre) / square, -1.0, 1.0) : 0.0;
  const Vec3 near = inner.centre + along * inner.half;
  // The convex shape extends from its middle towards the segment at least by its exit length.
  const Vec3 between = near - middle;
  const double length = between.norm(), radius = certain(inner.radius, inner, own, mesh, other);
  if (length < radius) return true;
  if (!(radius > 0) || (convex.hull != nullptr && convex.hull->faces.size() > most_faces_in_turn)) return false;
  const double exit = tandem::exit_length(convex, own, to_mesh.rotation.transpose() * (between / length));
  return std::isfinite(exit) && length - exit < radius;
}

}  // namespace

void make_inner_capsule(const Shape& mesh, const WorkLimit* limit) {
  mesh_of(mesh).inner_capsule().get(limit, [&](const WorkLimit* own) { return find_inner_capsule(mesh, own); });
}

bool meets_inner_capsule(const Posed& mesh, const Posed& other) {
  const InnerCapsule* const inner = mesh_of(mesh.shape).inner_capsule().made();
  return inner != nullptr && inner->radius > 0 && meets_other(*inner, mesh, other);
}

}  // namespace tandem
