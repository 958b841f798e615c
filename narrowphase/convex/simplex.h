// The point of a simplex nearest the origin (Gilbert, Johnson, Keerthi 1988).
#pragma once
#include <initializer_list>

#include "shapes/minkowski_difference.h"

namespace tandem {

struct Simplex {
  MinkowskiPoint p[4];
  double weight[4];  ///< barycentric coordinates of the point nearest the origin
  int count = 0;
};

/// The point of a simplex nearest the origin, with the simplex's points that support it and their weights.
struct NearestOnSimplex {
  Vec3 v;
  double squared = infinity;
  int index[4];
  double weight[4];
  int count = 0;
  bool inside = false;

  void take(const Vec3& point, std::initializer_list<int> which, std::initializer_list<double> weights) {
    v = point;
    squared = point.squaredNorm();
    count = 0;
    for (const int i : which) index[count++] = i;
    std::copy(weights.begin(), weights.end(), weight);
  }
};

NearestOnSimplex nearest_to_origin(const Simplex& s);
/// The point of a tetrahedron's surface nearest the origin.
NearestOnSimplex nearest_on_sides(const Simplex& s);
/// Reduces the simplex to the points that support the nearest point, with their weights.
void keep_nearest(Simplex& s, const NearestOnSimplex& n);

/// The distance of the farthest point from the origin.
double farthest_from_origin(const Simplex& s);
/// True if the simplex is a tetrahedron that is not thin: the expanding polytope then begins with it, without weights.
bool is_solid(const MinkowskiDifference& d, const Simplex& s);

/// Sets the weights for the point nearest the origin, and keeps at most 3 points.
void set_weights(Simplex& s);

/// Sets both points of the answer by the weights: combinations of either shape's points, so that they lie on both.
void set_points(const Simplex& s, LocalAnswer& answer);

/// The state in which GJK stopped (Gilbert, Johnson, Keerthi 1988; the duality gap bounds the error).
struct GjkResult {
  enum class End { separated, near, inside } end;
  double upper = 0;  ///< length of `v`: upper bound on the distance
  double lower = 0;  ///< the largest separation along a direction: lower bound on the distance, and on -depth
  Vec3 direction = Vec3::Zero();  ///< unit vector from A to B, the last that separates by `lower`, to rounding
  Vec3 v = Vec3::Zero();          ///< the last nearest point
  Simplex simplex;

  /// The normal of cores that are apart: `direction`, or that of the nearest point where this lies aside by more than
  /// the slack (metres): from afar, directions that differ separate by the same distance, to rounding.
  Vec3 normal(double slack) const { return (v + upper * direction).norm() > slack ? Vec3(-unit(v, upper)) : direction; }
};

}  // namespace tandem
