// Checks a mesh, joins its triangles at their edges, turns a surface's alike, and builds hull and hierarchy.
#include "shapes/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>

#include "shapes/hull.h"
#include "shapes/hull_builder.h"
#include "shapes/mesh_hierarchy.h"
#include "tolerances.h"

namespace tandem {
namespace {

// Of the largest coordinate: how far apart the corners of a surface may be that are one.
constexpr double seam_ulps = 16;

[[noreturn]] void refuse(const std::string& why) { throw std::invalid_argument("mesh: " + why); }

/// To find it by, in a refusal, which is short.
std::string short_text(const Vec3& v) {
  std::ostringstream out;
  out << "(" << v.x() << ", " << v.y() << ", " << v.z() << ")";
  return out.str();
}

std::string text(const Vec3& v) {
  std::ostringstream out;
  out.precision(17);
  out << "(" << v.x() << ", " << v.y() << ", " << v.z() << ")";
  return out.str();
}

struct Side {
  std::uint32_t lo, hi;  // welded ends
  bool up;               // runs from lo to hi
  std::uint32_t triangle;
  std::uint8_t corner;
};

// All sides but those without length, by their ends. `first` is what `weld` says. A counting sort by the lower end,
// then those of one vertex, which are few.
std::vector<Side> sorted_sides(const MeshModel& mesh, const std::vector<std::uint32_t>& first) {
  const auto each_side = [&](auto&& take) {
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
      for (std::uint8_t k = 0; k < 3; ++k) {
        const std::uint32_t p = first[mesh.triangles[i][k]], q = first[mesh.triangles[i][(k + 1) % 3]];
        if (p != q) take(Side{std::min(p, q), std::max(p, q), p < q, i, k});
      }
  };
  std::vector<std::uint32_t> begins(mesh.vertices.size() + 1, 0);
  each_side([&](const Side& side) { ++begins[side.lo + 1]; });
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<Side> sides(begins.back());
  std::vector<std::uint32_t> next(begins.begin(), begins.end() - 1);
  each_side([&](const Side& side) { sides[next[side.lo]++] = side; });
  for (std::size_t v = 0; v + 1 < begins.size(); ++v)
    std::stable_sort(sides.begin() + begins[v], sides.begin() + begins[v + 1],
                     [](const Side& a, const Side& b) { return a.hi != b.hi ? a.hi < b.hi : a.up < b.up; });
  return sides;
}

// Lets the corners of a surface's triangles go round as those of the first one they hang together with. Only sides of
// two triangles say how.
void turn_alike(MeshModel& mesh, const std::vector<std::uint32_t>& first) {
  struct Other {
    std::uint32_t triangle = no_index;
    bool against = false;  // the two go round in opposite ways
  };
  std::vector<std::array<Other, 3>> others(mesh.triangles.size());
  const std::vector<Side> sides = sorted_sides(mesh, first);
  bool any = false;
  for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
    for (end = begin; end < sides.size() && sides[end].lo == sides[begin].lo && sides[end].hi == sides[begin].hi;)
      ++end;
    if (end - begin != 2) continue;
    const Side &p = sides[begin], &q = sides[begin + 1];
    others[p.triangle][p.corner] = {q.triangle, p.up == q.up};
    others[q.triangle][q.corner] = {p.triangle, p.up == q.up};
    any = any || p.up == q.up;
  }
  if (!any) return;
  std::vector<std::uint8_t> seen(mesh.triangles.size(), 0);
  std::vector<std::pair<std::uint32_t, bool>> stack;  // with whether it is to be turned
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (seen[i]) continue;
    seen[i] = 1;
    stack.emplace_back(i, false);
    while (!stack.empty()) {
      const auto [t, turned] = stack.back();
      stack.pop_back();
      if (turned) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      for (const Other& o : others[t])
        if (o.triangle != no_index && !seen[o.triangle])
          seen[o.triangle] = 1, stack.emplace_back(o.triangle, turned != o.against);
    }
  }
}

