// The generalised winding number by the borders of subtrees, and a solid of the points where it is inside.
#include "tandem/narrowphase/winding_number.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>

#include "meshes/traversal/hierarchy.h"
#include "shapes/shape_insides.h"
#include "shapes/work_meter.h"
#include "shapes/written.h"
#include "tandem/narrowphase/build_options.h"
#include "tandem/narrowphase/shape_makers.h"
#include "tolerances.h"

namespace tandem {
namespace {

// An edge with the number of a subtree's triangles that run along it from `from` to `to`, minus those in the other
// direction; from < to.
struct BorderEdge {
  std::uint32_t from, to;
  int times;

  bool operator<(const BorderEdge& o) const { return from != o.from ? from < o.from : to < o.to; }
};

BorderEdge edge(std::uint32_t from, std::uint32_t to) {
  return from < to ? BorderEdge{from, to, 1} : BorderEdge{to, from, -1};
}

// Sorts, adds up equal edges, removes those that cancel.
void add_up(std::vector<BorderEdge>& edges) {
  std::sort(edges.begin(), edges.end());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges.size();) {
    BorderEdge sum = edges[i++];
    for (; i < edges.size() && edges[i].from == sum.from && edges[i].to == sum.to; ++i) sum.times += edges[i].times;
    if (sum.times != 0 && sum.from != sum.to) edges[kept++] = sum;
  }
  edges.resize(kept);
}

// Half the solid angle of a triangle as seen from the origin (Van Oosterom and Strackee, The solid angle of a plane
// triangle, 1983).
double half_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm(), longest = std::max({la, lb, lc});
  // The product of three would overflow; only directions matter.
  if (longest > 1e90) return half_angle(a / longest, b / longest, c / longest);
  const double over = a.dot(b.cross(c)), under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return over == 0 && under == 0 ? 0 : std::atan2(over, under);
}

[[noreturn]] void refuse(const std::string& what, double found, const char* allowed) {
  throw std::invalid_argument("voxel_solid: " + what + " " + written(found) + ", allowed: " + allowed);
}

}  // namespace

struct WindingNumber::Insides {
  Insides(const Mesh& given, const WorkLimit* limit)
      : surface(Mesh{given.vertices, given.triangles, false}, BuildOptions{.limit = limit}),
        mesh(mesh_of(surface)),
        triangles(given.triangles),
        first(mesh_lanes * mesh.nodes.size()),
        count(first.size()) {
    border_of(0);
  }

  double at(const Vec3& place) const {
    double sum = 0;
    std::array<std::uint32_t, most_mesh_levels * mesh_lanes> stack;
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const std::uint32_t node = stack[--top];
      for (std::uint32_t k = 0; k < mesh.nodes[node].lanes(); ++k) {
        const std::uint32_t ref = child_ref(node, k);
        if (is_leaf(mesh, ref)) {
          const auto& v = triangles[leaf_triangle(mesh, ref)];
          sum += half_angle(mesh.vertices[v[0]] - place, mesh.vertices[v[1]] - place, mesh.vertices[v[2]] - place);
          continue;
        }
        const BoxOf box(mesh, ref);
        const Vec3 away = (place - box.mid).cwiseAbs() - box.half;
        if (away.maxCoeff() <= tolerance::place_rounding * mesh.unit) {
          stack[top++] = node_under(mesh, ref);
          continue;
        }
        // Closed by triangles from the border to the box's centre.
        for (const BorderEdge& e : border(node, k))
          sum += e.times * half_angle(mesh.vertices[e.from] - place, mesh.vertices[e.to] - place, box.mid - place);
      }
    }
    return sum / (2 * std::numbers::pi);
  }

  const Shape surface;  ///< whose hierarchy is used: its triangles may be reoriented
  const MeshModel& mesh;
  const std::vector<std::array<std::uint32_t, 3>> triangles;  ///< as given
  std::vector<BorderEdge> edges;
  std::vector<std::uint32_t> first, count;  ///< of the edges, by node and lane

 private:
  std::span<const BorderEdge> border(std::uint32_t node, std::uint32_t lane) const {
    const std::size_t at = mesh_lanes * node + lane;
    return {edges.data() + first[at], count[at]};
  }

  // The border of all below a node; those of its inner children are stored.
  std::vector<BorderEdge> border_of(std::uint32_t node) {
    std::vector<BorderEdge> all;
    for (std::uint32_t k = 0; k < mesh.nodes[node].lanes(); ++k) {
      const std::uint32_t ref = child_ref(node, k);
      if (is_leaf(mesh, ref)) {
        const auto& v = triangles[leaf_triangle(mesh, ref)];
        for (std::size_t i = 0; i < 3; ++i)
          all.push_back(edge(mesh.representative(v[i]), mesh.representative(v[(i + 1) % 3])));
        continue;
      }
      const std::vector<BorderEdge> below = border_of(node_under(mesh, ref));
      const std::size_t at = mesh_lanes * node + k;
      first[at] = static_cast<std::uint32_t>(edges.size());
      count[at] = static_cast<std::uint32_t>(below.size());
      edges.insert(edges.end(), below.begin(), below.end());
      all.insert(all.end(), below.begin(), below.end());
    }
    add_up(all);
    return all;
  }
};

WindingNumber::WindingNumber(const Mesh& mesh) : insides_(std::make_shared<const Insides>(mesh, nullptr)) {}

double WindingNumber::at(const Vec3& place) const { return insides_->at(place); }

Shape voxel_solid(const Mesh& mesh, const VoxelSolidOptions& options) {
  if (!(options.size > 0) || !std::isfinite(options.size)) refuse("size", options.size, "finite, > 0");
  if (!std::isfinite(options.least)) refuse("least", options.least, "finite");
  const WindingNumber::Insides winding(mesh, options.limit);
  const Vec3 half = winding.mesh.half * (1 + tolerance::place_rounding);
  const Vec3 low = ((winding.mesh.centre - half) / options.size).array().floor();
  const Vec3 high = ((winding.mesh.centre + half) / options.size).array().ceil();
  constexpr double farthest = 1 << 20;  // cells from the origin, as for voxels
  const double far = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (!(far < farthest)) refuse("cells from the origin,", far, ("less than " + written(farthest)).c_str());
  const double cells = (high - low).prod();
  if (!(cells <= static_cast<double>(options.most_cells)))
    refuse("cells of the mesh's box,", cells, ("at most most_cells, " + std::to_string(options.most_cells)).c_str());
  std::vector<std::array<std::int32_t, 3>> inside;
  WorkMeter meter(options.limit);
  for (double x = low.x(); x < high.x(); ++x)
    for (double y = low.y(); y < high.y(); ++y)
      for (double z = low.z(); z < high.z(); ++z) {
        meter.spend(16);
        if (winding.at(options.size * (Vec3(x, y, z) + Vec3::Constant(0.5))) >= options.least)
          inside.push_back({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)});
      }
  if (inside.empty()) refuse("cells inside,", 0, "one or more");
  return voxel_mesh(inside, options.size);
}

}  // namespace tandem
