// Refits the hierarchy of a mesh whose vertices have moved: updates its boxes in place, or rebuilds parts of it.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lanes/four_floats.h"
#include "shapes/mesh_hierarchy.h"

namespace tandem {

/// The state that refits of one hierarchy's structure share: subtrees for threads, and their quality when built.
class MeshRefit {
 public:
  /// For a mesh whose hierarchy was just built.
  explicit MeshRefit(const MeshModel& mesh);

  /// Updates boxes, blocks and slabs of a mesh of this structure for these vertices, with its centre, half and unit;
  /// its own vertices are ignored. The same for any number of threads.
  void refit(MeshModel& mesh, std::span<const Vec3> vertices, const PartRunner& parts);
  /// True if a closed surface, beyond the rounding of floats, encloses no negative volume as of the last refit.
  bool surely_outward() const;

  struct Report {
    std::size_t rebuilt = 0;  ///< triangles of subtrees that were rebuilt
    double worn = 1;          ///< the largest growth of the area of boxes of a subtree, or of those above all
  };
  /// After a refit, when the mesh has its vertices: rebuilds subtrees whose boxes above the leaves have grown by more
  /// than a factor, relative to those of the leaves, since they were built, or the whole hierarchy: the structure
  /// changes.
  Report rebuild_worn(MeshModel& mesh, const PartRunner& parts);

  std::size_t memory() const;  ///< bytes

 private:
  /// Sums over nodes or triangles, in units of the mesh.
  struct Sums {
    double inner = 0, leaves = 0;  ///< half areas of boxes: of nodes, of triangles
    double volumes = 0;            ///< six times the volume between triangles and the centre
    double reaches = 0;            ///< squares of the sums of half sizes of triangles' boxes
    double ratio() const { return leaves > 0 ? inner / leaves : 0; }
  };
  /// The content of a subtree that its parent needs, in floats.
  struct Held {
    FourFloats low = all_four(std::numeric_limits<float>::infinity()), high = -low;
    FourFloats area = all_four(0);    ///< twice the sum of the area vectors
    FourFloats normal = all_four(0);  ///< of its slab
    float slab_mid = 0, slab_half = 0;
    void set_slab(FourFloats low, FourFloats high);
  };
  struct Box {
    FourFloats mid, half;
  };
  struct Subtree {
    std::uint32_t node, end_node;  ///< nodes[node, end_node)
    std::uint32_t begin, end;      ///< order[begin, end)
    int level;
    double built = 0;  ///< the ratio of its areas when it was built, or the least since
    Sums sums;
    Held held;
  };

  void cut(const MeshModel& mesh);
  Box box_of(const Held& held) const;
  void store_box(MeshNode& node, const Held& held) const;
  Held refit_bottom(MeshModel& mesh, MeshNode& node, Sums& sums) const;
  template <class Child>
  Held refit_inner(MeshModel& mesh, MeshNode& node, Sums& sums, const Child& child) const;
  Held refit_subtree(MeshModel& mesh, std::uint32_t node, Sums& sums) const;
  Held refit_top(MeshModel& mesh, std::uint32_t node, std::size_t& next);
  Sums sum_of_all() const;
  double wear(double ratio, double& built) const;
  void rebuild(MeshModel& mesh, const std::vector<std::uint8_t>& worn, const PartRunner& parts);
  void measure_anew(const MeshModel& mesh, const std::vector<std::uint8_t>& worn);

  std::vector<Subtree> subtrees_;
  std::vector<std::uint32_t> top_;  ///< nodes above the subtrees, parents first
  double top_built_ = 0;
  Sums top_sums_;
  float pad_ = 0;           ///< the margin of boxes in floats
  CornersInUnits corners_;  ///< vertices in units of the mesh
  /// For each block the vertices of its triangles, the last one's repeated: read in sequence.
  UninitialisedList<std::array<std::array<std::uint32_t, 3>, mesh_lanes>> leaves_;
};

}  // namespace tandem
