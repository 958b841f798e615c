// The separating axis test of two boxes.
#pragma once
#include "shapes/convex_view.h"

namespace tandem {

/// Two boxes in the separating axis test (Gottschalk 1996): B in A's frame, and the separations along each face normal
/// and along each cross product of edges, the latter times the product's length. The fourth number of each row is
/// unused. Everything but the edges comes out the same, bit for bit, with A and B exchanged, and all of it on every
/// machine.
struct alignas(32) BoxAxes {
  double a[4], b[4];    ///< half sizes
  double r[3][4];       ///< columns: B's axes in A's frame
  double q[3][4];       ///< |r|
  double t[4];          ///< from A's centre to B's, in A's frame
  double u[4];          ///< the same in B's frame
  double face_of_a[4];  ///< separation along A's axes; > 0: apart
  double face_of_b[4];
  double edge[3][4];   ///< separation along a_i x b_j, times its length, for orthonormal axes
  double most_edge;    ///< the largest of `edge`
  double most_cosine;  ///< the largest of |r|
  /// Bit 3 i + j: a_i x b_j may separate better than every face, or its edges are so nearly parallel that `edge` is too
  /// inexact to tell.
  unsigned hopeful;

  // Set only if a face's axis separates by more than was asked for:
  double most_face;  ///< the largest separation along a face normal
  unsigned parting;  ///< the axis of that: bits 0-2 A's faces, 4-6 B's
  unsigned against;  ///< axes that point from B to A, in the same bits
};

/// Cosine above which two edges count as nearly parallel: the squared sine is below 0.01.
constexpr double nearly_parallel = 0.99498743710662;

/// Fills the axes, of boxes by half sizes. If a face's axis separates by more than `beyond` (>= 0), returns true and
/// sets only the members for that case.
bool measure_axes(const double* half_a, const Pose* pose_a, const double* half_b, const Pose* pose_b, double beyond,
                  BoxAxes* axes);

}  // namespace tandem
