// Contacts of flat faces of two meshes that have sunk into each other.
#include "meshes/contacts/face_overlaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "manifold/manifold.h"
#include "shapes/metered_sort.h"
#include "shapes/support.h"
#include "tolerances.h"

namespace tandem {
namespace {

// The coplanar triangles of a mesh at a patch.
struct CoplanarFacets {
  Vec3 n;  // unit, from A to B
  double level, area;
  List<Facet> facets;

  bool is_level(const std::array<Vec3, 3>& p, double slack) const {
    return std::all_of(p.begin(), p.end(), [&](const Vec3& v) { return std::abs(n.dot(v) - level) <= slack; });
  }
  // Tests the corners first: most facets lie elsewhere, and few are oriented otherwise.
  bool contains(const Facet& f, double slack) const { return is_level(f.p, slack) && n.dot(f.n) > 0.5; }
};

// The coplanar region of a facet: facets of the patch, extended as far as the other mesh's box. Where edges coincide,
// rounding decides how far the curve extends.
CoplanarFacets coplanar_facets(const PosedMeshes& m, std::span<const Facet> facets, const Facet& seed, bool of_a,
                               double slack, Memory memory) {
  constexpr std::size_t most = 512;
  const auto& neighbours = m.mesh(of_a).neighbours();
  const Vec3 centre = of_a ? m.frame.in_a(m.b.centre) : m.a.centre,
             half = of_a ? Vec3(m.frame.map().cwiseAbs() * m.b.half) : m.a.half;
  CoplanarFacets face{seed.n, seed.n.dot(seed.p[0]), 0, List<Facet>(memory)};
  WorkMeter meter(m.limit);
  for (const Facet& f : facets)
    if (face.contains(f, slack)) face.facets.push_back(f);
  for (std::size_t i = 0; i < face.facets.size() && face.facets.size() < most; ++i) {
    meter.spend(8);
    for (const std::uint32_t next : neighbours[face.facets[i].triangle]) {
      if (next == no_index) continue;
      const std::array<Vec3, 3> p = m.corners(of_a, next);
      const Vec3 lo = p[0].cwiseMin(p[1]).cwiseMin(p[2]), hi = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
      const bool is_near =
          ((lo - centre - half).array() <= slack).all() && ((centre - half - hi).array() <= slack).all();
      if (!is_near || !face.is_level(p, slack)) continue;
      const bool is_known =
          std::any_of(face.facets.begin(), face.facets.end(), [&](const Facet& f) { return f.triangle == next; });
      if (is_known) continue;
      const Facet f = facet_of(m, of_a, next);
      if (face.contains(f, slack)) face.facets.push_back(f);
    }
  }
  std::sort(face.facets.begin(), face.facets.end(),
            [](const Facet& x, const Facet& y) { return x.triangle < y.triangle; });
  for (const Facet& f : face.facets) face.area += area_vector(f.p).norm() / 2;
  return face;
}

// The overlap of a face of A and one of B that face each other and have sunk into each other.
struct FaceOverlap {
  const CoplanarFacets *of_a, *of_b;
  Vec3 n;  // normal of the larger face
  double depth = 0, width = 0, area = 0;
  List<Contact> points;
};

// Sets the corners of the overlap's outline along n. `scratch` is unchanged afterwards.
void outline(FaceOverlap& overlap, double size, Memory memory, const WorkLimit* limit, std::vector<Contact>& scratch) {
  WorkMeter meter(limit);
  const Vec3& n = overlap.n;
  constexpr std::uint32_t made_up = 0xffffffffu;  // a deepest point added for lack of others
  constexpr double any_depth = std::numeric_limits<double>::infinity();
  const double slack = tolerance::alike * size;
  const Vec3 u = any_perpendicular(n), v = n.cross(u);
  struct Box {
    double lo[2], hi[2];
  };
  const auto box_of = [&](const std::array<Vec3, 3>& p) {
    const auto [lo_u, hi_u] = std::minmax({u.dot(p[0]), u.dot(p[1]), u.dot(p[2])});
    const auto [lo_v, hi_v] = std::minmax({v.dot(p[0]), v.dot(p[1]), v.dot(p[2])});
    return Box{{lo_u, lo_v}, {hi_u, hi_v}};
  };
  List<Box> boxes(memory);
  for (const Facet& f : overlap.of_b->facets) boxes.push_back(box_of(f.p));
  for (const Facet& f : overlap.of_a->facets) {
    meter.spend(8);
    const Box box = box_of(f.p);
    for (std::size_t j = 0; j < boxes.size(); ++j) {
      const Facet& g = overlap.of_b->facets[j];
      bool apart = false;
      for (std::size_t k = 0; k < 2; ++k)
        apart = apart || box.lo[k] > boxes[j].hi[k] + slack || boxes[j].lo[k] > box.hi[k] + slack;
      if (apart) continue;
      meter.spend(8);
      const std::size_t first = scratch.size(), begin = overlap.points.size();
      append_manifold(TriangleView(f.p), TriangleView(g.p), {Mat3::Identity(), Vec3::Zero()},
                      {.signed_distance = -any_depth, .point_a = f.p[0], .point_b = g.p[0], .normal = n}, 0, {},
                      scratch, true);
      for (Contact& found : std::span(scratch).subspan(first)) {
        if (found.feature == made_up) continue;
        found.feature = f.triangle;
        overlap.points.push_back(found);
      }
      scratch.resize(first);
      Vec3 area = Vec3::Zero();
      for (std::size_t c = begin + 2; c < overlap.points.size(); ++c)
        area += (overlap.points[c - 1].point - overlap.points[begin].point)
                    .cross(overlap.points[c].point - overlap.points[begin].point);
      overlap.area += area.norm() / 2;
    }
  }
  overlap.depth = 0;
  for (const Contact& c : overlap.points) overlap.depth = std::max(overlap.depth, c.depth);
}

// The width of an outline across its length.
double width_of(const FaceOverlap& overlap) {
  if (overlap.points.empty()) return 0;
  const auto farthest = [&](auto&& score) {
    return *std::max_element(overlap.points.begin(), overlap.points.end(),
                             [&](const Contact& x, const Contact& y) { return score(x) < score(y); });
  };
  const Vec3 from = overlap.points.front().point;
  const Vec3 along = farthest([&](const Contact& c) { return (c.point - from).squaredNorm(); }).point - from;
  const Vec3 side = overlap.n.cross(along).stableNormalized();
  const auto beside = [&](const Contact& c) { return std::abs(side.dot(c.point - from)); };
  return beside(farthest(beside));
}

// True if two faces of a mesh lie behind each other.
bool is_ridge(const CoplanarFacets& f, const CoplanarFacets& g, bool of_a, double slack) {
  const double side = of_a ? 1 : -1;
  const auto is_behind = [&](const CoplanarFacets& face, const CoplanarFacets& plane) {
    return std::all_of(face.facets.begin(), face.facets.end(), [&](const Facet& facet) {
      return std::all_of(facet.p.begin(), facet.p.end(),
                         [&](const Vec3& v) { return side * (plane.n.dot(v) - plane.level) <= slack; });
    });
  };
  return is_behind(f, g) && is_behind(g, f);
}

struct FacePair {
  CoplanarFacets of_a, of_b;
};

// Facets in the order of a coordinate of their normals: unit vectors u and v with u . v > carries_patch differ by no
// more than sqrt(2 (1 - carries_patch)) in it.
class FacetsByNormal {
 public:
  FacetsByNormal(std::span<const Facet> facets, WorkMeter& meter, Memory memory) : facets_(facets), order_(memory) {
    order_.resize(facets.size());
    std::iota(order_.begin(), order_.end(), 0u);
    sort_metered(meter, order_.begin(), order_.end(),
                 [&](std::uint32_t i, std::uint32_t j) { return facets[i].n.x() < facets[j].n.x(); });
  }

