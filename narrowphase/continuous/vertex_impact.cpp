// The queries of vertex_impact.h: input is checked, and lists are processed in blocks of a fixed size, so that no
// answer depends on the threads.
#include "tandem/narrowphase/vertex_impact.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "continuous/impact_search.h"
#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr std::size_t part_size = 512;

bool in_range(const Vec3& v) { return v.cwiseAbs().maxCoeff() <= tolerance::longest_length && v == v; }

[[noreturn]] void refuse_place(const std::string& what, const Vec3& v) {
  throw std::invalid_argument(what + ": coordinates " + written(v) + " must be " + allowed_coordinate());
}

template <std::size_t Count>
void require(const std::array<Vec3, Count>& corners, const char* what) {
  for (std::size_t i = 0; i < Count; ++i)
    if (!in_range(corners[i])) refuse_place(what + std::string(", vertex ") + std::to_string(i), corners[i]);
}

void require(const ImpactOptions& options) {
  const auto check = [](const char* field, double value, double most) {
    if (value >= 0 && value <= most) return;
    throw std::invalid_argument(std::string("impact options: ") + field + ' ' + written(value) + " must be from 0 to " +
                                written(most));
  };
  check("tolerance", options.tolerance, 0.1);
  check("separation", options.separation, tolerance::longest_length);
}

void require(const MovingVertices& vertices, const char* what) {
  if (vertices.from.size() != vertices.to.size())
    throw std::invalid_argument(std::string(what) + ": " + std::to_string(vertices.from.size()) +
                                " vertices before and " + std::to_string(vertices.to.size()) +
                                " after the step; both must be as many");
  for (const auto& [places, when] : {std::pair(vertices.from, " before"), std::pair(vertices.to, " after")})
    for (std::size_t i = 0; i < places.size(); ++i)
      if (!in_range(places[i]))
        refuse_place(what + std::string(", vertex ") + std::to_string(i) + when + " the step", places[i]);
}

[[noreturn]] void refuse_index(const char* list, std::size_t place, std::uint32_t index, std::size_t count) {
  throw std::invalid_argument(std::string(list) + " " + std::to_string(place) + ": vertex " + std::to_string(index) +
                              " does not exist; the mesh has " + std::to_string(count));
}

void require(std::span<const PointTriangle> pairs, const MovingVertices& points, const MovingVertices& triangles) {
  const auto check = [](std::size_t place, std::uint32_t index, std::size_t count) {
    if (index >= count) refuse_index("pair of point and triangle", place, index, count);
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    check(i, pairs[i].point, points.from.size());
    for (const std::uint32_t v : pairs[i].triangle) check(i, v, triangles.from.size());
  }
}

void require(std::span<const EdgeEdge> pairs, const MovingVertices& a, const MovingVertices& b) {
  const auto check = [](std::size_t place, std::uint32_t index, std::size_t count) {
    if (index >= count) refuse_index("pair of edges", place, index, count);
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (const std::uint32_t v : pairs[i].a) check(i, v, a.from.size());
    for (const std::uint32_t v : pairs[i].b) check(i, v, b.from.size());
  }
}

void require_room(std::size_t impacts, std::size_t pairs) {
  if (impacts != pairs)
    throw std::invalid_argument("impacts: room for " + std::to_string(impacts) + ", but " + std::to_string(pairs) +
                                " pairs; both must be as many");
}

template <std::size_t Count>
std::array<Vec3, Count> corners(std::span<const Vec3> places, const std::array<std::uint32_t, Count>& indices) {
  std::array<Vec3, Count> r;
  for (std::size_t k = 0; k < Count; ++k) r[k] = places[indices[k]];
  return r;
}

VertexImpact impact(const MovingVertices& points, const MovingVertices& triangles, const PointTriangle& pair,
                    const ImpactOptions& options, double until) {
  return search_impact(moving_polygon(points.from[pair.point], corners(triangles.from, pair.triangle),
                                      points.to[pair.point], corners(triangles.to, pair.triangle)),
                       options, until);
}

VertexImpact impact(const MovingVertices& a, const MovingVertices& b, const EdgeEdge& pair,
                    const ImpactOptions& options, double until) {
  return search_impact(
      moving_polygon(corners(a.from, pair.a), corners(b.from, pair.b), corners(a.to, pair.a), corners(b.to, pair.b)),
      options, until);
}

