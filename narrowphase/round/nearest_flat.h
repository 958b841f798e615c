// Points of a plane: which of their hull's points is nearest the origin.
#pragma once

namespace tandem {

/// A sum of two bodies' points in a plane.
struct PlaneSum {
  double x, y;
  int i, j;  ///< of the first body's point i and the second's j
};

/// The point nearest the origin of the hull of points in the plane, and the at
/// most three that carry it.
struct NearestFlat {
  double x = 0, y = 0;
  int index[3] = {0, 0, 0};
  double weight[3] = {1, 0, 0};
  int count = 1;
};
/// Of `count` >= 1 points.
NearestFlat nearest_flat(const PlaneSum* p, int count);

/// Is the origin inside the hull of the points, and not on its border?
bool surrounded(const PlaneSum* p, int count, double tolerance);

}  // namespace tandem
