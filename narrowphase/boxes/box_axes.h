#pragma once
#include "shapes/convex_view.h"

namespace tandem {

/// Two boxes for the separating axis test (Gottschalk 1996): B as A sees it, and how far apart they are along each
/// face's axis and, times the product's length, along each product of edges. The fourth of each row is not used.
/// Everything but the edges comes out the same, bit for bit, with A and B exchanged, and all of it on every machine.
struct alignas(32) BoxAxes {
  double a[4], b[4];    ///< half sizes
  double r[3][4];       ///< columns: B's axes in A's frame
  double q[3][4];       ///< |r|
  double t[4];          ///< from A's centre to B's in A's frame
  double u[4];          ///< and in B's
  double face_of_a[4];  ///< separation along A's axes; > 0 apart
  double face_of_b[4];
  double edge[3][4];   ///< along a_i x b_j, times its length; for orthonormal axes
  double most_edge;    ///< and of `edge`
  double most_cosine;  ///< and of |r|
  /// Bit 3 i + j: a_i x b_j may separate better than every face, or its edges are so nearly parallel that `edge` is
  /// not exact enough to tell.
  unsigned hopeful;

  // Only where a face's axis separates by more than was asked for:
  double most_face;  ///< the largest of the faces' separations
  unsigned parting;  ///< whose that is: bits 0-2 A's faces, 4-6 B's
  unsigned against;  ///< axes that point from B to A, in the same bits
};

/// Edges whose cosine is larger count as nearly parallel: the squared sine is below 0.01.
constexpr double nearly_parallel = 0.99498743710662;

/// Fills the axes, of boxes by half sizes. Where a face's axis separates by more than `beyond` (>= 0), returns true and
/// tells only
/// by how much and which.
bool measure_axes(const double* half_a, const Pose* pose_a, const double* half_b, const Pose* pose_b, double beyond,
                  BoxAxes* axes);

}  // namespace tandem
