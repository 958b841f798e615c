// The curves along which the surfaces of two meshes cross, and the patches that they bound.
#pragma once
#include "meshes/contacts/posed_meshes.h"
#include "meshes/traversal/meeting_pairs.h"

namespace tandem {

/// A point where a curve enters or leaves a triangle: an edge of one mesh passes through a triangle of the other.
struct Piercing {
  Vec3 point;
  bool edge_of_a;
  std::uint32_t triangle, corner;  // the edge, from this corner to the next
  std::uint32_t from, to;          // the edge's vertices
  double fraction;                 // position along the edge, 0..1
  bool from_inside;                // `from` is on the inner side there
};

struct Crossing {
  // In the direction of the curve: the part of A inside B is to the left, seen from outside A.
  Piercing end[2];
  std::array<std::uint32_t, 2> triangles;  // of A, of B
};

/// A point of one mesh inside the other, with its feature name.
struct Candidate {
  Vec3 point;
  bool of_a;
  std::uint32_t feature;
};

struct Patch {
  explicit Patch(Memory memory)
      : crossings(memory), vertices(memory), triangles{List<std::uint32_t>(memory), List<std::uint32_t>(memory)} {}
  List<std::uint32_t> crossings;
  List<Candidate> vertices;                      // vertices inside the other mesh; A's come first
  std::array<List<std::uint32_t>, 2> triangles;  // of B, of A: triangles crossed or inside the other mesh
};

/// `pairs`: intersecting triangles; `parts` distributes the work if there are many.
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
