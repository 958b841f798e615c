// The curves along which the surfaces of two meshes cross, and the patches that they bound.
#pragma once
#include "meshes/contacts/posed_meshes.h"
#include "meshes/traversal/meeting_pairs.h"

namespace tandem {

/// Where a curve enters or leaves a triangle: an edge of one mesh through the inside of a triangle of the other.
struct Piercing {
  Vec3 point;
  bool edge_of_a;
  std::uint32_t triangle, corner;  // the edge: from this corner to the next
  std::uint32_t from, to;          // its vertices
  double fraction;                 // along it, 0..1
  bool from_inside;                // `from` is on the inner side there
};

struct Crossing {
  Piercing end[2];                         // in the curve's sense: what of A is inside to the left, seen from outside A
  std::array<std::uint32_t, 2> triangles;  // of A, of B
};

/// A point of one mesh inside the other, and what it is called.
struct Candidate {
  Vec3 point;
  bool of_a;
  std::uint32_t feature;
};

struct Patch {
  explicit Patch(Memory memory)
      : crossings(memory), vertices(memory), triangles{List<std::uint32_t>(memory), List<std::uint32_t>(memory)} {}
  List<std::uint32_t> crossings;
  List<Candidate> vertices;                      // inside the other mesh; A's come first
  std::array<List<std::uint32_t>, 2> triangles;  // of B, of A: crossed or inside the other mesh
};

/// `pairs`: triangles that meet; `parts` shares the work where there are many.
class CrossingPatches {
 public:
  CrossingPatches(const PosedMeshes& m, std::span<const TrianglePair> pairs, const PartRunner& parts, Memory memory);

  std::span<const Crossing> crossings() const { return crossings_; }
  std::span<const Patch> patches() const { return patches_; }

 private:
  List<Crossing> crossings_;
  List<Patch> patches_;
};

}  // namespace tandem
