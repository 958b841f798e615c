// Two meshes that overlap, for the search for a translation that separates them.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "meshes/depth/mesh_features.h"
#include "meshes/depth/separation_search.h"
#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "shapes/shape_insides.h"

namespace tandem {

/// In world axes, relative to A's translation. An edge that passes through a flat face of the other mesh still does
/// after a small translation, until one of its ends reaches the face's plane or the crossing reaches the face's border:
/// a constraint on all but long translations. The shortest translation that satisfies all of them separates if nothing
/// else is in the way.
class OverlappingMeshes final : public OverlappingPair {
 public:
  /// `pairs`: the intersecting triangles. Uses `parts` and `limit` of the options, which must outlive this.
  OverlappingMeshes(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                    const NarrowPhaseOptions& options);

  bool collide(const Vec3& move) const override;
  bool is_free(const Vec3& move) const override { return !collide(move) && !collide(farther(move)); }
  double free_length(const Vec3& direction, const Separation& known) const override;
  bool add_constraints(const Vec3& at, LocalConstraints& constraints) const override;
  bool separating_planes(const Vec3& at, double reach, std::vector<Constraint>& planes) override;

  /// A translation that separates, off each pair of triangles by the least that this takes, as in a corner, where
  /// several touch; none where these contradict each other, or more than `few_pairs` intersect. `first`: where to look
  /// for pairs first.
  std::optional<Vec3> off_triangles(const Vec3& first) const;
  static constexpr std::size_t few_pairs = 2048;  ///< of more, each look takes as long as the search that follows

 private:
  /// False also if they contradict each other, or the translation is longer than `longest_off`.
  bool add_off_triangles(const Vec3& at, LocalConstraints& constraints) const;
  /// Deeper, triangles' own depths bound little.
  double longest_off() const {
    constexpr double shallow = 0.1;
    return shallow * std::min(a_.shape.size(), b_.shape.size());
  }
  const MeshModel& mesh(bool of_a) const { return mesh_of((of_a ? a_ : b_).shape); }
  Pose moved_b(const Vec3& by) const { return {b_.pose.rotation, b_.pose.translation + by}; }
  /// The intersecting triangles with B translated; `found` holds them if it is moved.
  std::span<const TrianglePair> pairs_at(const Vec3& at, PairMemory& memory, TrianglePairs& found) const;
  Vec3 placed(bool of_a, const Vec3& v, const Vec3& at) const;

  bool add_edge_through_face(bool of_a, std::uint32_t i, std::size_t k, std::uint32_t j, const Vec3& at,
                             LocalConstraints& constraints) const;
  bool add_constraints_of(bool of_a, const Edge& edge, const CoplanarRegion& face, const Vec3& n, const Vec3& crossing,
                          const Vec3& at, LocalConstraints& constraints) const;

  const Posed a_, b_;
  const std::span<const TrianglePair> pairs_;
  const NarrowPhaseOptions& options_;
  const Vec3 between_;
  mutable std::array<MeshFeatures, 2> features_;  ///< of B, of A; results are kept
  std::size_t work_left_ = 16384;                 ///< pairs of boxes that separating_planes may examine
};

}  // namespace tandem
