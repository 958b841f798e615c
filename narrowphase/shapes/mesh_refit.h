// The hierarchy of a mesh whose vertices have moved: its boxes made anew where they are, or parts of it built anew.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lanes/four_floats.h"
#include "shapes/mesh_hierarchy.h"

namespace tandem {

/// What the refits of hierarchies of one structure share: subtrees that threads work on, and how good each was when
/// built.
class MeshRefit {
 public:
  /// For a mesh whose hierarchy was just built.
  explicit MeshRefit(const MeshModel& mesh);

  /// Makes boxes, blocks and slabs of a mesh of this structure anew for these vertices, in its centre, half and unit;
  /// its own vertices are not looked at. The same on any number of threads.
  void refit(MeshModel& mesh, std::span<const Vec3> vertices, const PartRunner& parts);
  /// Whether a closed surface encloses, beyond what floats round, no negative volume at the last refit.
  bool surely_outward() const;

  struct Report {
    std::size_t rebuilt = 0;  ///< triangles of subtrees that were built anew
    double worn = 1;          ///< the most that the area of boxes of a subtree, or of those above all, has grown by
  };
  /// After a refit, when the mesh has its vertices. Where the boxes above the leaves have grown, beside those of the
  /// leaves, by more than a factor since they were built, the subtree is built anew, or all of it: the structure is
  /// another one then.
  Report rebuild_worn(MeshModel& mesh, const PartRunner& parts);

  std::size_t memory() const;  ///< bytes

 private:
  /// Over nodes or triangles, in units of the mesh.
  struct Sums {
    double inner = 0, leaves = 0;  ///< half areas of boxes: of nodes, of triangles
    double volumes = 0;            ///< six times the volume that triangles and the centre enclose
    double reaches = 0;            ///< squares of the sums of the halves of triangles' boxes
    double ratio() const { return leaves > 0 ? inner / leaves : 0; }
  };
  /// A subtree's corners in floats: what its parent has to know.
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
  std::vector<std::uint32_t> top_;  ///< nodes above them, parents first
  double top_built_ = 0;
  Sums top_sums_;
  float pad_ = 0;           ///< what boxes in floats need
  CornersInUnits corners_;  ///< vertices in units of the mesh
  /// Of each block the vertices of its triangles, the last one's repeated: read one after another.
  UninitialisedList<std::array<std::array<std::uint32_t, 3>, mesh_lanes>> leaves_;
};

}  // namespace tandem
