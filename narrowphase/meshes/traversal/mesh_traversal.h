// Pairs of triangles of two meshes that may intersect, found by a simultaneous traversal of both hierarchies.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "shapes/mesh_model.h"
#include "shapes/work_meter.h"
#include "triangles/predicates.h"

namespace tandem {

/// Nodes of two hierarchies to be traversed together.
struct NodePair {
  std::uint32_t a, b;
};

/// A stack, nearly always shallow; only deep trees of very large meshes need the heap.
class NodePairStack {
 public:
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  void push(NodePair p) {
    if (size_ < near_.size())
      near_[size_] = p;
    else
      far_.push_back(p);
    ++size_;
  }
  NodePair pop() {
    --size_;
    if (size_ < near_.size()) return near_[size_];
    const NodePair p = far_.back();
    far_.pop_back();
    return p;
  }
  NodePair& operator[](std::size_t i) { return i < near_.size() ? near_[i] : far_[i - near_.size()]; }

 private:
  std::size_t size_ = 0;
  std::array<NodePair, 512> near_;
  std::vector<NodePair> far_;
};

/// Replaces pairs of nodes by those of their children, level by level, until there are `wanted` or all are of bottom
/// nodes. descend(pair, out) appends the children's.
template <class Descend>
std::vector<NodePair> pairs_of_level(const MeshModel& a, const MeshModel& b, std::size_t wanted, Descend&& descend) {
  std::vector<NodePair> level{{0, 0}}, next;
  for (bool deeper = true; deeper && level.size() < wanted; level.swap(next)) {
    deeper = false;
    next.clear();
    for (const NodePair at : level) {
      if (a.nodes[at.a].bottom() && b.nodes[at.b].bottom()) {
        next.push_back(at);
        continue;
      }
      deeper = true;
      descend(at, next);
    }
  }
  return level;
}

/// The pose of B's boxes in A's frame, in units of A, in floats with a bound on their error.
struct TraversalFrame {
  float map[3][3];      // B's boxes to A's axes, scaled
  float inverse[3][3];  // A's axes to B's, not scaled
  float shift[3];
  float ratio;     // of the units, at most 1
  float pad_a[3];  // bound on the errors of floats along A's axes, rounding of the test itself included
  float pad_b[3];  // along B's
  float off;       // bound on the error of any coordinate
  double gap = 0;  // between the whole boxes, along A's axes; > 0: separated, and nothing else is set

  TraversalFrame(const MeshModel& a, const MeshModel& b, const TriangleTest& frame);
};

/// Receives pairs of triangles that may intersect.
class PairVisitor {
 public:
  explicit PairVisitor(const WorkLimit* limit) : meter(limit) {}
  virtual ~PairVisitor() = default;
  /// Takes triangle i of A and j of B; true ends the traversal.
  virtual bool visit(std::uint32_t i, std::uint32_t j) = 0;

  WorkMeter meter;  ///< counts the traversal's work and the visitor's
};

/// Simultaneous traversal of two hierarchies: visits every triangle i of `a` and j of `b` that may intersect, without
/// omissions, those with the same j consecutively. The order depends on the arguments only; with `likely_first` the
/// boxes with the largest overlap come first. Boxes are compared along the axes of both meshes, triangles along their
/// own axes and normals, eight at once in floats with a bound on their error. Requires a.unit >= b.unit. `gap`, if not
/// null, is lowered to a lower bound on the distance (metres) of triangles that are not visited; it is meaningless if
/// the visitor ends the traversal.
void traverse(const MeshModel& a, const MeshModel& b, const TriangleTest& frame, bool likely_first,
              PairVisitor& visitor, double* gap = nullptr);

/// Independent pairs of subtrees: together they visit what traverse() does. At least `wanted`, unless there is less to
/// do.
std::vector<NodePair> traversal_subtrees(const MeshModel& a, const MeshModel& b, const TriangleTest& frame,
                                         std::size_t wanted, double* gap = nullptr);
void traverse(const MeshModel& a, const MeshModel& b, const TriangleTest& frame, NodePair subtrees,
              PairVisitor& visitor, double* gap = nullptr);

}  // namespace tandem
