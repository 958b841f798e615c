// Where the ridges of two meshes cross: contacts that lie on no vertex.
#pragma once
#include <optional>

#include "meshes/contacts/crossing_patches.h"

namespace tandem {

/// The stretch of a ridge inside the other mesh.
struct RidgeSpan {
  Vec3 p, q;
  std::uint32_t feature;
};

/// Appends what of the ridges of a mesh lies inside the other: between two piercings, or from one to an end that is
/// inside. Of those that lie inside as a whole the ends say enough.
void find_spans(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings, bool of_a, Memory memory,
                List<RidgeSpan>& spans);

/// How far two such stretches, of A and of B, reach past each other where they cross as seen along n: within `slack` of
/// their ends, too, which lie over the other's where a face stands along n.
std::optional<double> overlap_of_ridges(const RidgeSpan& a, const RidgeSpan& b, const Vec3& n, double slack,
                                        Vec3& point);

/// As many of the stretches as are held against others: those that reach farthest along n, of alike ones those that lie
/// farthest along a direction of their own.
List<const RidgeSpan*> farthest_spans(std::span<const RidgeSpan> spans, const Vec3& n, double slack, Memory memory);

}  // namespace tandem
