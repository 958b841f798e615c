#pragma once
#include <cstdint>

#include "shapes/face_table.h"
#include "shapes/round_body.h"

namespace tandem {

/// How far a box, a triangle or a hull with a volume and a body with a circle reach together along the normals of the
/// one's faces, and what that says of the arcs of directions between them. A triangle has two faces, 0 and 1, and one
/// more across each edge, in its plane: 2 + i from its corner i on.
class FaceReach {
 public:
  static constexpr std::size_t most = 512;  ///< of more faces the rest is not known

  void measure(const RoundBody& polytope, const RoundBody& circle);
  bool known() const { return count_ > 0; }

  std::size_t faces() const { return count_; }
  /// Unit, in the frame of both.
  Vec3 normal(std::size_t face) const { return (axes_ * Vec3(m_[0][face], m_[1][face], m_[2][face])).normalized(); }

  struct Least {
    std::size_t face = 0;
    double h = 0;
  };
  Least least() const;

  /// Do they reach at least as far as `limit` > 0 all along the arc between two adjacent faces' normals? The points
  /// that are farthest at its ends reach along it no less than where they are level, or at the ends.
  bool reaches(std::size_t f, std::size_t g, double limit) const {
    if (f >= count_ || g >= count_) return false;
    const double from_at_g = base_[g] + along(g, f);
    if (from_at_g >= limit && h_[f] >= limit) return true;
    const double to_at_f = base_[f] + along(f, g);
    if (to_at_f >= limit && h_[g] >= limit) return true;
    const double p = std::max(0.0, h_[g] - from_at_g), q = std::max(0.0, h_[f] - to_at_f);
    const double cosine = m_[0][f] * m_[0][g] + m_[1][f] * m_[1][g] + m_[2][f] * m_[2][g];
    const double level = std::min(p * h_[f] + q * from_at_g, p * to_at_f + q * h_[g]);
    return level >= 0 && level * level >= limit * limit * (p * p + q * q + 2 * p * q * cosine);
  }

 private:
  /// Along the normal of face f, the circle's point that is farthest along g's.
  double along(std::size_t f, std::size_t g) const {
    return m_[0][f] * s_[0][g] + m_[1][f] * s_[1][g] + m_[2][f] * s_[2][g];
  }

  std::size_t count_ = 0;
  Mat3 axes_;          ///< of the circle
  double m_[3][most];  ///< the normals along the circle's axes
  double s_[3][most];  ///< there its farthest points
  double base_[most];  ///< how far all else reaches
  double h_[most];
};

/// The normal of a polytope's face, unit, in the frame of both; of a triangle the reach's.
Vec3 face_normal(const RoundBody& body, const FaceReach& reach, std::size_t face);

}  // namespace tandem
