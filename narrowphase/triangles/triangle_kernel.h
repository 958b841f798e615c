#pragma once

namespace tandem {

/// The sides of a triangle: column j has corner j and its edge to the next corner, the last column as the first.
struct alignas(32) TriangleParts {
  double corner[3][4], edge[3][4];
  double length2[4];  ///< of the edges
  double area[3];     ///< the product of two edges in turn: twice the area long, along the normal
};

/// Separations along the products of edges i of A and j of B, in row i and column j; at most that of the shapes, to
/// rounding. Minus infinity along products of edges that are almost parallel, which `doubtful` holds at bit 4 i + j.
struct alignas(32) EdgeProducts {
  double separation[3][4];
  unsigned doubtful;
};

/// The products of the edges of two triangles as A sees them.
void triangle_products(const TriangleParts& a, const TriangleParts& b, EdgeProducts& out);
/// The products of the edges of a box (half sizes, at the origin, along the axes) and a triangle.
void box_triangle_products(const double (&half)[3], const TriangleParts& b, EdgeProducts& out);

/// Squared distances of corner i of one from edge j of the other, in row i and column j: of A's corners, then of B's.
struct alignas(32) CornerOffsets {
  double from_a[3][4], from_b[3][4];
};
void corner_offsets(const TriangleParts& a, const TriangleParts& b, CornerOffsets& out);

/// Edge j of the triangle and the box: squared distance, and where on the edge (0 to 1) it is met.
struct alignas(32) EdgeOffsets {
  double squared[4], at[4];
};
void edge_offsets(const double (&half)[3], const TriangleParts& b, EdgeOffsets& out);

}  // namespace tandem
