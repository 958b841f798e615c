// Depth-first descent over the boxes of a mesh's hierarchy.
#pragma once
#include <array>
#include <cstdint>

#include "shapes/mesh_model.h"
#include "shapes/work_meter.h"

namespace tandem {

/// Calls visit(triangle) for the triangles whose boxes, like those above them, reaches(boxes, lane) accepts, until it
/// returns true; returns whether it did. Boxes are in the mesh's units about its centre. The order depends on the
/// mesh only.
template <class Reaches, class Visit>
bool visit_triangles(const MeshModel& mesh, WorkMeter& meter, const Reaches& reaches, const Visit& visit) {
  std::array<std::uint32_t, most_mesh_levels * mesh_lanes> stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const MeshNode& n = mesh.nodes[stack[--top]];
    meter.spend();
    LaneBoxes room;
    const LaneBoxes& boxes = mesh.lane_boxes(n, room);
    for (std::uint32_t k = 0; k < n.lanes(); ++k) {
      if (!reaches(boxes, k)) continue;
      if (!n.bottom())
        stack[top++] = mesh.boxes_of(n).child[k];
      else if (visit(mesh.triangle_of(n, k)))
        return true;
    }
  }
  return false;
}

}  // namespace tandem
