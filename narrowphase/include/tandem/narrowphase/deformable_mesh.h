// Meshes whose vertices move: refitting of the hierarchy, self-intersections, near features.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "tandem/narrowphase/near_features.h"
#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The report of an update.
struct DeformReport {
  /// Triangles in subtrees of the hierarchy that were built anew, since refits had made them slow; all or some.
  std::size_t rebuilt_triangles = 0;
  /// The growth of the area of the boxes above the leaves since they were built, relative to that of the leaves: the
  /// largest of any subtree, before it was built anew. A measure of the cost of queries; 1 as built.
  double worn = 1;
};

/// A mesh with moving vertices and constant triangles: cloth, a membrane, an elastic body. `shape()` returns the
/// current mesh for queries, scenes and steps; later updates do not change a returned Shape. Answers are those of
/// Shape(Mesh) with the same vertices and triangles.
///
/// The adjacency of triangles remains that of the initial mesh: vertices that coincided then stay merged, others do not
/// merge when they coincide later, while Shape(Mesh) would merge them.
///
/// Updates must not run concurrently; queries of returned shapes may run during an update.
class DeformableMesh {
 public:
  /// Throws std::invalid_argument as Shape(Mesh) does. `parts` distributes the work over threads; empty: the caller
  /// does it.
  explicit DeformableMesh(Mesh mesh, const PartRunner& parts = {});
  ~DeformableMesh();
  DeformableMesh(DeformableMesh&&) noexcept;
  DeformableMesh& operator=(DeformableMesh&&) noexcept;

  /// Sets the vertices, metres: as many as the mesh has, in its order. Boxes are refitted in place; subtrees that have
  /// become slow, by a measure of their boxes, are built anew. Answers do not depend on that, except for depths that
  /// are `inexact`, whose bound holds either way; nor on `parts`, which distributes the work. Throws
  /// std::invalid_argument, without any change, if a vertex is not finite or beyond 1e30, their number is wrong, the
  /// extent is not 0 and below 1e-30, vertices that were one have separated, or a closed mesh would be inside out. If
  /// `parts` or an allocation fails, the mesh is as before or as after the update.
  DeformReport update(std::span<const Vec3> vertices, const PartRunner& parts = {});

  /// The mesh as of the last update. Shapes of one update share their data; where only the last shape is left, the next
  /// update reuses the memory of an older one.
  Shape shape() const;
  std::span<const Vec3> vertices() const;  ///< valid until the next update
  std::span<const std::array<std::uint32_t, 3>> triangles() const;  ///< oriented alike, as Shape::triangles

  /// All pairs of triangles [i, j], i < j, that share no vertex and intersect: exact, closed triangles, so that
  /// touching counts; sorted. The same for any number of threads.
  std::vector<std::array<std::uint32_t, 2>> self_intersections(const PartRunner& parts = {}) const;

  /// All pairs of a vertex and a triangle without it, and of edges without a common vertex, that are at most `margin`
  /// apart (metres, finite, >= 0); coincident vertices are reported as the first of them.
  NearFeatures near_features(double margin, const PartRunner& parts = {}) const;

  /// The same pairs, each visited once when it is found, on the calling thread; false ends the search. No list is kept.
  /// The order depends on the mesh only. The second does not call the visitor's `point_of_b`.
  SearchEnd visit_self_intersections(const std::function<bool(const std::array<std::uint32_t, 2>&)>& visitor,
                                     const SearchOptions& options = {}) const;
  SearchEnd visit_near_features(double margin, const NearFeatureVisitor& visitor,
                                const SearchOptions& options = {}) const;

  /// Bytes held, including those of shapes of earlier updates that are still in use.
  std::size_t memory() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
