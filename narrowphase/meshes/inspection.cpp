// Finds the faults of a mesh: duplicates, degenerate triangles, edges that do not join two triangles of opposite
// direction, components that are inside out, self-intersections.
#include "tandem/narrowphase/inspection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "meshes/traversal/mesh_traversal.h"
#include "shapes/disjoint_sets.h"
#include "shapes/mesh_builder.h"
#include "shapes/mesh_hierarchy.h"
#include "shapes/vertex_weld.h"
#include "shapes/written.h"
#include "tolerances.h"
#include "triangles/predicates.h"

namespace tandem {
namespace {

void require(const Mesh& mesh) {
  if (mesh.triangles.empty()) throw std::invalid_argument("mesh: no triangles; there must be at least one");
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (!(mesh.vertices[v].array().abs() <= tolerance::longest_length).all())
      throw std::invalid_argument("mesh: vertices[" + std::to_string(v) + "] is " + written(mesh.vertices[v]) +
                                  "; it must be " + allowed_coordinate());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const std::uint32_t v : mesh.triangles[i])
      if (v >= mesh.vertices.size())
        throw std::invalid_argument("mesh: triangle " + std::to_string(i) + ": vertex " + std::to_string(v) +
                                    ", must be below " + std::to_string(mesh.vertices.size()));
}

struct HalfEdge {
  std::uint32_t lo, hi, triangle;
  bool up;  // runs from lo to hi
};

class Inspector {
 public:
  Inspector(const Mesh& mesh, const InspectionOptions& options)
      : mesh_(mesh),
        most_(options.most),
        first_(weld(mesh.vertices)),
        connected_(mesh.triangles.size()),
        left_out_(mesh.triangles.size(), false),
        open_(mesh.triangles.size(), false),
        exact_(Pose{}, Pose{}, reach()) {
    found_.vertices = mesh.vertices.size();
    found_.triangles = mesh.triangles.size();
    duplicates();
    flat_triangles();
    edges();
    components();
    crossings(options);
  }
  MeshInspection take() { return std::move(found_); }

 private:
  double reach() const {
    double most = 0;
    for (const auto& t : mesh_.triangles)
      for (const std::uint32_t v : t) most = std::max(most, mesh_.vertices[v].cwiseAbs().maxCoeff());
    return most;
  }
  std::array<std::uint32_t, 3> welded(std::uint32_t i) const {
    const auto& t = mesh_.triangles[i];
    return {first_[t[0]], first_[t[1]], first_[t[2]]};
  }
  Corners corners(std::uint32_t i) const {
    const auto& t = mesh_.triangles[i];
    return {mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]};
  }
  Vec3 middle(std::uint32_t i) const {
    const Corners c = corners(i);
    return c[0] / 3 + c[1] / 3 + c[2] / 3;
  }
  template <class Fault>
  void add(FaultList<Fault>& list, const Fault& fault) const {
    if (list.count++ < most_) list.first.push_back(fault);
  }

