// Contestants of the bench of large meshes: a library each, which builds its hierarchies and answers queries.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tandem/narrowphase/shape.h"
#include "triangle_pairs.h"

namespace tandem::bench {

/// Two meshes A and B, and a third that holds both and so intersects itself, as one library has them. A query that the
/// library does not have returns nothing.
class MeshContestant {
 public:
  virtual ~MeshContestant() = default;
  virtual std::string name() const = 0;
  virtual int threads() const { return 1; }
  /// True if its pairs are right for the real numbers given; others may differ where triangles touch to rounding.
  virtual bool is_exact() const = 0;
  /// The largest mesh that it is given, in triangles: a larger one would take minutes or all memory.
  virtual std::size_t most_triangles() const { return 10'000'000; }
  virtual std::size_t most_triangles_of_self() const { return most_triangles(); }

  /// Builds A, anew each time.
  virtual void build() = 0;
  /// Builds all that the queries need.
  virtual void build_all() = 0;
  /// Bytes of A as it was built, with its vertices and triangles.
  virtual std::size_t memory() = 0;
  /// All pairs of triangles of A and B, in their given poses, that intersect.
  virtual std::optional<TrianglePairs> pairs() = 0;
  /// All pairs of triangles of the third mesh that intersect and share no vertex, the lesser index first.
  virtual std::optional<TrianglePairs> self_pairs() = 0;
  /// The distance of A and of B moved to this pose, metres; not above 0 where they overlap.
  virtual std::optional<double> distance(const Pose& b) = 0;
};

/// The meshes A, B and both in one; they outlive the contestants.
struct MeshesGiven {
  const Mesh &a, &b, &both;
};
std::unique_ptr<MeshContestant> tandem_meshes(const MeshesGiven& given, int threads);
std::unique_ptr<MeshContestant> fcl_meshes(const MeshesGiven& given);
std::unique_ptr<MeshContestant> embree_meshes(const MeshesGiven& given, int threads);
std::unique_ptr<MeshContestant> cgal_meshes(const MeshesGiven& given);

/// Heap memory in use by the process, bytes.
std::size_t heap_bytes();

}  // namespace tandem::bench
