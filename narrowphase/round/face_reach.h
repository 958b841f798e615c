// The support of a polytope and a round body along the polytope's face normals.
#pragma once
#include <cstdint>

#include "shapes/face_table.h"
#include "shapes/round_body.h"

namespace tandem {

/// The common support of a box, a triangle or a hull with an area, and a body with a circle, along the normals of the
/// polytope's faces, with bounds on the arcs of directions between them. A triangle and a flat polygon have two faces,
/// 0 and 1, and one more across each edge, in their plane: 2 + i from the triangle's corner i on, or of the hull's edge
/// i.
class FaceReach {
 public:
  static constexpr std::size_t most = 512;  ///< for more faces no bounds are known

  void measure(const RoundBody& polytope, const RoundBody& circle);
  bool known() const { return count_ > 0; }

  std::size_t faces() const { return count_; }
  /// Unit, in the common frame.
  Vec3 normal(std::size_t face) const { return (axes_ * Vec3(m_[0][face], m_[1][face], m_[2][face])).normalized(); }

  struct Least {
    std::size_t face = 0;
    double h = 0;
  };
  Least least() const;

  /// True if the support is at least `limit` > 0 all along the arc between two adjacent faces' normals. The points that
  /// are farthest at its ends support at least as much as where the two are equal, or at the ends.
  bool reaches(std::size_t f, std::size_t g, double limit) const {
    if (f >= count_ || g >= count_) return false;
    const double from_at_g = base_[g] + along(g, f);
    if (from_at_g >= limit && h_[f] >= limit) return true;
    const double to_at_f = base_[f] + along(f, g);
    if (to_at_f >= limit && h_[g] >= limit) return true;
    const double p = std::max(0.0, h_[g] - from_at_g), q = std::max(0.0, h_[f] - to_at_f);
    const double cosine = m_[0][f] * m_[0][g] + m_[1][f] * m_[1][g] + m_[2][f] * m_[2][g];
    // The normals of a thin plate's faces are half a turn apart: the level and the length below are then differences
    // of nearly equal terms.
    constexpr double rounding = 16 * epsilon;
    const double largest = std::max({h_[f], h_[g], std::abs(from_at_g), std::abs(to_at_f)});
    const double level = std::min(p * h_[f] + q * from_at_g, p * to_at_f + q * h_[g]) - rounding * (p + q) * largest;
    const double length2 = p * p + q * q + 2 * p * q * cosine + rounding * (p + q) * (p + q);
    return level >= 0 && level * level >= limit * limit * length2;
  }

 private:
  /// The support along the normal of face f of the circle's point that is farthest along face g's.
  double along(std::size_t f, std::size_t g) const {
    return m_[0][f] * s_[0][g] + m_[1][f] * s_[1][g] + m_[2][f] * s_[2][g];
  }

  std::size_t count_ = 0;
  Mat3 axes_;          ///< of the circle
  double m_[3][most];  ///< the normals in the circle's axes
  double s_[3][most];  ///< the circle's farthest points along them
  double base_[most];  ///< the support of all else
  double h_[most];
};

/// The normal of a polytope's face, with the numbers of FaceReach; unit, in the common frame.
Vec3 face_normal(const RoundBody& body, const FaceReach& reach, std::size_t face);

}  // namespace tandem
