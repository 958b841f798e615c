// The triangles of a mesh near a box, by the mesh's hierarchy.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "shapes/mesh_model.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {

/// A box along a mesh's axes and one along its own, in the mesh's units about its centre; both hold the same object.
struct QueryBox {
  float mid[3], half[3], own_mid[3], own_half[3], axes[3][3];
  float corner_pad;  // MeshModel::corner_pad
};

/// Gaps to the boxes of a node, one per lane: the largest along an axis, or if `squared` the distance along the three
/// axes of either box.
struct alignas(32) NodeGaps {
  float lane[mesh_lanes];
  std::uint32_t within;  ///< a bit for each used lane whose gap is within the given one
};
void find_gaps(const QueryBox& box, const MeshModel& mesh, const MeshNode& node, bool squared, float reach,
               NodeGaps& gaps);

/// A box with axes of its own against the boxes of a mesh's hierarchy: which triangles may come near it. Gaps are lower
/// bounds, along the axes of either; floats, with a margin for their rounding.
class BoxQuery {
 public:
  /// In the mesh's frame: `aligned` is a box along the mesh's axes, `mid`, `half` and the columns of `axes` (unit) one
  /// along its own; both hold the same object.
  /// `ball`: the object is rounded by this radius. `a_visit`: units of work that a visit
  /// of a triangle counts as.
  BoxQuery(const MeshModel& mesh, const Bounds& aligned, const Vec3& mid, const Vec3& half, const Mat3& axes,
           double ball = 0, const WorkLimit* limit = nullptr, int a_visit = 16)
      : mesh_(mesh), ball_(ball), limit_(limit), a_visit_(a_visit) {
    const Vec3 lo = (aligned.lo - mesh.centre) / mesh.unit, hi = (aligned.hi - mesh.centre) / mesh.unit;
    const Vec3 m = (mid - mesh.centre) / mesh.unit, h = half / mesh.unit;
    const double most =
        std::max({lo.cwiseAbs().maxCoeff(), hi.cwiseAbs().maxCoeff(), m.cwiseAbs().maxCoeff() + h.sum()});
    // Too far out for floats: every triangle may be near.
    blunt_ = !(most < 1e18);
    pad_ = blunt_ ? 0 : static_cast<float>(tolerance::query_of_floats * (2 + most));
    box_.corner_pad = mesh.corner_pad();
    for (int i = 0; i < 3; ++i) {
      box_.mid[i] = blunt_ ? 0 : static_cast<float>((lo[i] + hi[i]) / 2);
      box_.half[i] = blunt_ ? 0 : static_cast<float>((hi[i] - lo[i]) / 2) + pad_;
      box_.own_mid[i] = blunt_ ? 0 : static_cast<float>(axes.col(i).dot(m));
      box_.own_half[i] = blunt_ ? 0 : static_cast<float>(h[i]) + pad_;
      for (int j = 0; j < 3; ++j) box_.axes[i][j] = static_cast<float>(axes(j, i));
    }
  }

  /// Calls visit(node, lanes) for the bottom nodes with triangles whose boxes come within `margin` (metres), a bit for
  /// each, in an order that depends on the arguments only, until it returns true.
  template <class Visit>
  void each_bottom(double margin, Visit&& visit) const {
    // Without rounding the gap along an axis decides; with rounding the distance.
    const float reach = ball_ > 0 ? squared(margin) : static_cast<float>(std::min(in_units(margin), 1e30));
    WorkMeter meter(limit_);
    std::array<std::uint32_t, stack_size> stack;
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
      meter.spend();
      const MeshNode& n = mesh_.nodes[stack[--top]];
      NodeGaps gaps;
      find(n, ball_ > 0, reach, gaps);
      if (n.bottom()) {
        if (gaps.within != 0 && visit(n, gaps.within)) return;
        continue;
      }
      for (std::uint32_t left = gaps.within; left != 0; left &= left - 1)
        stack[top++] = mesh_.boxes_of(n).child[std::countr_zero(left)];
    }
  }

  /// Calls visit(t) for the triangles whose boxes come within `margin` (metres), in the order of each_bottom, until it
  /// returns true.
  template <class Visit>
  void each_near(double margin, Visit&& visit) const {
    WorkMeter meter(limit_);
    each_bottom(margin, [&](const MeshNode& n, std::uint32_t within) {
      for (std::uint32_t left = within; left != 0; left &= left - 1) {
        meter.spend(a_visit_);
        if (visit(mesh_.triangle_of(n, static_cast<std::uint32_t>(std::countr_zero(left))))) return true;
      }
      return false;
    });
  }

  int a_visit() const { return a_visit_; }

  /// Calls visit(t), which returns the distance (metres) at which it is no longer interested, for triangles that may be
  /// nearer than that; the nearer boxes first.
  template <class Visit>
  void nearest_first(double interest, Visit&& visit) const {
    struct Entry {
      float gap2;        // squared, units
      std::uint32_t at;  // a node, or in the leaves' order
      bool triangle;
    };
    WorkMeter meter(limit_);
    std::array<Entry, stack_size> stack;
    std::size_t top = 0;
    float limit2 = squared(interest);
    stack[top++] = {0, 0, false};
    while (top > 0) {
      const Entry e = stack[--top];
      if (e.gap2 > limit2) continue;
      meter.spend();
      if (e.triangle) {
        meter.spend(a_visit_);
        limit2 = squared(visit(mesh_.order[e.at]));
        continue;
      }
      const MeshNode& n = mesh_.nodes[e.at];
      NodeGaps gaps;
      find(n, true, limit2, gaps);
      const std::size_t first = top;
      for (std::uint32_t left = gaps.within; left != 0; left &= left - 1) {
        const int k = std::countr_zero(left);
        const float g = gaps.lane[k];
        // Nearest on top; of equals the first lane.
        std::size_t at = top++;
        for (; at > first && stack[at - 1].gap2 <= g; --at) stack[at] = stack[at - 1];
        stack[at] = {g, n.bottom() ? n.first() + static_cast<std::uint32_t>(k) : mesh_.boxes_of(n).child[k],
                     n.bottom()};
      }
    }
  }

 private:
  static constexpr std::size_t stack_size = most_mesh_levels * mesh_lanes;

  double in_units(double distance) const { return distance / mesh_.unit * tolerance::margin_in_floats; }

  float squared(double distance) const {
    const double d = in_units(distance + ball_);
    return d * d < 1e37 ? static_cast<float>(d * d) : std::numeric_limits<float>::infinity();
  }

  void find(const MeshNode& n, bool squared, float reach, NodeGaps& gaps) const {
    if (!blunt_) return find_gaps(box_, mesh_, n, squared, reach, gaps);
    std::fill_n(gaps.lane, mesh_lanes, 0.0f);
    gaps.within = n.used();
  }

  const MeshModel& mesh_;
  double ball_;
  const WorkLimit* limit_;
  int a_visit_;
  QueryBox box_;
  float pad_;
  bool blunt_;
};

}  // namespace tandem
