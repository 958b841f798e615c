// The point nearest the origin of the hull of points in a plane.
#pragma once

namespace tandem {

/// A sum of two bodies' points in a plane.
struct PlaneSum {
  double x, y;
  int i, j;  ///< indices: the first body's point i and the second's j
};

/// The point nearest the origin of the hull of points in the plane, and the at most three points that support it.
struct NearestFlat {
  double x = 0, y = 0;
  int index[3] = {0, 0, 0};
  double weight[3] = {1, 0, 0};
  int count = 1;
};
/// For `count` >= 1 points.
NearestFlat nearest_flat(const PlaneSum* p, int count);

/// True if the origin is in the interior of the points' hull.
bool surrounded(const PlaneSum* p, int count, double tolerance);

}  // namespace tandem