// Lets corners of a surface's borders that differ by rounding be one, as equal ones are: who computes the corners of
// each triangle anew leaves such seams, and there is nothing between two sides of one.
void weld_seams(const MeshModel& mesh, const MeshFrame& frame, std::vector<std::uint32_t>& first) {
  const std::vector<Side> sides = sorted_sides(mesh, first);
  std::vector<std::uint32_t> ends;
  for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
    for (end = begin; end < sides.size() && sides[end].lo == sides[begin].lo && sides[end].hi == sides[begin].hi;)
      ++end;
    if (end - begin == 1) ends.insert(ends.end(), {sides[begin].lo, sides[begin].hi});
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());

  using Cell = std::array<std::int64_t, 3>;
  const double tolerance = seam_tolerance(frame);
  if (ends.empty() || !(tolerance > 0)) return;
  const auto cell = [&](const Vec3& p) {
    const Vec3 q = (p / (2 * tolerance)).array().floor();
    return Cell{static_cast<std::int64_t>(q.x()), static_cast<std::int64_t>(q.y()), static_cast<std::int64_t>(q.z())};
  };
  std::vector<std::pair<Cell, std::uint32_t>> in_cells;
  for (const std::uint32_t v : ends) in_cells.emplace_back(cell(mesh.vertices[v]), v);
  std::sort(in_cells.begin(), in_cells.end());
  const auto root = [&](std::uint32_t v) {
    while (first[v] != v) v = first[v] = first[first[v]];
    return v;
  };
  for (const std::uint32_t v : ends) {
    const Vec3& p = mesh.vertices[v];
    const Cell lo = cell(p - Vec3::Constant(tolerance)), hi = cell(p + Vec3::Constant(tolerance));
    for (std::int64_t x = lo[0]; x <= hi[0]; ++x)
      for (std::int64_t y = lo[1]; y <= hi[1]; ++y)
        for (auto it = std::lower_bound(in_cells.begin(), in_cells.end(), std::pair(Cell{x, y, lo[2]}, 0u));
             it != in_cells.end() && it->first <= Cell{x, y, hi[2]}; ++it) {
          if (it->second >= v || (mesh.vertices[it->second] - p).lpNorm<Eigen::Infinity>() > tolerance) continue;
          const std::uint32_t a = root(it->second), b = root(v);
          first[std::max(a, b)] = std::min(a, b);
        }
  }
  for (std::uint32_t v = 0; v < first.size(); ++v) first[v] = root(v);
}

void turn_all(MeshModel& mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  for (auto& n : mesh.neighbours) std::swap(n[0], n[2]);
}

// Pairs sides of opposite sense. For a solid mesh every side must find its partner.
void join_triangles(MeshModel& mesh, const std::vector<std::uint32_t>& first) {
  const std::vector<Side> sides = sorted_sides(mesh, first);
  mesh.neighbours.assign(mesh.triangles.size(), {no_index, no_index, no_index});
  mesh.closed = true;
  for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
    for (end = begin; end < sides.size() && sides[end].lo == sides[begin].lo && sides[end].hi == sides[begin].hi;)
      ++end;
    std::size_t middle = begin;
    while (middle < end && !sides[middle].up) ++middle;
    const bool joined = middle - begin == end - middle;
    mesh.closed = mesh.closed && joined;
    if (mesh.solid && !joined)
      refuse("solid, but not closed: the edge " + short_text(mesh.vertices[sides[begin].lo]) + " to " +
             short_text(mesh.vertices[sides[begin].hi]) + " of triangle " + std::to_string(sides[begin].triangle) +
             " is in " + std::to_string(end - middle) + " one way, in " + std::to_string(middle - begin) +
             " the other, allowed: as many");
    for (std::size_t i = begin, j = middle; i < middle && j < end; ++i, ++j) {
      mesh.neighbours[sides[i].triangle][sides[i].corner] = sides[j].triangle;
      mesh.neighbours[sides[j].triangle][sides[j].corner] = sides[i].triangle;
    }
  }
}

