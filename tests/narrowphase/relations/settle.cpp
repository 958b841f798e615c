// Pairs at rest: B is moved against A until it touches, and slides along what it touches until it touches more.
#include "settle.h"

#include <Eigen/QR>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "draw.h"
#include "mesh_samples.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "unusual.h"

namespace tandem::relations {
namespace {

constexpr double lift = 1e-9;          // of the size: B slides that far above what it touches
constexpr double far_out = 10;         // metres: farther from the origin rounding decides what touches
constexpr double most_sunk = 2.5;      // decimal exponent of how far B is pushed in, of its size
constexpr double least_sunk = 13;      // the same
constexpr double already_sunk = 1e-9;  // of the size: a motion that ends deeper did not end at a touch
constexpr double hardly_into = 1e-12;  // cosine: rounding of a direction along a face
constexpr double least_slide = 0.05;   // of the length of a direction that was turned along the touched faces

/// The shortest translation with these products with the normals.
Vec3 least_translation(const std::vector<Vec3>& normals, const Eigen::VectorXd& along) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(normals.size()), 3);
  for (std::size_t i = 0; i < normals.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = normals[i];
  return rows.completeOrthogonalDecomposition().solve(along);
}

/// A direction near `d` that leads into none of the touched places; zero if none is found.
Vec3 sliding(Vec3 d, const std::vector<Vec3>& normals) {
  constexpr int passes = 30;
  for (int pass = 0; pass < passes; ++pass)
    for (const Vec3& n : normals) d -= std::min(0.0, n.dot(d)) * n;
  for (const Vec3& n : normals)
    if (n.dot(d) < -hardly_into) return Vec3::Zero();
  return d.norm() < least_slide ? Vec3(Vec3::Zero()) : Vec3(d.normalized());
}

/// A box within a box.
Mesh room(Random& r) {
  const Vec3 size = r.vec(0.5, 2);
  return test::with_hollow(test::box_mesh(Vec3(size + Vec3::Constant(0.5)), 1), test::box_mesh(size, 1 + r.below(2)));
}

Voxels few_cells(Random& r) {
  Voxels v;
  v.cell_size = (1 + r.below(8)) / 8.0;
  for (const auto& place : grid_places(2 + r.below(12), r)) v.cells.push_back({place, 0});
  return v;
}

/// A solid with corners, or nothing for the drawn shape. `is_room`: B starts inside.
std::optional<ShapeData> place_with_corners(Random& r, bool& is_room) {
  is_room = false;
  switch (r.below(8)) {
    case 0:
    case 1:
      return cubes((1 + r.below(8)) / 8.0, r);
    case 2:
      return land(r.once_in(2) ? 0.5 : r.in(0.1, 1), r);
    case 3:
      is_room = true;
      return room(r);
    case 4: {
      const int sides = 4 + r.below(5), segments = 5 + r.below(8);
      return test::torus(1, r.in(0.15, 0.6), segments, sides);
    }
    case 5:
      return few_cells(r);
    default:
      return std::nullopt;
  }
}

/// Moves B along directions until it touches, up to three times. The normals of what it touches at the end, from A to
/// B; none if a motion ended in an overlap.
std::vector<Vec3> slide(PosedPair& p, const Shape& a, const Shape& b, Vec3 direction, Random& r) {
  const NarrowPhase solver;
  const double size = reach(p.a) + reach(p.b), up = lift * size;
  std::vector<Vec3> normals;
  const auto all = [&](double value) {
    return Eigen::VectorXd(Eigen::VectorXd::Constant(static_cast<Eigen::Index>(normals.size()), value));
  };
  for (int left = 1 + r.below(3); left > 0; --left, direction = r.direction()) {
    const Vec3 along = sliding(direction, normals);
    if (along.isZero(0)) break;
    Pose pose = p.b.pose;
    if (!normals.empty()) pose.translation += least_translation(normals, all(up));
    const std::optional<double> path = solver.time_of_impact(a, p.a.pose, Vec3::Zero(), b, pose, along, 4 * size);
    if (!path) continue;
    pose.translation += *path * along;
    const PairAnswer at = solver.solve(a, p.a.pose, b, pose, Request::distance);
    if (at.signed_distance < -already_sunk * size) return {};
    normals.push_back(at.normal);
    Eigen::VectorXd down = all(-up);
    down[down.size() - 1] = 0;
    pose.translation += least_translation(normals, down);
    p.b.pose = pose;
  }
  return normals;
}

void settle_drawn(PosedPair& p, Random& r) {
  bool is_room = false;
  if (auto corners = place_with_corners(r, is_room)) p.a.shape = std::move(*corners);
  if (p.a.pose.translation.norm() > far_out) p.a.pose.translation = Vec3::Zero();
  const Shape a = make_shape(p.a), b = make_shape(p.b);
  if (r.once_in(2)) p.b.pose.rotation = p.a.pose.rotation * exact_rotation(r);
  const Vec3 direction = r.direction(), target = r.vec(-0.7, 0.7) * reach(p.a);
  p.b.pose.translation = p.a.pose * Vec3(is_room ? 0.2 * target : target);
  if (!is_room) p.b.pose.translation += 2 * (reach(p.a) + reach(p.b)) * direction;
  if (NarrowPhase().solve(a, p.a.pose, b, p.b.pose, Request::collide).collide) return;
  const Vec3 first = is_room ? r.direction() : Vec3(-direction);
  for (const Vec3& n : slide(p, a, b, first, r)) {
    if (r.once_in(2)) continue;
    const double sunk = small(r, most_sunk, least_sunk) * reach(p.b);
    p.b.pose.translation -= sunk * n;
  }
}

}  // namespace

void settle(PosedPair& p, Random& r) {
  change_if_allowed(p, [&](PosedPair& changed) { settle_drawn(changed, r); });
}

}  // namespace tandem::relations
