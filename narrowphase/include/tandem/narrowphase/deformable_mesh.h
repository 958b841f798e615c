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

/// What an update did.
struct DeformReport {
  /// Triangles of subtrees of the hierarchy that were built anew, as refits had made them slow; all or some.
  std::size_t rebuilt_triangles = 0;
  /// How much the area of boxes above the leaves has grown since they were built, beside that of the leaves: the most
  /// of any subtree, before it was built anew. A measure of what queries cost; 1 as built.
  double worn = 1;
};

/// A mesh whose vertices move while its triangles stay: cloth, a membrane, a body that bends. `shape()` is the mesh as
/// it is now, for queries, scenes and steps, and stays so: an update changes no Shape that was handed out. Answers are
/// those of Shape(Mesh) with the same vertices and triangles.
///
/// Which triangles lie side by side stays as it was in the beginning: vertices that were one stay one, others do not
/// become one where they come to lie at the same place, which Shape(Mesh) would take for a seam.
///
/// One update at a time; queries of shapes handed out may run meanwhile.
class DeformableMesh {
 public:
  /// Throws std::invalid_argument as Shape(Mesh) does. `parts` (may be empty: the caller) shares the work.
  explicit DeformableMesh(Mesh mesh, const PartRunner& parts = {});
  ~DeformableMesh();
  DeformableMesh(DeformableMesh&&) noexcept;
  DeformableMesh& operator=(DeformableMesh&&) noexcept;

  /// Moves the vertices, metres: as many as the mesh has, in its order. Boxes are made anew where they are; subtrees
  /// that have become slow by a measure of their boxes are built anew. No answer depends on that but depths that are
  /// `inexact`, whose bound holds either way, and none on `parts`, which shares the work. Throws std::invalid_argument,
  /// and nothing has changed, if a vertex is not finite or beyond 1e30, the number is another one, the extent is not 0
  /// and below 1e-30, vertices that were one have parted, or a closed mesh would be inside out. Where `parts` or the
  /// memory fails, the mesh is as before or as after the update.
  DeformReport update(std::span<const Vec3> vertices, const PartRunner& parts = {});

  /// As of the last update. Shapes of one update share what they hold; where none but the last one is left, the next
  /// update writes into the memory of an older one.
  Shape shape() const;
  std::span<const Vec3> vertices() const;  ///< valid until the next update
  std::span<const std::array<std::uint32_t, 3>> triangles() const;  ///< turned alike, as Shape::triangles

  /// All pairs of triangles [i, j], i < j, that share no vertex and meet: exact, closed triangles, so that a touch
  /// counts; sorted. The same on any number of threads.
  std::vector<std::array<std::uint32_t, 2>> self_intersections(const PartRunner& parts = {}) const;

  /// All pairs of a vertex and a triangle that does not have it, and of edges without a common vertex, that are no
  /// farther apart than `margin` (metres, finite, >= 0); vertices that are one are told as the first of them.
  NearFeatures near_features(double margin, const PartRunner& parts = {}) const;

  /// Visit the same pairs, each once, when they are found, on the calling thread; false ends the search. Nothing is
  /// kept. The order depends on the mesh only. In the second the visitor's `point_of_b` is not called.
  SearchEnd visit_self_intersections(const std::function<bool(const std::array<std::uint32_t, 2>&)>& visitor,
                                     const SearchOptions& options = {}) const;
  SearchEnd visit_near_features(double margin, const NearFeatureVisitor& visitor,
                                const SearchOptions& options = {}) const;

  /// Bytes held, those of shapes of earlier updates included that are still in use.
  std::size_t memory() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
