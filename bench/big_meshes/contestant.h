// What makes meshes ready and asks them, of one library each.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

using TrianglePairs = std::vector<std::array<std::uint32_t, 2>>;

/// Two meshes, and one that has both and so meets itself. What a library cannot do answers nothing.
class MeshContestant {
 public:
  virtual ~MeshContestant() = default;
  virtual std::string name() const = 0;
  virtual int threads() const { return 1; }
  /// Are its pairs right for the real numbers given? Else they may differ where triangles touch to rounding.
  virtual bool is_exact() const = 0;
  /// The largest mesh that it is given, triangles: of more it would take minutes or all memory.
  virtual std::size_t most_triangles() const { return 10'000'000; }
  virtual std::size_t most_triangles_of_self() const { return most_triangles(); }

  /// Makes A ready, anew each time.
  virtual void build() = 0;
  /// Makes all that is asked for ready.
  virtual void build_all() = 0;
  /// Bytes that A takes as it was built, with its vertices and triangles.
  virtual std::size_t memory() = 0;
  /// All pairs of triangles of A and B, as they are given, that meet.
  virtual std::optional<TrianglePairs> pairs() = 0;
  /// All pairs of triangles of the one mesh that meet and share no vertex, the lesser first.
  virtual std::optional<TrianglePairs> self_pairs() = 0;
  /// Of A and B moved, metres; not above 0 where they overlap.
  virtual std::optional<double> distance(const Pose& b) = 0;
};

/// Of A, B and both in one; they outlive it.
struct MeshesGiven {
  const Mesh &a, &b, &both;
};
std::unique_ptr<MeshContestant> tandem_meshes(const MeshesGiven& given, int threads);
std::unique_ptr<MeshContestant> fcl_meshes(const MeshesGiven& given);
std::unique_ptr<MeshContestant> embree_meshes(const MeshesGiven& given, int threads);
std::unique_ptr<MeshContestant> cgal_meshes(const MeshesGiven& given);

/// Bytes of the heap that the process holds.
std::size_t heap_bytes();

}  // namespace tandem::bench
