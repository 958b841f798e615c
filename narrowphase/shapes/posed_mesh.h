// A shape with its pose; a mesh's hull as a convex shape.
#pragma once
#include <array>

#include "shapes/convex_view.h"
#include "shapes/mesh_model.h"

namespace tandem {

/// A shape with its pose.
struct Posed {
  const Shape& shape;
  const Pose& pose;
};

inline bool has_triangles(const Shape& s) { return s.kind() == ShapeKind::mesh || s.kind() == ShapeKind::triangle; }

/// An upper bound on the absolute coordinates of the vertices.
inline double reach(const MeshModel& mesh) { return (mesh.centre.cwiseAbs() + mesh.half).maxCoeff(); }

/// The mesh's hull as a convex shape; the limit may end the building of the hull.
ConvexView view_hull(const Shape& mesh, const WorkLimit* limit);

}  // namespace tandem