  // Sets the numbers of those whose normal has a cosine above carries_patch with n (unit), in ascending order.
  void find(const Vec3& n, List<std::uint32_t>& facing) const {
    const double reach = tolerance::bound_in_floats * std::sqrt(2 * (1 - carries_patch));
    facing.clear();
    auto at = std::partition_point(order_.begin(), order_.end(),
                                   [&](std::uint32_t i) { return facets_[i].n.x() < n.x() - reach; });
    for (; at != order_.end() && facets_[*at].n.x() <= n.x() + reach; ++at)
      if (n.dot(facets_[*at].n) > carries_patch) facing.push_back(*at);
    std::sort(facing.begin(), facing.end());
  }

 private:
  std::span<const Facet> facets_;
  List<std::uint32_t> order_;
};

// Pairs of facing faces of a patch that have sunk into each other by at most `most`. Most patches have none.
List<FacePair> facing_pairs(const PosedMeshes& m, const Facets& facets, const Vec3& area, double most, double size,
                            Memory memory) {
  const double slack = tolerance::in_plane * size;
  constexpr std::size_t most_pairs = 16;
  const double width = area.isZero(0) ? size : std::sqrt(area.norm());
  List<FacePair> found(memory);
  WorkMeter meter(m.limit);
  const FacetsByNormal of_b(facets[0], meter, memory);
  List<std::uint32_t> facing(memory);
  for (const Facet& f : facets[1]) {
    of_b.find(f.n, facing);
    meter.spend(1 + static_cast<int>(facing.size() / 8));
    for (const std::uint32_t i : facing) {
      const Facet& g = facets[0][i];
      // The overlap must have uniform thickness except for a small angle, and be neither deeper than wide nor nearly
      // perpendicular to the patch: otherwise it would be less than half of the patch.
      const double depth = f.n.dot(f.p[0] - g.p[0]), tilt = (f.n - g.n).norm();
      if (!(depth > -slack && depth < most && tilt * width <= std::max(slack, depth / 2))) continue;
      if (!area.isZero(0) && (depth > width || !(area.dot(f.n) > 0.1 * width * width))) continue;
      const bool is_known = std::any_of(found.begin(), found.end(), [&](const FacePair& pair) {
        return pair.of_a.contains(f, slack) && pair.of_b.contains(g, slack);
      });
      if (is_known) continue;
      if (found.size() == most_pairs) return found;
      found.push_back({coplanar_facets(m, facets[1], f, true, slack, memory),
                       coplanar_facets(m, facets[0], g, false, slack, memory)});
    }
  }
  return found;
}

}  // namespace

bool add_face_overlaps(const PosedMeshes& m, const Facets& facets, const Vec3& area, Memory memory,
                       PatchCollector& collector, std::vector<Contact>& scratch) {
  const double size = (m.a.half + m.b.half).norm(), slack = tolerance::in_plane * size;
  const double most = 0.25 * std::min(m.a.half.norm(), m.b.half.norm());
  const List<FacePair> pairs = facing_pairs(m, facets, area, most, size, memory);
  if (pairs.empty()) return false;
  List<FaceOverlap> overlaps(memory);
  for (const FacePair& pair : pairs) {
    const Vec3& n = pair.of_a.area >= pair.of_b.area ? pair.of_a.n : pair.of_b.n;
    FaceOverlap overlap{&pair.of_a, &pair.of_b, n, 0, 0, 0, List<Contact>(memory)};
    outline(overlap, size, memory, m.limit, scratch);
    overlap.width = width_of(overlap);
    // Wider than an edge, beyond rounding.
    if (overlap.depth <= most && overlap.width > 4 * tolerance::alike * size) overlaps.push_back(std::move(overlap));
  }
  const auto is_longer = [&](const FaceOverlap& overlap) {
    return std::any_of(overlaps.begin(), overlaps.end(), [&](const FaceOverlap& other) {
      if (!(other.depth < overlap.depth - slack && other.n.dot(overlap.n) < one_patch)) return false;
      return overlap.width < overlap.depth ||
             (is_ridge(*overlap.of_a, *other.of_a, true, slack) && is_ridge(*overlap.of_b, *other.of_b, false, slack));
    });
  };
  List<const FaceOverlap*> taken(memory);
  Vec3 covered = Vec3::Zero();
  for (const FaceOverlap& overlap : overlaps)
    if (!is_longer(overlap)) {
      taken.push_back(&overlap);
      covered += overlap.area * overlap.n;
    }
  if (taken.empty() || (!area.isZero(0) && !((area - covered).norm() < 0.5 * area.norm()))) return false;
  for (const FaceOverlap* overlap : taken)
    for (const Contact& c : overlap->points) collector.add(c.feature, {&c, 1});
  return true;
}

}  // namespace tandem
