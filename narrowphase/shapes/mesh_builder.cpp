// Builds a mesh's model: checks it, joins its triangles at their edges, orients those of a surface, and builds hull and
// hierarchy.
#include "shapes/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "shapes/disjoint_sets.h"
#include "shapes/hull.h"
#include "shapes/hull_builder.h"
#include "shapes/mesh_edges.h"
#include "shapes/mesh_hierarchy.h"
#include "shapes/run_parts.h"
#include "shapes/work_meter.h"
#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {
namespace {

[[noreturn]] void refuse(const std::string& why) { throw std::invalid_argument("mesh: " + why); }

void turn_all(MeshModel& mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

// Numbers of connected components, for each vertex: vertices connected by triangles have one number, unused vertices
// none; numbered in the order of the triangles.
std::vector<std::uint32_t> numbers_of_components(const MeshModel& mesh, WorkMeter& meter) {
  DisjointSets sets(mesh.vertices.size());
  for (std::uint32_t v = 0; v < mesh.representatives.size(); ++v) sets.join(v, mesh.representatives[v]);
  for (const auto& t : mesh.triangles) {
    meter.spend();
    for (std::size_t k = 1; k < 3; ++k) sets.join(t[0], t[k]);
  }
  std::vector<std::uint32_t> number(mesh.vertices.size(), no_index), component(mesh.vertices.size(), no_index);
  std::uint32_t count = 0;
  for (const auto& t : mesh.triangles) {
    meter.spend();
    std::uint32_t& at = number[sets.find(t[0])];
    if (at == no_index) at = count++;
    for (const std::uint32_t v : t) component[v] = at;
  }
  return component;
}

std::vector<MeshModel::Component> extremes_of_components(const MeshModel& mesh,
                                                         const std::vector<std::uint32_t>& number, WorkMeter& meter) {
  std::vector<MeshModel::Component> components;
  for (const auto& t : mesh.triangles) {
    meter.spend();
    const std::uint32_t at = number[t[0]];
    if (at == components.size()) components.emplace_back().fill(t[0]);
    MeshModel::Component& component = components[at];
    for (const std::uint32_t v : t)
      for (std::size_t k = 0; k < 6; ++k) {
        const auto axis = static_cast<Eigen::Index>(k / 2);
        const double beyond = mesh.vertices[v][axis] - mesh.vertices[component[k]][axis];
        if (k % 2 == 0 ? beyond < 0 : beyond > 0) component[k] = v;
      }
  }
  return components;
}

double six_volumes(const MeshModel& mesh, std::span<const Vec3> vertices, const PartRunner& parts) {
  const Vec3 about = mesh.centre;
  std::vector<double> sums(chunks(mesh.triangles.size(), elements_per_chunk), 0);
  run_chunks(parts, mesh.triangles.size(), elements_per_chunk, [&](std::size_t k, std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto& t = mesh.triangles[i];
      sum += (vertices[t[0]] - about).dot((vertices[t[1]] - about).cross(vertices[t[2]] - about));
    }
    sums[k] = sum;
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

// True if a closed surface has no concave edge.
bool has_convex_edges(const MeshModel& mesh, const WorkLimit* limit) {
  WorkMeter meter(limit);
  const MeshModel::Neighbours& neighbours = mesh.neighbours(limit);
  const double flat = tolerance::flat_hull * 2 * mesh.half.norm();
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    meter.spend();
    const auto [p, q, r] = mesh.corners(i);
    const Vec3 n = (q - p).cross(r - p);
    const double area = n.norm();
    if (area <= flat * mesh.half.norm()) continue;
    for (const std::uint32_t t : neighbours[i]) {
      if (t == no_index) continue;
      for (const Vec3& v : mesh.corners(t))
        if (n.dot(v - p) > flat * area) return false;
    }
  }
  return true;
}

// True if a closed surface without concave edges is that of its hull: all vertices then lie on the hull, the area says
// that the hull is covered once, and the volume that it is filled. (Cubes that touch along edges, as the dark squares
// of a board of 3 x 3, have the area of their hull.)
bool covers_hull(const MeshModel& mesh, const WorkLimit* limit) {
  WorkMeter meter(limit);
  const Hull& hull = mesh.hull(limit);
  if (hull.dimension < 3) return false;
  const double flat = tolerance::flat_hull * 2 * mesh.half.norm();
  double of_hull = 0, of_mesh = 0, volume = six_volumes(mesh, mesh.vertices, {});
  for (const Hull::Face& f : hull.faces) {
    meter.spend();
    const Vec3& corner = hull.vertices[hull.loop[f.first]];
    for (std::uint32_t k = 2; k < f.count; ++k) {
      const Vec3 area =
          (hull.vertices[hull.loop[f.first + k - 1]] - corner).cross(hull.vertices[hull.loop[f.first + k]] - corner);
      of_hull += area.norm();
      volume -= area.dot(corner - mesh.centre);
    }
  }
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    meter.spend();
    const auto [p, q, r] = mesh.corners(i);
    of_mesh += (q - p).cross(r - p).norm();
  }
  if (!(std::abs(of_mesh - of_hull) <= tolerance::same_area * of_hull)) return false;
  if (!(std::abs(volume) <= tolerance::same_area * of_hull * mesh.half.norm())) return false;
  std::vector<std::uint8_t> known(mesh.vertices.size(), 0);
  for (const std::uint32_t v : mesh.extreme(limit)) known[v] = 1;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      if (known[v]) continue;
      known[v] = 1;
      meter.spend(1 + static_cast<int>(hull.faces.size() / 64));
      const Vec3& p = mesh.vertices[v];
      const bool on_it = std::any_of(hull.faces.begin(), hull.faces.end(),
                                     [&](const Hull::Face& f) { return f.offset - f.normal.dot(p) <= flat; });
      if (!on_it) return false;
    }
  return true;
}

// The index of the first vertex that is not finite; the number of vertices if all are.
std::size_t first_not_finite(const std::vector<Vec3>& vertices, const PartRunner& parts) {
  std::vector<std::size_t> first(chunks(vertices.size(), elements_per_chunk), vertices.size());
  run_chunks(parts, vertices.size(), elements_per_chunk, [&](std::size_t k, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && first[k] == vertices.size(); ++i)
      if (!vertices[i].allFinite()) first[k] = i;
  });
  return std::accumulate(first.begin(), first.end(), vertices.size(),
                         [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

// Throws for the first fault; else returns the box of the used vertices.
Extent checked_extent(const Mesh& mesh, const PartRunner& parts) {
  if (mesh.triangles.empty()) refuse("triangles is empty; at least one is needed");
  constexpr std::size_t most = 0x0fffffff;
  if (mesh.triangles.size() > most)
    refuse("triangles holds " + std::to_string(mesh.triangles.size()) + "; at most " + std::to_string(most) +
           " are allowed");
  if (const std::size_t i = first_not_finite(mesh.vertices, parts); i < mesh.vertices.size())
    refuse("vertices[" + std::to_string(i) + "] is " + written(mesh.vertices[i]) + "; it must be finite");
  struct Some {
    Extent extent{};
    std::size_t faulty = no_index;  // the first faulty triangle
  };
  std::vector<Some> some(chunks(mesh.triangles.size(), elements_per_chunk));
  run_chunks(parts, mesh.triangles.size(), elements_per_chunk, [&](std::size_t k, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && some[k].faulty == no_index; ++i)
      for (const std::uint32_t v : mesh.triangles[i]) {
        if (v < mesh.vertices.size())
          some[k].extent.add(mesh.vertices[v]);
        else
          some[k].faulty = std::min(some[k].faulty, i);
      }
  });
  Extent box;
  for (const Some& s : some) {
    box.add(s.extent);
    if (s.faulty == no_index) continue;
    const auto& t = mesh.triangles[s.faulty];
    const std::size_t k = t[0] >= mesh.vertices.size() ? 0 : t[1] >= mesh.vertices.size() ? 1 : 2;
    refuse("triangles[" + std::to_string(s.faulty) + "][" + std::to_string(k) + "] is " + std::to_string(t[k]) +
           "; it must be below the number of vertices, " + std::to_string(mesh.vertices.size()));
  }
  return box;
}

// The points that triangles use: unused vertices do not belong to the surface.
struct UsedPoints {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> vertex;

  explicit UsedPoints(const MeshModel& model) {
    const std::vector<std::uint8_t> used = vertices_in_use(model);
    for (std::uint32_t v = 0; v < used.size(); ++v)
      if (used[v]) {
        points.push_back(model.vertices[v]);
        vertex.push_back(v);
      }
  }
};

MeshHull hull_of_points(const UsedPoints& used, const WorkLimit* limit) {
  MeshHull made{build_hull(used.points, limit), {}};
  // The hull keeps its vertices in the given order, each with the given bits.
  for (std::size_t i = 0, k = 0; i < used.points.size() && k < made.hull.vertices.size(); ++i)
    if (used.points[i] == made.hull.vertices[k]) made.extreme.push_back(used.vertex[i]), ++k;
  return made;
}

// Determines the neighbours of triangles, and orients connected ones alike. Returns the representative of each vertex.
std::vector<std::uint32_t> add_surface(MeshModel& model, const PartRunner& parts, BuildMeter& meter) {
  std::vector<std::uint32_t> first = join_triangles(model, parts, meter);
  if (!model.solid && model.closed && six_volumes(model, model.vertices, parts) < 0) turn_all(model);
  for (std::uint32_t v = 0; v < first.size() && model.representatives.empty(); ++v)
    if (first[v] != v) model.representatives = first;
  if (!model.solid) return first;
  if (const auto volume = inside_out(model, model.vertices, parts))
    refuse("solid, but its volume is " + written(*volume) +
           "; it must not be negative (triangles counterclockwise seen from outside)");
  return first;
}

}  // namespace

std::vector<std::uint8_t> vertices_in_use(const MeshModel& mesh) {
  std::vector<std::uint8_t> used(mesh.vertices.size(), 0);
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) used[v] = 1;
  return used;
}

