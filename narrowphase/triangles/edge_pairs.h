// The nearest points of the edges of two triangles.
#pragma once

namespace tandem {

/// The edges of a triangle, one a column, the fourth equal to the first: corners, edges to the next corner, squared
/// lengths.
struct alignas(32) EdgeColumns {
  double corner[3][4], edge[3][4];
  double length2[4];
};

/// The nearest points of edge i of A and edge j of B, in row i and column j (the fourth equals the first): parameters
/// on both edges (0 to 1), and their squared distance. `parallel` has bit 4 i + j where both are nearly parallel, so
/// that their ends must be examined, too.
struct alignas(32) EdgePairs {
  double squared[3][4], on_a[3][4], on_b[3][4];
  unsigned parallel;
};
void nearest_on_edges(const EdgeColumns& a, const EdgeColumns& b, EdgePairs& out);

}  // namespace tandem