// Runs part(first, last) on blocks of [0, count).
template <class Part>
void share(std::size_t count, const PartRunner& parts, const Part& part) {
  const std::size_t number = (count + part_size - 1) / part_size;
  const auto run = [&](std::size_t i) { part(i * part_size, std::min(count, (i + 1) * part_size)); };
  if (parts && number > 1) return parts(number, run);
  for (std::size_t i = 0; i < number; ++i) run(i);
}

template <class Pair>
void all_impacts(const MovingVertices& a, const MovingVertices& b, std::span<const Pair> pairs,
                 std::span<VertexImpact> impacts, const ImpactOptions& options, const PartRunner& parts) {
  require(options);
  require(a, "first mesh");
  require(b, "second mesh");
  require(pairs, a, b);
  require_room(impacts.size(), pairs.size());
  share(pairs.size(), parts, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) impacts[i] = impact(a, b, pairs[i], options, 1);
  });
}

// The first impact of each block, then of all.
template <class Pair>
void keep_first(const MovingVertices& a, const MovingVertices& b, std::span<const Pair> pairs, ImpactKind kind,
                const ImpactOptions& options, const PartRunner& parts, std::optional<MeshImpact>& first) {
  std::vector<std::optional<MeshImpact>> found((pairs.size() + part_size - 1) / part_size);
  const double until = first ? first->impact.t : 1;
  share(pairs.size(), parts, [&](std::size_t begin, std::size_t end) {
    std::optional<MeshImpact>& best = found[begin / part_size];
    for (std::size_t i = begin; i < end; ++i) {
      const VertexImpact next = impact(a, b, pairs[i], options, best ? best->impact.t : until);
      if (next.hit && (!best || next.t < best->impact.t)) best = MeshImpact{next, kind, static_cast<std::uint32_t>(i)};
    }
  });
  for (const auto& one : found)
    if (one && (!first || one->impact.t < first->impact.t)) first = one;
}

}  // namespace

VertexImpact point_triangle_impact(const Vec3& point_from, const TriangleCorners& triangle_from, const Vec3& point_to,
                                   const TriangleCorners& triangle_to, const ImpactOptions& options) {
  require(options);
  require(std::array{point_from, point_to}, "point");
  require(triangle_from, "triangle before the step");
  require(triangle_to, "triangle after the step");
  return search_impact(moving_polygon(point_from, triangle_from, point_to, triangle_to), options, 1);
}

VertexImpact edge_edge_impact(const EdgeEnds& a_from, const EdgeEnds& b_from, const EdgeEnds& a_to,
                              const EdgeEnds& b_to, const ImpactOptions& options) {
  require(options);
  require(a_from, "first edge before the step");
  require(b_from, "second edge before the step");
  require(a_to, "first edge after the step");
  require(b_to, "second edge after the step");
  return search_impact(moving_polygon(a_from, b_from, a_to, b_to), options, 1);
}

void point_triangle_impacts(const MovingVertices& points, const MovingVertices& triangles,
                            std::span<const PointTriangle> pairs, std::span<VertexImpact> impacts,
                            const ImpactOptions& options, const PartRunner& parts) {
  all_impacts(points, triangles, pairs, impacts, options, parts);
}

void edge_edge_impacts(const MovingVertices& a, const MovingVertices& b, std::span<const EdgeEdge> pairs,
                       std::span<VertexImpact> impacts, const ImpactOptions& options, const PartRunner& parts) {
  all_impacts(a, b, pairs, impacts, options, parts);
}

std::optional<MeshImpact> first_impact(const MovingVertices& a, const MovingVertices& b,
                                       const ImpactCandidates& candidates, const ImpactOptions& options,
                                       const PartRunner& parts) {
  require(options);
  require(a, "first mesh");
  require(b, "second mesh");
  require(candidates.points_of_a, a, b);
  require(candidates.points_of_b, b, a);
  require(candidates.edges, a, b);
  std::optional<MeshImpact> first;
  keep_first(a, b, candidates.points_of_a, ImpactKind::point_of_a, options, parts, first);
  keep_first(b, a, candidates.points_of_b, ImpactKind::point_of_b, options, parts, first);
  keep_first(a, b, candidates.edges, ImpactKind::edges, options, parts, first);
  return first;
}

}  // namespace tandem
