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

/// How many there are, and the first of them.
template <class Fault>
struct FaultList {
  std::size_t count = 0;
  std::vector<Fault> first;  ///< in the order of the mesh; InspectionOptions::most at most
};

struct DuplicateVertex {
  std::uint32_t vertex, same_as;  ///< same_as: the first vertex with these coordinates
  Vec3 place;
};
struct DuplicateTriangle {
  std::uint32_t triangle, same_as;  ///< the same three places, in either sense
  Vec3 place;                       ///< the middle of its corners
};
struct FlatTriangle {
  std::uint32_t triangle;
  Vec3 place;  ///< the middle of its corners
};

enum class EdgeFault : std::uint8_t {
  open,          ///< of one triangle
  non_manifold,  ///< of more than two
  inconsistent,  ///< of two that run along it in the same sense: one is turned over
};
std::string_view name(EdgeFault fault);

struct FaultyEdge {
  EdgeFault fault;
  std::array<std::uint32_t, 2> vertices;  ///< the first ones with their coordinates
  std::array<Vec3, 2> ends;
  std::uint32_t triangle;   ///< one of its triangles
  std::size_t forward = 0;  ///< triangles that run from the first vertex to the second
  std::size_t backward = 0; ///< from the second to the first
};
struct InsideOut {
  std::uint32_t triangle;  ///< the first of the component
  std::size_t triangles;   ///< how many it has
  double volume;           ///< m^3, < 0
  Vec3 place;              ///< a corner
};
struct SelfIntersection {
  std::array<std::uint32_t, 2> triangles;
  Vec3 place;  ///< the middle of what their boxes share: near it
};

/// What is found in a mesh that may not be as it should. Vertices with equal coordinates count as one.
struct MeshInspection {
  std::size_t vertices = 0, triangles = 0;
  std::size_t components = 0;  ///< of triangles that hang together by edges
  FaultList<DuplicateVertex> duplicate_vertices;
  FaultList<DuplicateTriangle> duplicate_triangles;
  FaultList<FlatTriangle> flat_triangles;  ///< without area, exactly
  FaultList<FaultyEdge> faulty_edges;      ///< not joined by exactly two triangles in opposite sense
  /// Components without faulty edges, of negative volume, that are not the border of a cavity: the others do not go
  /// round their first corner.
  FaultList<InsideOut> inside_out;
  /// Triangles that meet elsewhere than in the corners and edges they share; exact for the coordinates. Flat and
  /// duplicate triangles are left out.
  FaultList<SelfIntersection> self_intersections;

  bool closed() const { return faulty_edges.count == 0; }
  /// Closed, and nothing of it crosses itself or is inside out: a solid in every sense. Duplicate vertices are allowed.
  bool is_clean_solid() const {
    return closed() && duplicate_triangles.count == 0 && flat_triangles.count == 0 && inside_out.count == 0 &&
           self_intersections.count == 0;
  }
};

struct InspectionOptions {
  std::size_t most = 100;  ///< faults kept in each list
  PartRunner parts{};      ///< shares the work of building a hierarchy; the answer does not depend on it
  /// Ends the search for triangles that cross, by WorkStopped. n triangles about one vertex are n^2 / 2 pairs.
  const WorkLimit* limit = nullptr;
};

/// Throws std::invalid_argument, as Shape does, for a mesh that is none: no triangles, a vertex that is not finite or
/// is larger than 1e30, an index out of range.
/// Throws WorkStopped once the limit is reached.
MeshInspection inspect(const Mesh& mesh, const InspectionOptions& options = {});

}  // namespace tandem
