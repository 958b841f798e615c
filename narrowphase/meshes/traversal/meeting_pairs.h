// The intersecting triangles of two meshes, exactly; whether two meshes collide; a lower bound on their distance if
// not.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory_resource>
#include <vector>

#include "meshes/traversal/triangle_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/options.h"
#include "tolerances.h"
#include "triangles/predicates.h"
#include "triangles/triangle_rows.h"

namespace tandem {

using TrianglePairs = std::pmr::vector<TrianglePair>;

/// Memory for the pairs of a typical query is on the stack; `more` is the resource for the rest.
struct PairMemory {
  explicit PairMemory(std::pmr::memory_resource* more) : resource(usual.data(), usual.size(), more) {}
  alignas(std::max_align_t) std::array<std::byte, std::size_t{16} << 10> usual;
  std::pmr::monotonic_buffer_resource resource;
};

/// Data for a lower bound on the distance of two meshes that do not intersect.
struct GapBound {
  static constexpr std::size_t most = 32;
  double of_others = infinity;  ///< the least distance of all other pairs, in A's frame
  std::array<TrianglePair, most> close{};
  std::size_t count = 0;  ///< size of `close`; beyond `most` nothing is known

  void add(const TrianglePair& pair) {
    if (count < most) close[count] = pair;
    ++count;
  }
  void join(const GapBound& other) {
    of_others = std::min(of_others, other.of_others);
    for (std::size_t i = 0; i < std::min(other.count, most); ++i) add(other.close[i]);
    if (other.count > most) count = most + 1;
  }
};

/// Sorted, so that the result does not depend on the order of finding. Uses `parts` and `limit` of the options. `gap`,
/// if not null, is set if there are no pairs. `memory` holds the list.
TrianglePairs meeting_pairs(const Posed& a, const Posed& b, TriangleTest& test, const NarrowPhaseOptions& options,
                            PairMemory& memory, GapBound* gap);

/// Takes a pair; false ends the search.
using TakePair = std::function<bool(const TrianglePair&)>;

/// Passes on the intersecting pairs one by one, in an order that depends on the arguments only; a.unit >= b.unit. False
/// if it was ended. `progress`, if not empty, gets the fraction done, increasing to 1 if the boxes overlap.
bool each_meeting_pair(const Posed& a, const Posed& b, const WorkLimit* limit, const TakePair& take,
                       const std::function<void(double)>& progress);

/// A lower bound on the distance of two meshes that do not intersect; 0 if none is known.
double gap_of(const MeshModel& a, const MeshModel& b, const TriangleTest& test, const GapBound& gap);

/// For two whose surfaces do not intersect: true if a component of one is inside the other.
bool has_inside(const Posed& outer, const Posed& inner, const WorkLimit* limit);
inline bool is_contained(const Posed& a, const Posed& b, const WorkLimit* limit) {
  return has_inside(a, b, limit) || has_inside(b, a, limit);
}

bool meshes_collide(const Posed& a, const Posed& b, const WorkLimit* limit);

/// Tests pairs of triangles of two meshes for intersection, exactly, several at a time.
class WaitingPairs {
 public:
  WaitingPairs(const MeshModel& a, const MeshModel& b, TriangleTest& test) : a_(a), b_(b), test_(test) {}

  std::size_t size() const { return count_; }

  /// True if there is no room for another one: the pairs must be decided.
  bool add(std::uint32_t i, std::uint32_t j) {
    waiting_[count_] = {i, j};
    rows_.set(count_++, a_.corners(i), b_.corners(j));
    return count_ == TriangleRows::most;
  }

  /// Calls report(i, j, intersect) for all waiting pairs, in their order.
  template <class Report>
  void decide(Report&& report) {
    if (count_ == 0) return;
    const TriangleVerdicts verdicts = compare_triangles(rows_, count_, test_);
    for (std::size_t k = 0; k < count_; ++k) {
      const auto [i, j] = waiting_[k];
      report(i, j, (verdicts.meet >> k & 1u) != 0 || ((verdicts.unknown >> k & 1u) != 0 && meet(i, j)));
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
  TriangleRows rows_{};  // unset columns are computed, too: they must contain numbers
  std::array<std::array<std::uint32_t, 2>, TriangleRows::most> waiting_;
  std::size_t count_ = 0;
};

}  // namespace tandem
