// Exact tests of intersecting triangles.
#pragma once
#include <array>
#include <memory>

#include "tandem/narrowphase/pose.h"

namespace tandem {

class ExactPlaces;  // exact_triangles.h

/// Tests whether closed triangles of two posed meshes intersect. Exact for the real numbers R v + t, with coplanar,
/// touching and degenerate triangles (a segment, a point) included. Doubles with an error bound decide; only signs
/// within the bound are computed again, in integers. One object for each query: it keeps the exact poses.
class TriangleTest {
 public:
  /// `reach_b`: an upper bound on the absolute coordinates of B's vertices in B's frame.
  TriangleTest(const Pose& pose_a, const Pose& pose_b, double reach_b);
  ~TriangleTest();

  /// A point of B in A's frame, within delta() of the exact position in every coordinate.
  Vec3 in_a(const Vec3& v) const { return map_ * v + shift_; }
  const Mat3& map() const { return map_; }
  const Vec3& shift() const { return shift_; }
  double delta() const { return delta_; }

  /// If coordinates of both triangles differ by at most `span`, the error of a determinant of three differences of
  /// positions is below span² (of_places() + tolerance::determinant_rounding span): every difference has an error of 2
  /// delta plus its rounding, the determinant of less than 6 span² (6 delta + 10 u span), u = 2^-53.
  double of_places() const { return 48 * delta_; }

  /// True if triangle `a` in A's frame and `b` in B's intersect; `b_in_a`: the corners of B through in_a().
  bool operator()(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b, const std::array<Vec3, 3>& b_in_a);

  /// The same by exact arithmetic alone.
  bool exact(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

  const ExactPlaces& places();

 private:
  Pose pose_a_, pose_b_;  // for exact arithmetic: the given poses, or identities if both are the same
  Mat3 map_;              // RA^-1 RB
  Vec3 shift_;            // RA^-1 (tB - tA)
  double delta_;
  std::unique_ptr<ExactPlaces> places_;  // made on first use
};

}  // namespace tandem
