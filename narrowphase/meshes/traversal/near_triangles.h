// Pairs of triangles, of one mesh or of two, whose boxes are near each other.
#pragma once
#include <functional>
#include <vector>

#include "meshes/traversal/mesh_traversal.h"
#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/search.h"

namespace tandem {

/// Simultaneous traversal of the hierarchies of two meshes, or of a mesh and itself, by boxes alone.
class NearBoxPairs {
 public:
  /// Pairs of triangles of one mesh, i < j. `margin`: metres, >= 0.
  NearBoxPairs(const MeshModel& mesh, double margin);
  /// Pairs of triangle i of A and j of B.
  NearBoxPairs(const Posed& a, const Posed& b, double margin);

  /// Independent pairs of subtrees: together they have all pairs. Enough of them for threads.
  std::vector<NodePair> subtrees() const;
  /// Visits every pair below whose triangles are at most the margin apart, and others, each once. Spends the visitor's
  /// meter.
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
  float pad_;                   // the margin, and a bound on the errors of floats
};

/// Visits all subtrees one after the other. `ended`, called after each: the visitor wants no more.
SearchEnd visit_in_turn(const NearBoxPairs& near, PairVisitor& visitor, const SearchOptions& options,
                        const std::function<bool()>& ended);

}  // namespace tandem
