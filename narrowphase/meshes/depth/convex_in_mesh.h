// A mesh and a convex shape that overlap, for the search for a translation that separates them.
#pragma once
#include <optional>
#include <vector>

#include "meshes/depth/separation_search.h"
#include "meshes/traversal/mesh_convex_pair.h"

namespace tandem {

/// In the mesh's axes relative to the convex shape's origin; the convex shape is B.
class ConvexInMesh final : public OverlappingPair {
 public:
  explicit ConvexInMesh(const MeshConvexPair& pair);

  bool collide(const Vec3& move) const override {
    const Vec3 along = unit(move, move.norm());
    return pair_.moved(move).collide({&along, 1});
  }
  bool is_free(const Vec3& move) const override { return !collide(farther(move)); }
  double free_length(const Vec3& direction, const Separation& known) const override;
  bool add_constraints(const Vec3& at, LocalConstraints& constraints) const override;
  bool separating_planes(const Vec3& at, double reach, std::vector<Constraint>& planes) override;

  /// A translation that separates, off each triangle by the least that this takes, as in a corner of the mesh, where it
  /// touches several; none where these contradict each other.
  std::optional<Vec3> off_triangles() const;

  /// Raises the lower bound by points of the convex shape deep inside the mesh; returns the direction out of the mesh
  /// of the deepest, zero if there is none. `normal`: of a translation that separates.
  Vec3 raise_by_deep_points(const Vec3& normal, Separation& known) const;

 private:
  bool add_off_triangles(const Vec3& at, LocalConstraints& constraints) const;
  bool leads_on(double length, const Vec3& d) const;
  struct DeepPoint {
    double depth = 0;
    Vec3 out = Vec3::Zero();
  };
  DeepPoint deep_point(const Vec3& p, double ball, bool leads_out) const;
  bool leads_out(double length, const Vec3& normal) const;
  bool chord_constraint(const MeshConvexPair& there, std::uint32_t t, const Vec3& n, const Vec3& lowest, const Vec3& at,
                        LocalConstraint& found) const;

  const MeshConvexPair& pair_;
};

}  // namespace tandem
