#pragma once
#include <array>
#include <memory>

#include "tandem/narrowphase/pose.h"

namespace tandem {

class ExactPlaces;  // predicates.cpp

/// Do closed triangles of two posed meshes meet? Exact for the real numbers R v + t: coplanar, touching and zero-area
/// triangles (a segment, a point) included. Doubles with an error bound decide; only the signs that lie within the
/// bound are computed again, in integers. One for each query: it keeps what exact arithmetic needs of the poses.
class TriangleTest {
 public:
  /// `reach_b`: an upper bound on the coordinates of B's vertices in B's frame, absolute.
  TriangleTest(const Pose& pose_a, const Pose& pose_b, double reach_b);
  ~TriangleTest();

  /// A point of B in A's frame, within delta() of the exact place in every coordinate.
  Vec3 in_a(const Vec3& v) const { return map_ * v + shift_; }
  const Mat3& map() const { return map_; }
  const Vec3& shift() const { return shift_; }
  double delta() const { return delta_; }

  /// Where coordinates of both triangles differ by `span` at most, a determinant of three differences of places is
  /// wrong by less than span² (of_places() + tolerance::determinant_rounding span): every difference is wrong by 2
  /// delta plus its rounding, the determinant by less than 6 span² (6 delta + 10 u span), u = 2^-53.
  double of_places() const { return 48 * delta_; }

  /// Triangle `a` in A's frame, `b` in B's, and the same corners of B through in_a().
  bool operator()(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b, const std::array<Vec3, 3>& b_in_a);

  /// Do they meet, by exact arithmetic alone?
  bool exact(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

  const ExactPlaces& places();

 private:
  Pose pose_a_, pose_b_;  // for exact arithmetic: those given, or none where both are the same
  Mat3 map_;              // RA^-1 RB
  Vec3 shift_;            // RA^-1 (tB - tA)
  double delta_;
  std::unique_ptr<ExactPlaces> places_;  // once they are needed
};

}  // namespace tandem
