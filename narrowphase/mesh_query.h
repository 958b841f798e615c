#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "mesh_model.h"

namespace tandem {

/// A box with axes of its own against the boxes of a mesh's hierarchy: which triangles may come near it. Gaps are lower
/// bounds, along the axes of either; floats, with a margin for their rounding.
class BoxQuery {
 public:
  /// In the mesh's frame: `aligned` is a box along the mesh's axes, `mid`, `half` and the columns of `axes` (unit) one
  /// along its own; both hold the same thing.
  /// `ball`: every point of the thing stands for a ball of this radius about it.
  BoxQuery(const MeshModel& mesh, const Bounds& aligned, const Vec3& mid, const Vec3& half, const Mat3& axes,
           double ball = 0)
      : mesh_(mesh), ball_(ball) {
    const Vec3 lo = (aligned.lo - mesh.centre) / mesh.unit, hi = (aligned.hi - mesh.centre) / mesh.unit;
    const Vec3 m = (mid - mesh.centre) / mesh.unit, h = half / mesh.unit;
    const double most =
        std::max({lo.cwiseAbs().maxCoeff(), hi.cwiseAbs().maxCoeff(), m.cwiseAbs().maxCoeff() + h.sum()});
    // Too far out for floats: every triangle may be near.
    blunt_ = !(most < 1e18);
    pad_ = blunt_ ? 0 : static_cast<float>(2e-6 * (2 + most));
    for (int i = 0; i < 3; ++i) {
      mid_[i] = blunt_ ? 0 : static_cast<float>((lo[i] + hi[i]) / 2);
      half_[i] = blunt_ ? 0 : static_cast<float>((hi[i] - lo[i]) / 2) + pad_;
      own_mid_[i] = blunt_ ? 0 : static_cast<float>(axes.col(i).dot(m));
      own_half_[i] = blunt_ ? 0 : static_cast<float>(h[i]) + pad_;
      for (int j = 0; j < 3; ++j) axes_[i][j] = static_cast<float>(axes(j, i));
    }
  }

  /// Calls visit(t) for the triangles whose boxes come within `margin` (metres), in an order that depends on the
  /// arguments only, until it returns true.
  template <class Visit>
  void each_near(double margin, Visit&& visit) const {
    // Of boxes with corners the gap along an axis; of round ones the distance.
    const float reach = ball_ > 0 ? squared(margin) : static_cast<float>(std::min(margin / mesh_.unit * 1.00001, 1e30));
    std::array<std::uint32_t, stack_size> stack;
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const MeshNode& n = mesh_.nodes[stack[--top]];
      const Lanes worst = ball_ > 0 ? squared_gap(n) : gap(n);
      for (std::uint32_t k = 0; k < n.lanes; ++k) {
        if (worst[static_cast<int>(k)] > reach) continue;
        if (n.count[k] == 0) {
          stack[top++] = n.child[k];
          continue;
        }
        for (std::uint32_t i = 0; i < n.count[k]; ++i)
          if (visit(mesh_.order[n.child[k] + i])) return;
      }
    }
  }

  /// Calls visit(t), which returns the distance (metres) at which it is no longer interested, for triangles that may be
  /// nearer than that; the nearer boxes first.
  template <class Visit>
  void nearest_first(double interest, Visit&& visit) const {
    struct Entry {
      float gap2;  // squared, units
      std::uint32_t child, count;
    };
    std::array<Entry, stack_size> stack;
    std::size_t top = 0;
    float limit2 = squared(interest);
    stack[top++] = {0, 0, 0};
    while (top > 0) {
      const Entry e = stack[--top];
      if (e.gap2 > limit2) continue;
      if (e.count > 0) {
        for (std::uint32_t i = 0; i < e.count; ++i) limit2 = squared(visit(mesh_.order[e.child + i]));
        continue;
      }
      const MeshNode& n = mesh_.nodes[e.child];
      const Lanes gap2 = squared_gap(n);
      const std::size_t first = top;
      for (std::uint32_t k = 0; k < n.lanes; ++k) {
        const float g = gap2[static_cast<int>(k)];
        if (g > limit2) continue;
        // Nearest on top; of equals the first lane.
        std::size_t at = top++;
        for (; at > first && stack[at - 1].gap2 <= g; --at) stack[at] = stack[at - 1];
        stack[at] = {g, n.child[k], n.count[k]};
      }
    }
  }

 private:
  static constexpr int lanes = static_cast<int>(sizeof(MeshNode::child) / sizeof(std::uint32_t));
  static constexpr std::size_t stack_size = 64 * lanes;  // levels of a hierarchy: MeshModel::depth
  using Lanes = Eigen::Array<float, lanes, 1>;

  struct Gaps {
    Lanes along[3], own[3];
  };

  float squared(double distance) const {
    const double d = (distance + ball_) / mesh_.unit * 1.00001;
    return d * d < 1e37 ? static_cast<float>(d * d) : std::numeric_limits<float>::infinity();
  }

  static Lanes load(const float* p) { return Eigen::Map<const Lanes, Eigen::Aligned16>(p); }

  Gaps gaps(const MeshNode& n) const {
    Gaps g;
    Lanes mid[3], half[3];
    for (int i = 0; i < 3; ++i) {
      mid[i] = load(n.mid[i]);
      half[i] = load(n.half[i]);
      g.along[i] = (mid[i] - mid_[i]).abs() - (half[i] + half_[i]);
    }
    for (int i = 0; i < 3; ++i) {
      const float x = axes_[i][0], y = axes_[i][1], z = axes_[i][2];
      const Lanes d = x * mid[0] + y * mid[1] + z * mid[2] - own_mid_[i];
      g.own[i] = d.abs() - (std::abs(x) * half[0] + std::abs(y) * half[1] + std::abs(z) * half[2] + own_half_[i]);
    }
    return g;
  }

  Lanes gap(const MeshNode& n) const {
    if (blunt_) return Lanes::Zero();
    const Gaps g = gaps(n);
    return g.along[0].max(g.along[1]).max(g.along[2]).max(g.own[0]).max(g.own[1]).max(g.own[2]);
  }

  Lanes squared_gap(const MeshNode& n) const {
    if (blunt_) return Lanes::Zero();
    const Gaps g = gaps(n);
    const auto sum = [](const Lanes* x) {
      const Lanes a = x[0].max(0.0f), b = x[1].max(0.0f), c = x[2].max(0.0f);
      return Lanes(a * a + b * b + c * c);
    };
    return sum(g.along).max(sum(g.own));
  }

  const MeshModel& mesh_;
  double ball_;
  float mid_[3], half_[3], own_mid_[3], own_half_[3], axes_[3][3], pad_;
  bool blunt_;
};

}  // namespace tandem
