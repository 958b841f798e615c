// Inspection of meshes: faults with their positions.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// The number of faults of a kind, and the first of them.
template <class Fault>
struct FaultList {
  std::size_t count = 0;
  std::vector<Fault> first;  ///< in the order of the mesh; at most InspectionOptions::most
};

struct DuplicateVertex {
  std::uint32_t vertex, same_as;  ///< same_as: the first vertex with these coordinates
  Vec3 place;
};
struct DuplicateTriangle {
  std::uint32_t triangle, same_as;  ///< same_as: a triangle with the same three positions, in either orientation
  Vec3 place;                       ///< its centroid
};
struct FlatTriangle {
  std::uint32_t triangle;
  Vec3 place;  ///< its centroid
};

enum class EdgeFault : std::uint8_t {
  open,          ///< has one triangle
  non_manifold,  ///< has more than two
  inconsistent,  ///< has two that run along it in the same direction: one has the wrong orientation
};
std::string_view name(EdgeFault fault);

struct FaultyEdge {
  EdgeFault fault;
  std::array<std::uint32_t, 2> vertices;  ///< the first ones with their coordinates
  std::array<Vec3, 2> ends;
  std::uint32_t triangle;   ///< one of its triangles
  std::size_t forward = 0;  ///< triangles that run along it from the first vertex to the second
  std::size_t backward = 0;  ///< triangles that run from the second to the first
};
struct InsideOut {
  std::uint32_t triangle;  ///< the first of the component
  std::size_t triangles;   ///< number of triangles
  double volume;           ///< m^3, < 0
  Vec3 place;              ///< a vertex
};
struct SelfIntersection {
  std::array<std::uint32_t, 2> triangles;
  Vec3 place;  ///< near the intersection: the centre of the intersection of their boxes
};

/// The faults of a mesh. Vertices with equal coordinates count as one.
struct MeshInspection {
  std::size_t vertices = 0, triangles = 0;
  std::size_t components = 0;  ///< number of components of triangles connected by edges
  FaultList<DuplicateVertex> duplicate_vertices;
  FaultList<DuplicateTriangle> duplicate_triangles;
  FaultList<FlatTriangle> flat_triangles;  ///< exactly without area
  FaultList<FaultyEdge> faulty_edges;      ///< not shared by exactly two triangles of opposite direction
  /// Components without faulty edges and of negative volume that are not the boundary of a cavity: no other component
  /// encloses their first vertex.
  FaultList<InsideOut> inside_out;
  /// Triangles that intersect elsewhere than in corners and edges they share; exact for the coordinates. Flat and
  /// duplicate triangles are left out.
  FaultList<SelfIntersection> self_intersections;

  bool closed() const { return faulty_edges.count == 0; }
  /// True if the mesh is closed, does not intersect itself and is not inside out: a solid in every sense. Duplicate
  /// vertices are permitted.
  bool is_clean_solid() const {
    return closed() && duplicate_triangles.count == 0 && flat_triangles.count == 0 && inside_out.count == 0 &&
           self_intersections.count == 0;
  }
};

struct InspectionOptions {
  std::size_t most = 100;  ///< faults kept in each list
  /// Distributes the work of building a hierarchy over threads; the answer does not depend on it.
  PartRunner parts{};
  /// Ends the search for self-intersections, by WorkStopped. n triangles about one vertex are n^2 / 2 pairs.
  const WorkLimit* limit = nullptr;
};

/// Inspects a mesh. Throws std::invalid_argument, as Shape does, for one that cannot be read as a mesh: no triangles, a
/// vertex that is not finite or is larger than 1e30, an index out of range. Throws WorkStopped once the limit is
/// reached.
MeshInspection inspect(const Mesh& mesh, const InspectionOptions& options = {});

}  // namespace tandem
