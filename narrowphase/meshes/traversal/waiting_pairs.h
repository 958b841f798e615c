// Pairs of triangles that wait for the others with which they are compared.
#pragma once
#include <array>
#include <cstdint>

#include "shapes/mesh_model.h"
#include "triangles/predicates.h"
#include "triangles/triangle_rows.h"

namespace tandem {

/// Whether triangles of two meshes meet, exactly, several pairs at a time.
class WaitingPairs {
 public:
  WaitingPairs(const MeshModel& a, const MeshModel& b, TriangleTest& test) : a_(a), b_(b), test_(test) {}

  std::size_t size() const { return count_; }

  /// True if there is no room for another one: they are to be decided.
  bool add(std::uint32_t i, std::uint32_t j) {
    waiting_[count_] = {i, j};
    rows_.set(count_++, a_.corners(i), b_.corners(j));
    return count_ == TriangleRows::most;
  }

  /// tell(i, j, whether they meet) of all that wait, in the order in which they came.
  template <class Tell>
  void decide(Tell&& tell) {
    if (count_ == 0) return;
    const TriangleVerdicts verdicts = compare_triangles(rows_, count_, test_);
    for (std::size_t k = 0; k < count_; ++k) {
      const auto [i, j] = waiting_[k];
      tell(i, j, (verdicts.meet >> k & 1u) != 0 || ((verdicts.unknown >> k & 1u) != 0 && meet(i, j)));
    }
    count_ = 0;
  }

 private:
  bool meet(std::uint32_t i, std::uint32_t j) {
    const std::array<Vec3, 3> q = b_.corners(j);
    return test_(a_.corners(i), q, {test_.in_a(q[0]), test_.in_a(q[1]), test_.in_a(q[2])});
  }

  const MeshModel& a_;
  const MeshModel& b_;
  TriangleTest& test_;
  TriangleRows rows_{};  // columns that are not set are computed with the others: what is in them must be numbers
  std::array<std::array<std::uint32_t, 2>, TriangleRows::most> waiting_;
  std::size_t count_ = 0;
};

}  // namespace tandem
