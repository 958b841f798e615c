// Pairs of triangles, of one mesh or of two, whose boxes are near each other.
#pragma once
#include <functional>
#include <vector>

#include "meshes/traversal/mesh_traversal.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/search.h"

namespace tandem {

/// Simultaneous traversal of the hierarchies of two meshes, or of a mesh and itself, that looks at boxes alone.
class NearBoxPairs {
 public:
  /// Pairs of triangles of one mesh, i < j. `margin`: metres, >= 0.
  NearBoxPairs(const MeshModel& mesh, double margin);
  /// Triangle i of A, j of B.
  NearBoxPairs(const Posed& a, const Posed& b, double margin);

  /// Subtrees that do not depend on each other: together they have all pairs. As many as threads may need.
  std::vector<NodePair> subtrees() const;
  /// Every pair below whose triangles are no farther apart than the margin, and others, each once. Spends the
  /// visitor's meter.
  void visit(NodePair subtrees, PairVisitor& visitor) const;

 private:
  struct Boxes;
  void descend(NodePair at, std::vector<NodePair>& out) const;
  void map(const LaneBoxes& given, std::uint32_t lanes, Boxes& out) const;
  bool visit_bottom(NodePair at, PairVisitor& visitor) const;

  const MeshModel& a_;
  const MeshModel& b_;
  const bool self_;
  float map_[3][3], shift_[3];  // B's boxes to A's axes, in units of A
  float pad_;                   // the margin, and what floats are off by
};

/// Visits all subtrees one after the other. `ended`, asked after each: whether the visitor wants no more.
SearchEnd visit_in_turn(const NearBoxPairs& near, PairVisitor& visitor, const SearchOptions& options,
                        const std::function<bool()>& ended);

}  // namespace tandem
