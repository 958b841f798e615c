// Finds the neighbours of triangles, by sides sorted by their ends; orients triangles; closes seams.
#include "shapes/mesh_edges.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "shapes/run_parts.h"
#include "shapes/vertex_weld.h"

namespace tandem {
namespace {

/// A vertex as a short text for error messages.
std::string short_text(const Vec3& v) {
  std::ostringstream out;
  out << "(" << v.x() << ", " << v.y() << ", " << v.z() << ")";
  return out.str();
}

// A side of a triangle as a number that sorts by the other end, the direction, the triangle and the corner.
class TriangleSide {
 public:
  TriangleSide() = default;
  TriangleSide(std::uint32_t hi, bool up, std::uint32_t number)
      : key_(std::uint64_t{hi} << 32 | (up ? std::uint64_t{1} << 31 : 0) | number) {}
  std::uint32_t hi() const { return static_cast<std::uint32_t>(key_ >> 32); }
  bool up() const { return (key_ >> 31 & 1) != 0; }  // from the lower end to the higher
  std::uint32_t triangle() const { return number() / 3; }
  std::uint32_t corner() const { return number() % 3; }
  auto operator<=>(const TriangleSide&) const = default;

 private:
  std::uint32_t number() const { return static_cast<std::uint32_t>(key_ & 0x7fffffff); }
  std::uint64_t key_;
};

// For each vertex a list of the sides whose lower end it represents. Sides without length are left out.
class SideLists {
 public:
  SideLists(const MeshModel& mesh, const std::vector<std::uint32_t>& first, const PartRunner& parts, BuildMeter& meter)
      : mesh_(mesh), first_(first), last_(mesh.vertices.size(), no_index), before_(3 * mesh.triangles.size()) {
    const bool shared = static_cast<bool>(parts);
    run_chunks(parts, mesh.triangles.size(), elements_per_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
      meter.spend(0);
      for (std::size_t side = 3 * begin; side < 3 * end; ++side) {
        const auto [p, q] = ends(side);
        if (p != q) before_[side] = put(last_[std::min(p, q)], static_cast<std::uint32_t>(side), shared);
      }
    });
  }

  std::size_t vertices() const { return last_.size(); }

  /// Calls visit(lo, sides) for each edge between two vertices whose lower one is among these, by their order.
  template <class Visit>
  void each_edge(std::size_t begin, std::size_t end, const Visit& visit) const {
    std::vector<TriangleSide> sides;
    for (std::size_t v = begin; v < end; ++v) {
      sides.clear();
      for (std::uint32_t s = last_[v]; s != no_index; s = before_[s]) {
        const auto [p, q] = ends(s);
        sides.emplace_back(std::max(p, q), p < q, s);
      }
      sort(sides);
      for (std::size_t from = 0, to; from < sides.size(); from = to) {
        for (to = from; to < sides.size() && sides[to].hi() == sides[from].hi();) ++to;
        visit(static_cast<std::uint32_t>(v), std::span<const TriangleSide>(sides).subspan(from, to - from));
      }
    }
  }
  template <class Visit>
  void each_edge(const Visit& visit) const {
    each_edge(0, vertices(), visit);
  }

 private:
  static std::uint32_t put(std::uint32_t& last, std::uint32_t side, bool shared) {
    return shared ? std::atomic_ref(last).exchange(side, std::memory_order_relaxed) : std::exchange(last, side);
  }
  std::pair<std::uint32_t, std::uint32_t> ends(std::size_t side) const {
    const auto& t = mesh_.triangles[side / 3];
    const std::size_t k = side % 3;
    return {first_[t[k]], first_[t[k == 2 ? 0 : k + 1]]};
  }
  // Usually about three.
  static void sort(std::vector<TriangleSide>& sides) {
    constexpr std::size_t few = 16;
    if (sides.size() > few) return std::sort(sides.begin(), sides.end());
    for (std::size_t i = 1; i < sides.size(); ++i) {
      const TriangleSide side = sides[i];
      std::size_t k = i;
      for (; k > 0 && side < sides[k - 1]; --k) sides[k] = sides[k - 1];
      sides[k] = side;
    }
  }