void find_parts(MeshModel& mesh, const std::vector<std::uint32_t>& first) {
  std::vector<std::uint32_t> parent = first;
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 1; k < 3; ++k) {
      const std::uint32_t p = root(t[0]), q = root(t[k]);
      parent[std::max(p, q)] = std::min(p, q);
    }
  std::vector<std::uint32_t> number(mesh.vertices.size(), no_index);
  mesh.component.assign(mesh.vertices.size(), no_index);
  std::uint32_t count = 0;
  for (const auto& t : mesh.triangles) {
    std::uint32_t& at = number[root(t[0])];
    if (at == no_index) at = count++;
    for (const std::uint32_t v : t) mesh.component[v] = at;
  }
}

std::vector<MeshModel::Component> extremes_of_components(const MeshModel& mesh) {
  std::vector<MeshModel::Component> components;
  for (const auto& t : mesh.triangles) {
    const std::uint32_t at = mesh.component[t[0]];
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

double six_volumes(const MeshModel& mesh, std::span<const Vec3> vertices, const Vec3& about) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += (vertices[t[0]] - about).dot((vertices[t[1]] - about).cross(vertices[t[2]] - about));
  return sum;
}

// Of a closed surface: no edge is concave.
bool has_convex_edges(const MeshModel& mesh) {
  const double flat = tolerance::flat_hull * 2 * mesh.half.norm();
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [p, q, r] = mesh.corners(i);
    const Vec3 n = (q - p).cross(r - p);
    const double area = n.norm();
    if (area <= flat * mesh.half.norm()) continue;
    for (const std::uint32_t t : mesh.neighbours[i]) {
      if (t == no_index) continue;
      for (const Vec3& v : mesh.corners(t))
        if (n.dot(v - p) > flat * area) return false;
    }
  }
  return true;
}

// Is the closed surface without concave edges that of its hull? All vertices then lie on the hull, and the area says that
// the hull is covered once.
bool covers_hull(const MeshModel& mesh) {
  const Hull& hull = mesh.hull();
  if (hull.dimension < 3) return false;
  const double flat = tolerance::flat_hull * 2 * mesh.half.norm();
  double of_hull = 0, of_mesh = 0;
  for (const Hull::Face& f : hull.faces)
    for (std::uint32_t k = 2; k < f.count; ++k)
      of_hull += (hull.vertices[hull.loop[f.first + k - 1]] - hull.vertices[hull.loop[f.first]])
                     .cross(hull.vertices[hull.loop[f.first + k]] - hull.vertices[hull.loop[f.first]])
                     .norm();
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [p, q, r] = mesh.corners(i);
    of_mesh += (q - p).cross(r - p).norm();
  }
  if (!(std::abs(of_mesh - of_hull) <= tolerance::same_area * of_hull)) return false;
  std::vector<std::uint8_t> known(mesh.vertices.size(), 0);
  for (const std::uint32_t v : mesh.extreme()) known[v] = 1;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      if (known[v]) continue;
      known[v] = 1;
      const Vec3& p = mesh.vertices[v];
      const bool on_it = std::any_of(hull.faces.begin(), hull.faces.end(),
                                     [&](const Hull::Face& f) { return f.offset - f.normal.dot(p) <= flat; });
      if (!on_it) return false;
    }
  return true;
}

void check(const Mesh& mesh) {
  if (mesh.triangles.empty()) refuse("triangles is empty; at least one is needed");
  if (mesh.triangles.size() > 0x0fffffff)
    refuse("triangles holds " + std::to_string(mesh.triangles.size()) + "; at most 2^28 - 1 are allowed");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite())
      refuse("vertices[" + std::to_string(i) + "] is " + text(mesh.vertices[i]) + "; it must be finite");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      if (mesh.triangles[i][k] >= mesh.vertices.size())
        refuse("triangles[" + std::to_string(i) + "][" + std::to_string(k) + "] is " +
               std::to_string(mesh.triangles[i][k]) + "; it must be below the number of vertices, " +
               std::to_string(mesh.vertices.size()));
}

// Of what the mesh's triangles use: vertices that none uses are no part of the surface.
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

MeshHull hull_of_points(const UsedPoints& used) {
  MeshHull made{build_hull(used.points), {}};
  // The hull keeps its vertices in the order given, each with the bits given.
  for (std::size_t i = 0, k = 0; i < used.points.size() && k < made.hull.vertices.size(); ++i)
    if (used.points[i] == made.hull.vertices[k]) made.extreme.push_back(used.vertex[i]), ++k;
  return made;
}

