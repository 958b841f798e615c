#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/search.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// A vertex and a triangle that does not have it.
struct NearPoint {
  std::uint32_t vertex, triangle;
  double distance;  ///< metres
};

/// Two edges without a common vertex, each by its ends, the lesser first.
struct NearEdges {
  std::array<std::uint32_t, 2> a, b;
  double distance;  ///< metres
};

/// Pairs of features that are no farther apart than a margin: what a barrier between two surfaces acts on (Li et al.,
/// Incremental Potential Contact, 2020). Sorted by their numbers.
struct NearFeatures {
  std::vector<NearPoint> points;         ///< vertices of A (or of the mesh, with itself), triangles of B
  std::vector<NearPoint> points_of_b;    ///< vertices of B, triangles of A; of a mesh with itself none
  std::vector<NearEdges> edges;          ///< of A and of B; of a mesh with itself a < b
};

/// Finds all pairs of features of two meshes (or triangles) where they are whose distance, computed to rounding, is at
/// most `margin` (metres, finite, >= 0). `parts` (may be empty: the caller) shares the work; the answer does not depend
/// on it. A mesh that repeats vertices has each of them told. Throws std::invalid_argument for another kind of shape, a
/// bad pose or margin.
NearFeatures near_features(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                           const PartRunner& parts = {});

/// Receives pairs of features when they are found, on the calling thread; false ends the search. What is empty is not
/// called; what one throws ends the search and is thrown.
struct NearFeatureVisitor {
  std::function<bool(const NearPoint&)> point{};       ///< a vertex of A (or of the mesh, with itself), a triangle of B
  std::function<bool(const NearPoint&)> point_of_b{};  ///< a vertex of B, a triangle of A
  std::function<bool(const NearEdges&)> edges{};
};

/// Visits the pairs of near_features, each once, in an order that depends on the arguments only. Nothing is kept:
/// beside some bytes for each triangle, memory does not grow with the pairs. Throws as near_features does.
SearchEnd visit_near_features(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                              const NearFeatureVisitor& visitor, const SearchOptions& options = {});

}  // namespace tandem
