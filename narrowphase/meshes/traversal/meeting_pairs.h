// The triangles of two meshes that meet, exactly; whether two meshes collide; how far apart they are if not.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory_resource>
#include <vector>

#include "shapes/mesh_model.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/options.h"
#include "tolerances.h"
#include "triangles/predicates.h"
#include "triangles/triangle_rows.h"

namespace tandem {

using TrianglePair = std::array<std::uint32_t, 2>;  ///< of A, of B
using TrianglePairs = std::pmr::vector<TrianglePair>;

/// What a query usually needs for pairs lies on the stack; `more` is where the rest comes from.
struct PairMemory {
  explicit PairMemory(std::pmr::memory_resource* more) : resource(usual.data(), usual.size(), more) {}
  alignas(std::max_align_t) std::array<std::byte, std::size_t{16} << 10> usual;
  std::pmr::monotonic_buffer_resource resource;
};

/// What is known of how far apart two meshes are that do not meet.
struct GapBound {
  static constexpr std::size_t most = 32;
  double of_others = infinity;  ///< any two triangles but these, in A's frame
  std::array<TrianglePair, most> close{};
  std::size_t count = 0;  ///< of `close`; beyond `most` nothing is known

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

/// Sorted: who found them and when leaves no trace. Of the options: `parts` and `limit`. `gap`, if not null, says what
/// is known if there are none. `memory` holds the list.
TrianglePairs meeting_pairs(const Posed& a, const Posed& b, TriangleTest& test, const NarrowPhaseOptions& options,
                            PairMemory& memory, GapBound* gap);

/// Takes one; false ends the search.
using TakePair = std::function<bool(const TrianglePair&)>;

/// Hands on the pairs that meet one by one, in an order that depends on the arguments only; a.unit >= b.unit. False if
/// it was ended. `progress`, if not empty, is told the part that is done, rising to 1 where the boxes overlap.
bool each_meeting_pair(const Posed& a, const Posed& b, const WorkLimit* limit, const TakePair& take,
                       const std::function<void(double)>& progress);

/// A lower bound on how far apart two meshes are that do not meet; 0 if none is known.
double gap_of(const MeshModel& a, const MeshModel& b, const TriangleTest& test, const GapBound& gap);

/// For two whose surfaces do not meet: is a component of the one inside the other?
bool has_inside(const Posed& outer, const Posed& inner, const WorkLimit* limit);
inline bool is_contained(const Posed& a, const Posed& b, const WorkLimit* limit) {
  return has_inside(a, b, limit) || has_inside(b, a, limit);
}

bool meshes_collide(const Posed& a, const Posed& b, const WorkLimit* limit);

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
