// The point of a simplex that is nearest the origin (Gilbert, Johnson, Keerthi 1988).
#pragma once
#include <initializer_list>

#include "shapes/minkowski_difference.h"

namespace tandem {

struct Simplex {
  MinkowskiPoint p[4];
  double weight[4];  ///< of the point nearest the origin
  int count = 0;
};

/// The point of a simplex nearest the origin: which of its points carry it, with what weights.
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
/// The point of a tetrahedron's surface that is nearest the origin.
NearestOnSimplex nearest_on_sides(const Simplex& s);
/// Leaves of the simplex the points that carry it, with their weights.
void keep_nearest(Simplex& s, const NearestOnSimplex& n);

/// Sets the weights of the simplex's points, of which it leaves at most 3, for the point nearest the origin.
void weigh(Simplex& s);

/// Sets both points of the answer by the weights: of corners of either shape, so that they lie on both.
void set_points(const Simplex& s, LocalAnswer& answer);

/// Where GJK stopped (Gilbert, Johnson, Keerthi 1988; the duality gap bounds the error).
struct GjkResult {
  enum class End { separated, near, inside } end;
  double upper = 0;       ///< distance of `v`: the cores are no farther apart
  double lower = 0;       ///< the cores are at least this far apart; <= 0 says nothing
  double along = 0;       ///< as far as they are apart along -v
  Vec3 v = Vec3::Zero();  ///< the last nearest point; -v is the direction to start a similar query from
  Simplex simplex;
};

}  // namespace tandem