  const MeshModel& mesh_;
  const std::vector<std::uint32_t>& first_;
  std::vector<std::uint32_t> last_;          // of each vertex
  UninitialisedList<std::uint32_t> before_;  // of each side, in its vertex's list
};

// The number of sides from the higher end to the lower, which come first.
std::size_t count_down(std::span<const TriangleSide> sides) {
  std::size_t down = 0;
  while (down < sides.size() && !sides[down].up()) ++down;
  return down;
}

// Properties of a surface by its edges.
struct Survey {
  std::vector<std::uint32_t> border{};  // ends of sides without a neighbour
  bool against = false;                 // two triangles at an edge are oriented oppositely
  std::optional<std::string> open{};    // the first edge at which it is not closed
};

std::string why_open(const MeshModel& mesh, std::uint32_t lo, std::span<const TriangleSide> sides, std::size_t down) {
  return "solid, but not closed: the edge " + short_text(mesh.vertices[lo]) + " to " +
         short_text(mesh.vertices[sides[0].hi()]) + " of triangle " + std::to_string(sides[0].triangle()) + " is in " +
         std::to_string(sides.size() - down) + " one way, in " + std::to_string(down) + " the other, allowed: as many";
}

Survey survey_edges(MeshModel& mesh, const SideLists& lists, const PartRunner& parts, BuildMeter& meter) {
  std::vector<Survey> some(chunks(lists.vertices(), elements_per_chunk));
  run_chunks(parts, lists.vertices(), elements_per_chunk, [&](std::size_t k, std::size_t begin, std::size_t end) {
    meter.spend(0);
    lists.each_edge(begin, end, [&](std::uint32_t lo, std::span<const TriangleSide> sides) {
      const std::size_t down = count_down(sides);
      if (2 * down != sides.size() && !some[k].open) some[k].open = why_open(mesh, lo, sides, down);
      if (sides.size() == 1) some[k].border.insert(some[k].border.end(), {lo, sides[0].hi()});
      if (sides.size() == 2 && down != 1) some[k].against = true;
    });
  });
  Survey all;
  for (const Survey& s : some) {
    all.border.insert(all.border.end(), s.border.begin(), s.border.end());
    all.against = all.against || s.against;
    if (!all.open) all.open = s.open;
  }
  mesh.closed = !all.open;
  return all;
}

// Orients the triangles of a surface like the first one of their component. Only edges of exactly two triangles count.
void turn_alike(MeshModel& mesh, const SideLists& lists, BuildMeter& meter) {
  struct Other {
    std::uint32_t triangle = no_index;
    bool against = false;  // the two are oriented oppositely
  };
  std::vector<std::array<Other, 3>> others(mesh.triangles.size());
  lists.each_edge([&](std::uint32_t, std::span<const TriangleSide> sides) {
    if (sides.size() != 2) return;
    const TriangleSide &p = sides[0], &q = sides[1];
    others[p.triangle()][p.corner()] = {q.triangle(), p.up() == q.up()};
    others[q.triangle()][q.corner()] = {p.triangle(), p.up() == q.up()};
  });
  std::vector<std::uint8_t> seen(mesh.triangles.size(), 0);
  std::vector<std::pair<std::uint32_t, bool>> stack;  // and whether the triangle is to be reversed
  for (std::uint32_t i = 0, steps = 0; i < mesh.triangles.size(); ++i) {
    if (seen[i]) continue;
    seen[i] = 1;
    stack.emplace_back(i, false);
    while (!stack.empty()) {
      const auto [t, turned] = stack.back();
      stack.pop_back();
      if (++steps % 8192 == 0) meter.spend(0);
      if (turned) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      for (const Other& o : others[t])
        if (o.triangle != no_index && !seen[o.triangle])
          seen[o.triangle] = 1, stack.emplace_back(o.triangle, turned != o.against);
    }
  }
}

// Merges corners of a surface's borders that differ only by rounding: such seams arise when the corners of each
// triangle are computed separately. Returns true if there are any.
bool weld_seams(const MeshModel& mesh, std::vector<std::uint32_t> ends, std::vector<std::uint32_t>& first) {
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());

  using Cell = std::array<std::int64_t, 3>;
  const double tolerance = seam_tolerance(mesh);
  if (ends.empty() || !(tolerance > 0)) return false;
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
  bool any = false;
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
          any = any || a != b;
        }
  }
  for (std::uint32_t v = 0; any && v < first.size(); ++v) first[v] = root(v);
  return any;
}

}  // namespace

std::vector<std::uint32_t> join_triangles(MeshModel& mesh, const PartRunner& parts, BuildMeter& meter) {
  std::vector<std::uint32_t> first = weld(mesh.vertices, parts, &meter);
  const auto survey = [&] { return survey_edges(mesh, SideLists(mesh, first, parts, meter), parts, meter); };
  Survey found = survey();
  if (mesh.solid) {
    if (found.open) throw std::invalid_argument("mesh: " + *found.open);
  } else {
    if (weld_seams(mesh, std::move(found.border), first)) found = survey();
    if (found.against) {
      turn_alike(mesh, SideLists(mesh, first, parts, meter), meter);
      survey();
    }
  }
  meter.spend(mesh.triangles.size());
  return first;
}

// Pairs sides of opposite direction.
MeshModel::Neighbours find_neighbours(const MeshModel& mesh, const WorkLimit* limit) {
  const BuildOptions options{.limit = limit};
  BuildMeter meter(options, joining_work(mesh.triangles.size()));
  std::vector<std::uint32_t> first(mesh.vertices.size());
  for (std::uint32_t v = 0; v < first.size(); ++v) first[v] = mesh.representative(v);
  const SideLists lists(mesh, first, {}, meter);
  MeshModel::Neighbours neighbours(mesh.triangles.size(), {no_index, no_index, no_index});
  run_chunks({}, lists.vertices(), elements_per_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    meter.spend(0);
    lists.each_edge(begin, end, [&](std::uint32_t, std::span<const TriangleSide> sides) {
      const std::size_t down = count_down(sides);
      for (std::size_t i = 0, j = down; i < down && j < sides.size(); ++i, ++j) {
        neighbours[sides[i].triangle()][sides[i].corner()] = sides[j].triangle();
        neighbours[sides[j].triangle()][sides[j].corner()] = sides[i].triangle();
      }
    });
  });
  return neighbours;
}

}  // namespace tandem
