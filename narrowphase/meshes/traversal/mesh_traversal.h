#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "meshes/traversal/node_pair_stack.h"
#include "shapes/mesh_model.h"
#include "shapes/work_meter.h"
#include "triangles/predicates.h"

namespace tandem {

/// What is done with pairs of triangles that may meet.
class PairVisitor {
 public:
  explicit PairVisitor(const WorkLimit* limit) : meter(limit) {}
  virtual ~PairVisitor() = default;
  /// Triangle i of A and j of B; true ends the traversal.
  virtual bool visit(std::uint32_t i, std::uint32_t j) = 0;

  WorkMeter meter;  ///< the traversal's work and the visitor's
};

/// Simultaneous traversal of two hierarchies: visits every triangle i of `a` and j of `b` that may meet, never leaving
/// one out that does, the same j in a row. The order depends on the arguments only; with `likely_first` the boxes that
/// overlap most come first. Boxes are compared along the axes of both meshes, triangles along their own axes and
/// normals, eight at once in floats with a bound on their error. Wants a.unit >= b.unit.
/// `gap`, if not null, is lowered to what any two triangles that are not visited are known to be apart (metres); it
/// says nothing if the visitor ends the traversal.
void traverse(const MeshModel& a, const MeshModel& b, const TriangleTest& frame, bool likely_first,
              PairVisitor& visitor, double* gap = nullptr);

/// Pairs of subtrees that do not depend on each other: together they visit what traverse() does. `wanted` of
/// them or more, unless there is less to do.
std::vector<NodePair> traversal_subtrees(const MeshModel& a, const MeshModel& b, const TriangleTest& frame,
                                         std::size_t wanted, double* gap = nullptr);
void traverse(const MeshModel& a, const MeshModel& b, const TriangleTest& frame, NodePair subtrees,
              PairVisitor& visitor, double* gap = nullptr);

}  // namespace tandem