std::optional<double> inside_out(const MeshModel& mesh, std::span<const Vec3> vertices, const PartRunner& parts) {
  const double volumes = six_volumes(mesh, vertices, parts);
  if (!(volumes < -tolerance::inside_out * mesh.half.squaredNorm() * mesh.half.norm())) return std::nullopt;
  return volumes / 6;
}

const MeshModel::Neighbours& MeshModel::neighbours(const WorkLimit* limit) const {
  return neighbours_->get(limit, [&](const WorkLimit* own) { return find_neighbours(*this, own); });
}

const MeshHull& MeshModel::with_hull(const WorkLimit* limit) const {
  return hull_.get(limit, [&](const WorkLimit* own) {
    WorkMeter(own).spend();  // before the vertices are gathered
    return hull_of_points(UsedPoints(*this), own);
  });
}

bool MeshModel::own_hull(const WorkLimit* limit) const {
  if (!closed) return false;
  return own_hull_.get(limit,
                       [&](const WorkLimit* own) { return has_convex_edges(*this, own) && covers_hull(*this, own); });
}

const std::vector<MeshModel::Component>& MeshModel::components(const WorkLimit* limit) const {
  return components_.get(limit, [&](const WorkLimit* own) {
    WorkMeter meter(own);
    const auto& numbers = component_numbers_.get(own, [&](const WorkLimit* of_numbers) {
      WorkMeter numbering(of_numbers);
      return numbers_of_components(*this, numbering);
    });
    return extremes_of_components(*this, numbers, meter);
  });
}

