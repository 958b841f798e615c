#include "meshes/contacts/mesh_sheets.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "manifold/manifold.h"
#include "shapes/support.h"
#include "tolerances.h"

namespace tandem {
namespace {

using Memory = std::pmr::memory_resource*;

// The triangles of a mesh about a patch that lie in one plane.
struct PatchFace {
  Vec3 n;  // unit, from A to B
  double level, area;
  List<Facet> facets;

  bool holds(const Facet& f, double slack) const {
    return n.dot(f.n) > 0.5 &&
           std::all_of(f.p.begin(), f.p.end(), [&](const Vec3& v) { return std::abs(n.dot(v) - level) <= slack; });
  }
};

// That of one of the facets: those of the patch, and what goes on from there as far as the other mesh's box. Where
// sides lie on each other rounding says what the curve has reached.
PatchFace face_about(const PosedMeshes& m, std::span<const Facet> facets, const Facet& seed, bool of_a, double slack,
                     Memory memory) {
  constexpr std::size_t most = 512;
  const MeshModel& mesh = m.mesh(of_a);
  const Vec3 centre = of_a ? m.frame.in_a(m.b.centre) : m.a.centre,
             half = of_a ? Vec3(m.frame.map().cwiseAbs() * m.b.half) : m.a.half;
  PatchFace face{seed.n, seed.n.dot(seed.p[0]), 0, List<Facet>(memory)};
  for (const Facet& f : facets)
    if (face.holds(f, slack)) face.facets.push_back(f);
  for (std::size_t i = 0; i < face.facets.size() && face.facets.size() < most; ++i)
    for (const std::uint32_t next : mesh.neighbours[face.facets[i].triangle]) {
      const bool is_known =
          std::any_of(face.facets.begin(), face.facets.end(), [&](const Facet& f) { return f.triangle == next; });
      if (next == no_index || is_known) continue;
      const Facet f = facet_of(m, of_a, next);
      const Vec3 lo = f.p[0].cwiseMin(f.p[1]).cwiseMin(f.p[2]), hi = f.p[0].cwiseMax(f.p[1]).cwiseMax(f.p[2]);
      const bool is_near =
          ((lo - centre - half).array() <= slack).all() && ((centre - half - hi).array() <= slack).all();
      if (is_near && face.holds(f, slack)) face.facets.push_back(f);
    }
  std::sort(face.facets.begin(), face.facets.end(),
            [](const Facet& x, const Facet& y) { return x.triangle < y.triangle; });
  for (const Facet& f : face.facets) face.area += (f.p[1] - f.p[0]).cross(f.p[2] - f.p[0]).norm() / 2;
  return face;
}

// What lies between a face of A and one of B that face each other, where each has sunk into the other.
struct Sheet {
  const PatchFace *of_a, *of_b;
  Vec3 n;  // that of the larger
  double depth = 0, width = 0, area = 0;
  List<Contact> points;
};

// All corners of the sheet's outline along n.
// `room`: what it holds stays as it is.
void outline(Sheet& sheet, double size, Memory memory, std::vector<Contact>& room) {
  const Vec3& n = sheet.n;
  constexpr std::uint32_t made_up = 0xffffffffu;  // deepest of all, for want of others
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
  for (const Facet& f : sheet.of_b->facets) boxes.push_back(box_of(f.p));
  for (const Facet& f : sheet.of_a->facets) {
    const Box box = box_of(f.p);
    for (std::size_t j = 0; j < boxes.size(); ++j) {
      const Facet& g = sheet.of_b->facets[j];
      bool apart = false;
      for (std::size_t k = 0; k < 2; ++k)
        apart = apart || box.lo[k] > boxes[j].hi[k] + slack || boxes[j].lo[k] > box.hi[k] + slack;
      if (apart) continue;
      const std::size_t first = room.size(), begin = sheet.points.size();
      append_manifold(TriangleView(f.p), TriangleView(g.p), {Mat3::Identity(), Vec3::Zero()},
                      {.signed_distance = -any_depth, .point_a = f.p[0], .point_b = g.p[0], .normal = n}, 0, {}, room,
                      true);
      for (Contact& found : std::span(room).subspan(first)) {
        if (found.feature == made_up) continue;
        found.feature = f.triangle;
        sheet.points.push_back(found);
      }
      room.resize(first);
      Vec3 area = Vec3::Zero();
      for (std::size_t c = begin + 2; c < sheet.points.size(); ++c)
        area += (sheet.points[c - 1].point - sheet.points[begin].point)
                    .cross(sheet.points[c].point - sheet.points[begin].point);
      sheet.area += area.norm() / 2;
    }
  }
  sheet.depth = 0;
  for (const Contact& c : sheet.points) sheet.depth = std::max(sheet.depth, c.depth);
}

// How wide an outline is across its length.
double width_of(const Sheet& sheet) {
  if (sheet.points.empty()) return 0;
  const auto farthest = [&](auto&& score) {
    return *std::max_element(sheet.points.begin(), sheet.points.end(),
                             [&](const Contact& x, const Contact& y) { return score(x) < score(y); });
  };
  const Vec3 from = sheet.points.front().point;
  const Vec3 along = farthest([&](const Contact& c) { return (c.point - from).squaredNorm(); }).point - from;
  const Vec3 side = sheet.n.cross(along).stableNormalized();
  const auto beside = [&](const Contact& c) { return std::abs(side.dot(c.point - from)); };
  return beside(farthest(beside));
}

// Does each of two faces of a mesh lie behind the other?
bool is_ridge(const PatchFace& f, const PatchFace& g, bool of_a, double slack) {
  const double side = of_a ? 1 : -1;
  const auto is_behind = [&](const PatchFace& face, const PatchFace& plane) {
    return std::all_of(face.facets.begin(), face.facets.end(), [&](const Facet& facet) {
      return std::all_of(facet.p.begin(), facet.p.end(),
                         [&](const Vec3& v) { return side * (plane.n.dot(v) - plane.level) <= slack; });
    });
  };
  return is_behind(f, g) && is_behind(g, f);
}

struct FacePair {
  PatchFace of_a, of_b;
};

// The faces of a patch that face each other and have sunk into each other by `most` at most. Most patches have none.
List<FacePair> facing_pairs(const PosedMeshes& m, const Facets& facets, const Vec3& area, double most, double size,
                            Memory memory) {
  const double slack = tolerance::in_plane * size;
  constexpr std::size_t most_pairs = 16;
  const double width = area.isZero(0) ? size : std::sqrt(area.norm());
  List<FacePair> found(memory);
  for (const Facet& f : facets[1])
    for (const Facet& g : facets[0]) {
      if (!(f.n.dot(g.n) > carries_patch)) continue;
      // As thick all over, but for what an angle makes of it; and not deeper than wide, or nearly on its side: that
      // would be the lesser part of the patch.
      const double depth = f.n.dot(f.p[0] - g.p[0]), tilt = (f.n - g.n).norm();
      if (!(depth > -slack && depth < most && tilt * width <= std::max(slack, depth / 2))) continue;
      if (!area.isZero(0) && (depth > width || !(area.dot(f.n) > 0.1 * width * width))) continue;
      const bool is_known = std::any_of(found.begin(), found.end(), [&](const FacePair& pair) {
        return pair.of_a.holds(f, slack) && pair.of_b.holds(g, slack);
      });
      if (is_known) continue;
      if (found.size() == most_pairs) return found;
      found.push_back(
          {face_about(m, facets[1], f, true, slack, memory), face_about(m, facets[0], g, false, slack, memory)});
    }
  return found;
}

}  // namespace

bool add_sheets(const PosedMeshes& m, const Facets& facets, const Vec3& area, Memory memory, PatchCollector& collector,
                std::vector<Contact>& room) {
  const double size = (m.a.half + m.b.half).norm(), slack = tolerance::in_plane * size;
  const double most = 0.25 * std::min(m.a.half.norm(), m.b.half.norm());
  const List<FacePair> pairs = facing_pairs(m, facets, area, most, size, memory);
  if (pairs.empty()) return false;
  List<Sheet> sheets(memory);
  for (const FacePair& pair : pairs) {
    const Vec3& n = pair.of_a.area >= pair.of_b.area ? pair.of_a.n : pair.of_b.n;
    Sheet sheet{&pair.of_a, &pair.of_b, n, 0, 0, 0, List<Contact>(memory)};
    outline(sheet, size, memory, room);
    sheet.width = width_of(sheet);
    // No edge, but for rounding.
    if (sheet.depth <= most && sheet.width > 4 * tolerance::alike * size) sheets.push_back(std::move(sheet));
  }
  const auto gives_way = [&](const Sheet& sheet) {
    return std::any_of(sheets.begin(), sheets.end(), [&](const Sheet& other) {
      if (!(other.depth < sheet.depth - slack && other.n.dot(sheet.n) < one_patch)) return false;
      return sheet.width < sheet.depth ||
             (is_ridge(*sheet.of_a, *other.of_a, true, slack) && is_ridge(*sheet.of_b, *other.of_b, false, slack));
    });
  };
  List<const Sheet*> taken(memory);
  Vec3 covered = Vec3::Zero();
  for (const Sheet& sheet : sheets)
    if (!gives_way(sheet)) {
      taken.push_back(&sheet);
      covered += sheet.area * sheet.n;
    }
  if (taken.empty() || (!area.isZero(0) && !((area - covered).norm() < 0.5 * area.norm()))) return false;
  for (const Sheet* sheet : taken)
    for (const Contact& c : sheet->points) collector.add(c.feature, {&c, 1});
  return true;
}

}  // namespace tandem
