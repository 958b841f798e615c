// The Hausdorff distance of two surfaces, by branch and bound over the boxes and triangles of both.
#include "tandem/narrowphase/hausdorff.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <queue>
#include <stdexcept>
#include <string>

#include "closed_forms/closed_forms.h"
#include "meshes/mesh_pair.h"
#include "meshes/traversal/hierarchy.h"
#include "meshes/traversal/point_queries.h"
#include "shapes/posed_mesh.h"
#include "shapes/shape_insides.h"
#include "shapes/skewness.h"
#include "shapes/work_meter.h"
#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {
namespace {

double distance_to(const Corners& triangle, const Vec3& p) {
  return point_distance(TriangleView(triangle), p).signed_distance;
}

// One of the two surfaces, whose points are examined, in the frame of the other.
struct SurfaceSide {
  const MeshModel &mesh, &other;
  Mat3 turn;
  Vec3 shift;

  SurfaceSide(const Posed& own, const Posed& of_other)
      : mesh(mesh_of(own.shape)),
        other(mesh_of(of_other.shape)),
        turn(of_other.pose.rotation.inverse() * own.pose.rotation),
        shift(of_other.pose.rotation.inverse() * (own.pose.translation - of_other.pose.translation)) {}

  Vec3 placed(const Vec3& v) const { return turn * v + shift; }
};

class HausdorffSearch {
 public:
  HausdorffSearch(const Posed& a, const Posed& b, const HausdorffOptions& options)
      : options_(options), meter_(options.limit), sides_{SurfaceSide(a, b), SurfaceSide(b, a)} {}

  /// Runs until the bounds are within `slack` (metres) of each other, the upper one is at most `least` (metres), or the
  /// options end it.
  void run(double slack, double least) {
    const Vec3 corner = sides_[0].placed(sides_[0].mesh.corners(0)[0]);
    point = corner, triangle = nearest_to(0, corner).triangle;  // unless another one is farther
    for (const std::size_t side : {0u, 1u}) add_box(side, whole);
    while (!open_.empty() && parts < options_.most_parts) {
      const double most = std::max(open_.top().most, lower);
      if (most <= least || most - lower <= std::max({slack, options_.tolerance, options_.gap * most})) break;
      const Part part = open_.top();
      open_.pop();
      split(part);
    }
    upper = open_.empty() ? lower : std::max(open_.top().most, lower);
  }

  double lower = 0, upper = 0;
  std::size_t side = 0;        ///< the surface of the point at distance `lower`
  Vec3 point = Vec3::Zero();   ///< in the other's frame
  std::uint32_t triangle = 0;  ///< the nearest of the other
  std::size_t parts = 0;

 private:
  // A box of a hierarchy, or a piece of a triangle, with an upper bound on the distance of its points from the other
  // surface.
  struct Part {
    double most;
    std::size_t number, side;
    std::uint32_t box;  // no_index: a piece
    Corners piece;      // in the other's frame
    bool operator<(const Part& o) const { return most != o.most ? most < o.most : number > o.number; }
  };

  SurfacePoint nearest_to(std::size_t of, const Vec3& p) {
    meter_.spend(8);
    return nearest_point(sides_[of].other, p, options_.limit);
  }

  void raise(std::size_t of, const Vec3& p, const SurfacePoint& found) {
    if (found.distance > lower) lower = found.distance, side = of, point = p, triangle = found.triangle;
  }

  void push(Part part) {
    ++parts;
    if (part.most <= lower) return;
    part.number = parts;
    open_.push(part);
  }

  // A box's centre need not be on the surface.
  void add_box(std::size_t of, std::uint32_t ref) {
    const SurfaceSide& side_of = sides_[of];
    const BoxOf box(side_of.mesh, ref);
    const double most = nearest_to(of, side_of.placed(box.mid)).distance + box.half.norm() * (1 + tolerance::askew);
    push({most, 0, of, ref, {}});
  }