ShapeMemory MeshModel::memory() const {
  const auto bytes = [](const auto&... list) { return (std::size_t(0) + ... + (list.capacity() * sizeof(list[0]))); };
  ShapeMemory memory;
  memory.surface = bytes(vertices, triangles);
  memory.adjacency = bytes(representatives);
  if (const Neighbours* made = neighbours_->made()) memory.adjacency += bytes(*made);
  memory.hierarchy = bytes(nodes, blocks, boxes, slabs, order);
  if (const MeshHull* made = hull_.made()) memory.hull = sizeof(MeshHull) + made->hull.memory() + bytes(made->extreme);
  memory.other = sizeof(MeshModel);
  if (const auto* made = component_numbers_.made()) memory.other += bytes(*made);
  if (const auto* made = components_.made()) memory.other += bytes(*made);
  if (const NormalCones* made = cones_.made()) memory.other += made->memory();
  if (const KeptCosines* made = least_cosines_.made()) memory.other += made->memory();
  return memory;
}

MeshModel build_mesh(Mesh mesh, const BuildOptions& options, std::vector<std::uint32_t>* first) {
  const std::size_t count = mesh.triangles.size();
  BuildMeter meter(options, joining_work(count) + hierarchy_work(count));
  MeshModel model;
  model.frame() = MeshFrame(checked_extent(mesh, options.parts));
  meter.spend(0);
  model.vertices = std::move(mesh.vertices);
  model.triangles = std::move(mesh.triangles);
  model.solid = mesh.solid;
  std::vector<std::uint32_t> welded = add_surface(model, options.parts, meter);
  build_hierarchy(model, options.parts, meter);
  meter.finish();
  if (first != nullptr) *first = std::move(welded);
  return model;
}

}  // namespace tandem
