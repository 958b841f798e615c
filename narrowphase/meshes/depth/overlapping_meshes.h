// Two meshes that overlap, for the search for a translation that separates them.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "meshes/depth/mesh_features.h"
#include "meshes/depth/separation_search.h"
#include "meshes/traversal/meeting_pairs.h"
#include "shapes/posed_mesh.h"
#include "shapes/shape_insides.h"

namespace tandem {

/// World axes; B's place is relative to A's translation, which is zero. An edge that goes through a flat face of the
/// other mesh still does moved a little, until one of its ends comes to the face's plane or the crossing to the face's
/// border: a constraint on all translations but long ones. The shortest translation that satisfies them all separates
/// if nothing else is there.
class OverlappingMeshes final : public OverlappingPair {
 public:
  /// `pairs`: the triangles that meet. Of the options: `parts` and `limit`; they must outlive this.
  OverlappingMeshes(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                    const NarrowPhaseOptions& options);

  bool collide(const Vec3& move) const override;
  bool is_free(const Vec3& move) const override { return !collide(move) && !collide(farther(move)); }
  double free_length(const Vec3& direction, const Separation& known) const override;
  bool add_constraints(const Vec3& at, LocalConstraints& constraints) const override;
  bool separating_planes(const Vec3& at, double reach, std::vector<Constraint>& planes) override;

 private:
  const MeshModel& mesh(bool of_a) const { return mesh_of((of_a ? a_ : b_).shape); }
  Pose moved_b(const Vec3& by) const { return {b_.pose.rotation, b_.pose.translation + by}; }
  Vec3 placed(bool of_a, const Vec3& v, const Vec3& at) const;

  bool add_edge_through_face(bool of_a, std::uint32_t i, std::size_t k, std::uint32_t j, const Vec3& at,
                             LocalConstraints& constraints) const;
  bool add_constraints_of(bool of_a, const Edge& edge, const CoplanarRegion& face, const Vec3& n, const Vec3& crossing,
                          const Vec3& at, LocalConstraints& constraints) const;

  const Posed a_, b_;
  const std::span<const TrianglePair> pairs_;
  const NarrowPhaseOptions& options_;
  const Vec3 between_;
  mutable std::array<MeshFeatures, 2> features_;  ///< of B, of A; what was found is kept
  std::size_t work_left_ = 16384;                 ///< pairs of boxes that separating_planes may look at
};

}  // namespace tandem