  void add_piece(std::size_t of, const Corners& piece) {
    const Vec3 middle = (piece[0] + piece[1] + piece[2]) / 3;
    const SurfacePoint near = nearest_to(of, middle);
    raise(of, middle, near);
    double most =
        near.distance + std::sqrt(std::max({(piece[0] - middle).squaredNorm(), (piece[1] - middle).squaredNorm(),
                                            (piece[2] - middle).squaredNorm()}));
    // The distance from a convex set is largest at a corner: computed from the triangle nearest to the centre, and from
    // the one nearest to the corner that is farthest from that.
    const auto farthest_from = [&](std::uint32_t t) {
      const Corners c = sides_[of].other.corners(t);
      std::array<double, 3> d;
      for (std::size_t k = 0; k < 3; ++k) d[k] = distance_to(c, piece[k]);
      const std::size_t corner = static_cast<std::size_t>(std::max_element(d.begin(), d.end()) - d.begin());
      most = std::min(most, d[corner]);
      return corner;
    };
    const std::size_t corner = farthest_from(near.triangle);
    if (most > lower) {
      const SurfacePoint there = nearest_to(of, piece[corner]);
      raise(of, piece[corner], there);
      if (there.triangle != near.triangle) farthest_from(there.triangle);
    }
    push({most, 0, of, no_index, piece});
  }

  void split(const Part& part) {
    const SurfaceSide& side_of = sides_[part.side];
    if (part.box == no_index) {
      const auto& [a, b, c] = part.piece;
      const Vec3 ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
      for (const Corners& piece : {Corners{a, ab, ca}, Corners{ab, b, bc}, Corners{ca, bc, c}, Corners{ab, bc, ca}})
        add_piece(part.side, piece);
    } else if (is_leaf(side_of.mesh, part.box)) {
      Corners corners = side_of.mesh.corners(leaf_triangle(side_of.mesh, part.box));
      for (Vec3& v : corners) v = side_of.placed(v);
      add_piece(part.side, corners);
    } else {
      each_child(side_of.mesh, part.box, [&](std::uint32_t child) { add_box(part.side, child); });
    }
  }

  const HausdorffOptions& options_;
  WorkMeter meter_;
  const std::array<SurfaceSide, 2> sides_;
  std::priority_queue<Part> open_;
};

void check(const Shape& a, const Shape& b, const HausdorffOptions& options) {
  for (const Shape* shape : {&a, &b}) {
    if (!has_triangles(*shape))
      throw std::invalid_argument("hausdorff_distance: " + std::string(name(shape->kind())) +
                                  " has no triangles, a triangle or a mesh is needed");
    if (shape->rounding() > 0)
      throw std::invalid_argument("hausdorff_distance: rounding " + written(shape->rounding()) +
                                  ", a shape without rounding is needed");
  }
  if (!(options.tolerance >= 0) || !std::isfinite(options.tolerance))
    throw std::invalid_argument("hausdorff_distance: tolerance " + written(options.tolerance) +
                                " is not finite and >= 0");
  if (!(options.least >= 0 && options.least <= 1))
    throw std::invalid_argument("hausdorff_distance: least " + written(options.least) + " is not in [0, 1]");
  if (!(options.gap >= 0 && options.gap <= 1))
    throw std::invalid_argument("hausdorff_distance: gap " + written(options.gap) + " is not in [0, 1]");
}

}  // namespace

HausdorffBounds hausdorff_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                   const HausdorffOptions& options) {
  check(a, b, options);
  require_valid(pose_a, "hausdorff_distance: pose of A");
  require_valid(pose_b, "hausdorff_distance: pose of B");
  // Exchanged arguments are searched in the same order.
  const bool in_order = goes_first({a, pose_a}, {b, pose_b});
  const Posed first = in_order ? Posed{a, pose_a} : Posed{b, pose_b};
  const Posed second = in_order ? Posed{b, pose_b} : Posed{a, pose_a};
  HausdorffSearch search(first, second, options);
  const double size = reach(mesh_of(a)) + reach(mesh_of(b)) + (pose_b.translation - pose_a.translation).lpNorm<1>();
  const double slack = tolerance::place_rounding * size;
  search.run(slack, options.least * (mesh_of(a).half + mesh_of(b).half).norm());
  // Rotations that are not orthonormal stretch distances measured in their frames.
  const double stretch = 3 * (skewness(pose_a.rotation) + skewness(pose_b.rotation));
  HausdorffBounds bounds;
  bounds.lower = std::max(0.0, search.lower * (1 - stretch) - slack);
  bounds.upper = search.upper * (1 + stretch) + slack;
  bounds.of_a = (search.side == 0) == in_order;
  const Pose& of_other = bounds.of_a ? pose_b : pose_a;
  const MeshModel& other = mesh_of(bounds.of_a ? b : a);
  bounds.point = of_other * search.point;
  if (search.lower > 0)
    bounds.nearest = of_other * point_distance(TriangleView(other.corners(search.triangle)), search.point).nearest;
  else
    bounds.nearest = bounds.point;
  bounds.parts = search.parts;
  return bounds;
}

}  // namespace tandem
