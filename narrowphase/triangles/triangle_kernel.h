// Separations along the edge axes of triangles and boxes, and nearest points of their edges.
#pragma once

namespace tandem {

/// The edges of a triangle, one a column, the fourth equal to the first: corners, edges to the next corner, squared
/// lengths.
struct alignas(32) EdgeColumns {
  double corner[3][4], edge[3][4];
  double length2[4];
};
struct alignas(32) TriangleColumns : EdgeColumns {
  double area[3];  ///< cross product of two successive edges: twice the area vector
};

/// Separations along the cross products of edge i of A and edge j of B, in row i and column j; at most those of the
/// shapes, to rounding. Minus infinity for edges that are almost parallel, which have bit 4 i + j in `doubtful`.
struct alignas(32) EdgeProducts {
  double separation[3][4];
  unsigned doubtful;
};

/// The edge axes of two triangles in A's frame.
void triangle_products(const TriangleColumns& a, const TriangleColumns& b, EdgeProducts& out);
/// The edge axes of a box (half sizes, at the origin, along the axes) and a triangle.
void box_triangle_products(const double (&half)[3], const TriangleColumns& b, EdgeProducts& out);

/// Squared distances of corner i of one from edge j of the other, in row i and column j: of A's corners, then of B's.
struct alignas(32) CornerOffsets {
  double from_a[3][4], from_b[3][4];
};
void corner_offsets(const TriangleColumns& a, const TriangleColumns& b, CornerOffsets& out);

/// Edge j of the triangle and the box: their squared distance, and the parameter of the nearest point on the edge (0 to
/// 1).
struct alignas(32) EdgeOffsets {
  double squared[4], at[4];
};
void edge_offsets(const double (&half)[3], const TriangleColumns& b, EdgeOffsets& out);

/// The nearest points of edge i of A and edge j of B, in row i and column j (the fourth equals the first): parameters
/// on both edges (0 to 1), and their squared distance. `parallel` has bit 4 i + j where both are nearly parallel, so
/// that their ends must be examined, too.
struct alignas(32) EdgePairs {
  double squared[3][4], on_a[3][4], on_b[3][4];
  unsigned parallel;
};
void nearest_on_edges(const EdgeColumns& a, const EdgeColumns& b, EdgePairs& out);

}  // namespace tandem
