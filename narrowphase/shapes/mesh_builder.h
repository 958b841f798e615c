// From a mesh as given to what queries need: checked, its triangles joined at their edges, its hierarchy.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "shapes/mesh_model.h"
#include "tandem/narrowphase/build_options.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// Throws std::invalid_argument naming the mesh's first fault: no triangles, a vertex that is not finite, an index
/// out of range, or for a solid mesh an edge that does not join triangles in opposite sense.
/// WorkStopped where the options' limit was reached. The model does not depend on the options. `first`, if not null, gets
/// for each vertex the one that stands for it: the first of those with equal coordinates, or nearly so on a surface's
/// borders.
MeshModel build_mesh(Mesh mesh, const BuildOptions& options = {}, std::vector<std::uint32_t>* first = nullptr);

/// A box that grows with the points it holds.
struct Extent {
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 hi = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& p) { lo = lo.cwiseMin(p), hi = hi.cwiseMax(p); }
  void add(const Extent& o) { lo = lo.cwiseMin(o.lo), hi = hi.cwiseMax(o.hi); }
};

/// Where a mesh's hierarchy is, and in which unit: as in MeshModel.
struct MeshFrame {
  Vec3 centre, half;
  double unit = 1;
  explicit MeshFrame(const Extent& box);
};

/// Of each vertex: whether a triangle has it.
std::vector<std::uint8_t> vertices_in_use(const MeshModel& mesh);

/// How far apart, along an axis, the corners of a surface's borders may be that are one; metres.
double seam_tolerance(const MeshFrame& frame);

/// The volume of the closed mesh with these vertices, where that is less than none: it is inside out.
std::optional<double> inside_out(const MeshModel& mesh, std::span<const Vec3> vertices, const MeshFrame& frame,
                                 const PartRunner& parts = {});

}  // namespace tandem