  void duplicates() {
    for (std::uint32_t v = 0; v < first_.size(); ++v)
      if (first_[v] != v) add(found_.duplicate_vertices, {v, first_[v], mesh_.vertices[v]});
    std::vector<std::pair<std::array<std::uint32_t, 3>, std::uint32_t>> all;
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      all.emplace_back(welded(i), i);
      std::sort(all.back().first.begin(), all.back().first.end());
    }
    std::sort(all.begin(), all.end());
    std::vector<std::array<std::uint32_t, 2>> pairs;
    for (std::size_t k = 1, original = 0; k < all.size(); ++k) {
      if (all[k].first != all[k - 1].first) original = k;
      if (original != k) pairs.push_back({all[k].second, all[original].second});
    }
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [i, same_as] : pairs) {
      add(found_.duplicate_triangles, {i, same_as, middle(i)});
      left_out_[i] = true;
    }
  }

  void flat_triangles() {
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i)
      if (is_flat(corners(i))) {
        add(found_.flat_triangles, {i, middle(i)});
        left_out_[i] = true;
      }
  }

  // True if the three points are collinear: tested in doubles first.
  bool is_flat(const Corners& c) {
    const Vec3 u = c[1] - c[0], v = c[2] - c[0];
    const double bound = 16 * epsilon * u.lpNorm<1>() * v.lpNorm<1>() + std::numeric_limits<double>::min();
    if (u.cross(v).cwiseAbs().maxCoeff() > bound) return false;
    for (std::size_t k = 0; k < 3; ++k)
      if (meet({c[k], c[k], c[k]}, {c[(k + 1) % 3], c[(k + 2) % 3], c[(k + 2) % 3]})) return true;
    return false;
  }

  void edges() {
    std::vector<HalfEdge> sides;
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      const auto t = welded(i);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t p = t[k], q = t[(k + 1) % 3];
        if (p != q) sides.push_back({std::min(p, q), std::max(p, q), i, p < q});
      }
    }
    std::sort(sides.begin(), sides.end(), [](const HalfEdge& x, const HalfEdge& y) {
      return std::tie(x.lo, x.hi, x.triangle, x.up) < std::tie(y.lo, y.hi, y.triangle, y.up);
    });
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
      for (end = begin; end < sides.size() && sides[end].lo == sides[begin].lo && sides[end].hi == sides[begin].hi;)
        ++end;
      edge(std::span(sides).subspan(begin, end - begin));
    }
  }

  void edge(std::span<const HalfEdge> sides) {
    const auto up =
        static_cast<std::size_t>(std::count_if(sides.begin(), sides.end(), [](const HalfEdge& s) { return s.up; }));
    const HalfEdge& s = sides.front();
    for (const HalfEdge& other : sides) connected_.join(s.triangle, other.triangle);
    if (sides.size() == 2 && up == 1) return;
    const EdgeFault fault = sides.size() == 1   ? EdgeFault::open
                            : sides.size() == 2 ? EdgeFault::inconsistent
                                                : EdgeFault::non_manifold;
    add(found_.faulty_edges,
        {fault, {s.lo, s.hi}, {mesh_.vertices[s.lo], mesh_.vertices[s.hi]}, s.triangle, up, sides.size() - up});
    for (const HalfEdge& other : sides) open_[other.triangle] = true;
  }

  struct Component {
    std::vector<std::uint32_t> triangles;
    bool closed = true;
    double six_volumes = 0;
    Extent box{};
  };

  void components() {
    std::vector<Component> all;
    std::vector<std::size_t> place(mesh_.triangles.size());
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      const std::uint32_t r = connected_.find(i);
      if (r == i) place[i] = all.size(), all.emplace_back();
      Component& c = all[place[r]];
      c.triangles.push_back(i);
      c.closed = c.closed && !open_[i];
      for (const Vec3& v : corners(i)) c.box.add(v);
    }
    found_.components = all.size();
    for (Component& c : all) {
      const Vec3 centre = c.box.lo + (c.box.hi - c.box.lo) / 2;
      for (const std::uint32_t i : c.triangles) {
        const auto [p, q, r] = corners(i);
        c.six_volumes += (p - centre).dot((q - centre).cross(r - centre));
      }
    }
    for (const Component& c : all) {
      const double size = (c.box.hi - c.box.lo).norm();
      if (!c.closed || c.six_volumes >= -tolerance::inside_out * size * size * size) continue;
      const Vec3 corner = corners(c.triangles.front())[0];
      if (windings(all, c, corner) <= 0)
        add(found_.inside_out, {c.triangles.front(), c.triangles.size(), c.six_volumes / 6, corner});
    }
  }

  // The winding number of all closed components but one about a point, from their solid angles (van Oosterom, Strackee,
  // The solid angle of a plane triangle, 1983).
  double windings(const std::vector<Component>& all, const Component& but, const Vec3& point) const {
    double sum = 0;
    for (const Component& c : all) {
      const bool is_around = ((point.array() >= c.box.lo.array()) && (point.array() <= c.box.hi.array())).all();
      if (&c == &but || !c.closed || !is_around) continue;
      for (const std::uint32_t i : c.triangles) {
        const Corners t = corners(i);
        const Vec3 x = t[0] - point, y = t[1] - point, z = t[2] - point;
        const double a = x.norm(), b = y.norm(), d = z.norm();
        sum += 2 * std::atan2(x.dot(y.cross(z)), a * b * d + x.dot(y) * d + y.dot(z) * a + z.dot(x) * b);
      }
    }
    return std::round(sum / (4 * std::numbers::pi));
  }

  void crossings(const InspectionOptions& options) {
    MeshModel model;
    model.vertices = mesh_.vertices;
    std::vector<std::uint32_t> number;  // number of each triangle of the model in the mesh
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i)
      if (!left_out_[i]) model.triangles.push_back(mesh_.triangles[i]), number.push_back(i);
    if (number.empty()) return;
    Extent box;
    for (const auto& t : model.triangles)
      for (const std::uint32_t v : t) box.add(mesh_.vertices[v]);
    model.frame() = MeshFrame(box);
    build_hierarchy(model, options.parts);
    CrossingPairs visitor(*this, number, options.limit);
    traverse(model, model, exact_, false, visitor);
    found_.self_intersections.count = visitor.count();
    for (const auto& pair : visitor.first())
      found_.self_intersections.first.push_back({pair, between(pair[0], pair[1])});
  }

  // Counts intersecting pairs and keeps the first.
  class CrossingPairs : public PairVisitor {
   public:
    CrossingPairs(Inspector& all, std::span<const std::uint32_t> number, const WorkLimit* limit)
        : PairVisitor(limit), all_(all), number_(number) {}
    bool visit(std::uint32_t first, std::uint32_t second) override {
      const std::uint32_t i = number_[first], j = number_[second];
      if (i >= j) return false;
      meter.spend(pair_work);
      if (!all_.cross(i, j)) return false;
      ++count_;
      pairs_.push_back({i, j});
      if (pairs_.size() > 2 * all_.most_ + 64) keep_first();
      return false;
    }
    std::size_t count() const { return count_; }
    const std::vector<std::array<std::uint32_t, 2>>& first() {
      keep_first();
      return pairs_;
    }

   private:
    void keep_first() {
      std::sort(pairs_.begin(), pairs_.end());
      pairs_.resize(std::min(pairs_.size(), all_.most_));
    }
    static constexpr int pair_work = 2;  // units of WorkMeter
    Inspector& all_;
    std::span<const std::uint32_t> number_;
    std::size_t count_ = 0;
    std::vector<std::array<std::uint32_t, 2>> pairs_;
  };

  Vec3 between(std::uint32_t i, std::uint32_t j) const {
    const Corners p = corners(i), q = corners(j);
    const auto low = [](const Corners& c) { return c[0].cwiseMin(c[1]).cwiseMin(c[2]); };
    const auto high = [](const Corners& c) { return c[0].cwiseMax(c[1]).cwiseMax(c[2]); };
    return low(p).cwiseMax(low(q)) / 2 + high(p).cwiseMin(high(q)) / 2;
  }

  bool meet(const Corners& p, const Corners& q) { return exact_(p, q, q); }

  static bool boxes_apart(const Corners& p, const Corners& q) {
    for (int k = 0; k < 3; ++k) {
      const auto [low_p, high_p] = std::minmax({p[0][k], p[1][k], p[2][k]});
      const auto [low_q, high_q] = std::minmax({q[0][k], q[1][k], q[2][k]});
      if (high_p < low_q || high_q < low_p) return true;
    }
    return false;
  }

  // Two triangles that share corners, rotated so that these come first. If they share one, their intersection continues
  // from it to where it leaves one of them, across the opposite side. If they share two, they overlap only when folded
  // flat.
  bool cross(std::uint32_t i, std::uint32_t j) {
    const auto vi = welded(i), vj = welded(j);
    std::array<std::array<std::size_t, 2>, 9> shared;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l)
        if (vi[k] == vj[l]) shared[count++] = {k, l};
    const Corners p = corners(i), q = corners(j);
    if (count == 0) return meet(p, q);
    if (count == 1) {
      const auto opposite = [](const Corners& c, std::size_t k) {
        return Corners{c[(k + 1) % 3], c[(k + 2) % 3], c[(k + 2) % 3]};
      };
      const Corners side_p = opposite(p, shared[0][0]), side_q = opposite(q, shared[0][1]);
      // Most pairs of triangles about one vertex are separated by their boxes.
      return (!boxes_apart(side_p, q) && meet(side_p, q)) || (!boxes_apart(p, side_q) && meet(p, side_q));
    }
    const Vec3 u = p[shared[0][0]], v = p[shared[1][0]], a = p[3 - shared[0][0] - shared[1][0]],
               b = q[3 - shared[0][1] - shared[1][1]];
    return meet({a, a, a}, q) || meet({b, b, b}, p) || meet({u, a, a}, {v, b, b}) || meet({v, a, a}, {u, b, b});
  }

  const Mesh& mesh_;
  const std::size_t most_;
  std::vector<std::uint32_t> first_;   // of the vertices at each vertex's position
  DisjointSets connected_;             // triangles, by edges
  std::vector<bool> left_out_, open_;  // duplicate or flat; beside a faulty edge
  TriangleTest exact_;
  MeshInspection found_;
};

}  // namespace

std::string_view name(EdgeFault fault) {
  switch (fault) {
    case EdgeFault::open:
      return "open";
    case EdgeFault::non_manifold:
      return "non-manifold";
    default:
      return "inconsistent";
  }
}

MeshInspection inspect(const Mesh& mesh, const InspectionOptions& options) {
  require(mesh);
  return Inspector(mesh, options).take();
}

}  // namespace tandem
