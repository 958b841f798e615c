#pragma once
#include "shapes/mesh_model.h"
#include "triangles/predicates.h"

namespace tandem {

/// How the boxes of B lie in A's frame, in units of A, in floats with a bound on their error.
struct TraversalFrame {
  float map[3][3];      // B's boxes to A's axes, scaled
  float inverse[3][3];  // A's axes to B's, not scaled
  float shift[3];
  float ratio;     // of the units, at most 1
  float pad_a[3];  // more than floats are off by along A's axes, rounding of the test itself included
  float pad_b[3];  // along B's
  float off;       // bound on the error of any coordinate
  double gap = 0;  // between the whole boxes, along A's axes; > 0: apart, and nothing else is set

  TraversalFrame(const MeshModel& a, const MeshModel& b, const TriangleTest& frame);
};

}  // namespace tandem
