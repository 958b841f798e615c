// The hierarchy of a mesh whose vertices have moved: its boxes made anew where they are, or parts of it built anew.
#pragma once
#include <cstdint>
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

  struct Report {
    std::size_t rebuilt = 0;  ///< triangles of subtrees that were built anew
    double worn = 1;          ///< the most that the area of boxes of a subtree, or of those above all, has grown by
  };
  /// Makes boxes, blocks and slabs of a mesh of this structure anew from its vertices, centre, half and unit. Where the
  /// boxes above the leaves have grown, beside those of the leaves, by more than a factor since they were built, the
  /// subtree is built anew, or all of it: the structure is another one then.
  Report refit(MeshModel& mesh, const PartRunner& parts);

  std::size_t memory() const;  ///< bytes

 private:
  /// Sums of half the areas of boxes, in units of the mesh.
  struct Areas {
    double inner = 0, leaves = 0;
    double ratio() const { return leaves > 0 ? inner / leaves : 0; }
  };
  struct Subtree {
    std::uint32_t node, end_node;  ///< nodes[node, end_node)
    std::uint32_t begin, end;      ///< order[begin, end)
    int level;
    double built = 0;  ///< the ratio of its areas when it was built, or the least since
    Areas areas;
  };

  void cut(const MeshModel& mesh);
  void refit_node(MeshModel& mesh, std::uint32_t node, Areas& areas);
  void refit_bottom(MeshModel& mesh, MeshNode& node, FourFloats& normal, Areas& areas) const;
  void refit_inner(MeshModel& mesh, MeshNode& node, FourFloats& normal, Areas& areas) const;
  void refit_slab(const MeshModel& mesh, std::uint32_t child, ChildSlabs& slabs, std::size_t lane) const;
  Areas sum_of_all() const;
  double wear(double ratio, double& built) const;
  void rebuild(MeshModel& mesh, const std::vector<std::uint8_t>& worn, const PartRunner& parts);
  void measure_anew(const MeshModel& mesh, const std::vector<std::uint8_t>& worn);

  std::vector<Subtree> subtrees_;
  std::vector<std::uint32_t> top_;  ///< nodes above them, parents first
  double top_built_ = 0;
  Areas top_areas_;
  float pad_ = 0;                     ///< what boxes in floats need
  CornersInUnits corners_;            ///< vertices in units of the mesh
  UninitialisedList<FourFloats> normals_;  ///< of each node's triangles, twice the sum of their area vectors
};

}  // namespace tandem