// Which triangle lies beside which, all that hang together turned alike. Answers what stands for each vertex.
std::vector<std::uint32_t> add_surface(MeshModel& model, const MeshFrame& frame) {
  std::vector<std::uint32_t> first = weld(model.vertices);
  if (!model.solid) {
    weld_seams(model, frame, first);
    turn_alike(model, first);
  }
  join_triangles(model, first);
  if (!model.solid && model.closed && six_volumes(model, model.vertices, model.centre) < 0) turn_all(model);
  find_parts(model, first);
  if (!model.solid) return first;
  if (const auto volume = inside_out(model, model.vertices, frame))
    refuse("solid, but its volume is " + std::to_string(*volume) +
           "; it must not be negative (triangles counterclockwise seen from outside)");
  return first;
}

}  // namespace

std::vector<std::uint32_t> weld(const std::vector<Vec3>& vertices) {
  const auto less = [&](std::uint32_t i, std::uint32_t j) {
    const Vec3 &p = vertices[i], &q = vertices[j];
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    if (p.z() != q.z()) return p.z() < q.z();
    return i < j;
  };
  std::vector<std::uint32_t> order(vertices.size()), first(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), less);
  for (std::size_t k = 0; k < order.size(); ++k)
    first[order[k]] = k > 0 && vertices[order[k]] == vertices[order[k - 1]] ? first[order[k - 1]] : order[k];
  return first;
}

std::vector<std::uint8_t> vertices_in_use(const MeshModel& mesh) {
  std::vector<std::uint8_t> used(mesh.vertices.size(), 0);
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) used[v] = 1;
  return used;
}

MeshFrame::MeshFrame(const Extent& box) : centre(box.lo + (box.hi - box.lo) / 2) {
  half = (box.hi - centre).cwiseMax(centre - box.lo);
  if (const double most = half.maxCoeff(); most > 0) unit = std::exp2(std::ceil(std::log2(most)) + 1);
}

double seam_tolerance(const MeshFrame& frame) {
  return seam_ulps * epsilon * (frame.centre.cwiseAbs() + frame.half).maxCoeff();
}

std::optional<double> inside_out(const MeshModel& mesh, std::span<const Vec3> vertices, const MeshFrame& frame) {
  const double volumes = six_volumes(mesh, vertices, frame.centre);
  if (!(volumes < -tolerance::inside_out * frame.half.squaredNorm() * frame.half.norm())) return std::nullopt;
  return volumes / 6;
}

const MeshHull& MeshModel::with_hull() const {
  return hull_.get([this] { return hull_of_points(UsedPoints(*this)); });
}

bool MeshModel::own_hull() const {
  if (!closed) return false;
  return own_hull_.get([this] { return has_convex_edges(*this) && covers_hull(*this); });
}

const std::vector<MeshModel::Component>& MeshModel::components() const {
  return components_.get([this] { return extremes_of_components(*this); });
}

std::size_t MeshModel::memory() const {
  const auto bytes = [](const auto&... list) { return (std::size_t(0) + ... + (list.capacity() * sizeof(list[0]))); };
  const MeshHull* made = hull_.made();
  return sizeof(MeshModel) + bytes(vertices, triangles, neighbours, component, nodes, blocks, slabs, order) +
         (made != nullptr ? sizeof(MeshHull) + made->hull.memory() + bytes(made->extreme) : 0);
}

MeshModel build_mesh(Mesh mesh, const PartRunner& parts, std::vector<std::uint32_t>* first) {
  check(mesh);
  MeshModel model;
  model.vertices = std::move(mesh.vertices);
  model.triangles = std::move(mesh.triangles);
  model.solid = mesh.solid;
  Extent box;
  const std::vector<std::uint8_t> used = vertices_in_use(model);
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) box.add(model.vertices[v]);
  const MeshFrame frame(box);
  model.centre = frame.centre, model.half = frame.half, model.unit = frame.unit;
  std::vector<std::uint32_t> welded = add_surface(model, frame);
  build_hierarchy(model, parts);
  if (first != nullptr) *first = std::move(welded);
  return model;
}

}  // namespace tandem
