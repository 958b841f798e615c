// Pairs of features of two meshes within a margin.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/search.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// A vertex and a triangle that does not contain it.
struct NearPoint {
  std::uint32_t vertex, triangle;
  double distance;  ///< metres
};

/// Two edges without a common vertex, each by its ends, the lesser first.
struct NearEdges {
  std::array<std::uint32_t, 2> a, b;
  double distance;  ///< metres
};

/// Pairs of features that are at most a margin apart: the pairs on which a barrier between two surfaces acts (Li et
/// al., Incremental Potential Contact, 2020). Sorted by their indices.
struct NearFeatures {
  std::vector<NearPoint> points;         ///< vertices of A (or of the mesh, with itself), triangles of B
  std::vector<NearPoint> points_of_b;    ///< vertices of B, triangles of A; for a mesh with itself none
  std::vector<NearEdges> edges;          ///< of A and of B; for a mesh with itself a < b
};

/// Finds all pairs of features of two posed meshes (or triangles) whose distance, computed to rounding, is at most
/// `margin` (metres, finite, >= 0). `parts` (empty: the caller) distributes the work over threads; the answer does not
/// depend on it. Duplicate vertices of a mesh are all reported. Throws std::invalid_argument for another kind of shape,
/// a bad pose or margin.
NearFeatures near_features(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                           const PartRunner& parts = {});

/// Receives pairs of features when they are found, on the calling thread; false ends the search. Empty functions are
/// not called; an exception ends the search and is rethrown.
struct NearFeatureVisitor {
  std::function<bool(const NearPoint&)> point{};       ///< a vertex of A (or of the mesh, with itself), a triangle of B
  std::function<bool(const NearPoint&)> point_of_b{};  ///< a vertex of B, a triangle of A
  std::function<bool(const NearEdges&)> edges{};
};

/// Visits the pairs of near_features, each once, in an order that depends on the arguments only. No list is kept:
/// beside some bytes for each triangle, memory does not grow with the number of pairs. Throws as near_features does.
SearchEnd visit_near_features(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                              const NearFeatureVisitor& visitor, const SearchOptions& options = {});

}  // namespace tandem
