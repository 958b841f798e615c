// Finds the curves along which two meshes cross, and the patches that they bound.
#include "meshes/contacts/crossing_patches.h"

#include <bit>

#include "shapes/disjoint_sets.h"
#include "shapes/index_map.h"
#include "tolerances.h"
#include "triangles/triangle_rows.h"

namespace tandem {
namespace {

constexpr std::size_t shared_from = 1024;  // pairs of triangles from which on several threads share the work
constexpr std::size_t pairs_a_task = 256;

// Calls take(k, crossing) for the pairs of triangles that cross, in order.
template <class Take>
void each_crossing(const PosedMeshes& m, std::span<const TrianglePair> pairs, Take&& take) {
  TriangleRows rows{};  // unset columns are computed, too: they must contain numbers
  CrossingRows found;
  WorkMeter meter(m.limit);
  for (std::size_t first = 0; first < pairs.size(); first += TriangleRows::most) {
    const auto some = pairs.subspan(first, std::min(TriangleRows::most, pairs.size() - first));
    meter.spend(static_cast<int>(some.size()));
    for (std::size_t k = 0; k < some.size(); ++k) rows.set(k, m.a.corners(some[k][0]), m.b.corners(some[k][1]));
    cross_triangles(rows, some.size(), m.frame, found);
    for (std::uint32_t left = found.crosses; left != 0; left &= left - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(left));
      const auto end = [&](const CrossingRows::End& e) {
        const auto edge = static_cast<std::uint32_t>(static_cast<std::int32_t>(e.edge[k]));
        const bool of_a = edge < 3;
        const std::uint32_t triangle = some[k][of_a ? 0 : 1], corner = edge % 3;
        const auto& index = m.mesh(of_a).triangles[triangle];
        return Piercing{{e.point[0][k], e.point[1][k], e.point[2][k]},
                        of_a,
                        triangle,
                        corner,
                        index[corner],
                        index[(corner + 1) % 3],
                        e.part[k],
                        ((e.from_inside >> k & 1u) != 0) != m.turned(!of_a)};
      };
      const bool back = m.turned_a != m.turned_b;
      take(first + k, Crossing{{end(found.end[back ? 1 : 0]), end(found.end[back ? 0 : 1])}, some[k]});
    }
  }
}

class PatchFinder {
 public:
  PatchFinder(const PosedMeshes& m, std::span<const TrianglePair> pairs, const PartRunner& parts, Memory memory)
      : m_(m), memory_(memory), sets_(pairs.size(), memory) {
    crossings_.reserve(pairs.size());
    if (parts && pairs.size() >= shared_from) {
      find_crossings(pairs, parts);
      flood_both(parts);
    } else {
      each_crossing(m, pairs, [&](std::size_t, const Crossing& c) { crossings_.push_back(c); });
      inside_.reserve(pairs.size());
      touched_.reserve(2 * pairs.size());
      for (const bool of_a : {true, false}) join_and_flood(of_a, sets_, inside_, touched_, memory_);
    }
    collect();
  }

  List<Crossing>& crossings() { return crossings_; }
  List<Patch>& patches() { return patches_; }

 private:
  struct Inner {
    double distance = std::numeric_limits<double>::infinity();  // of the nearest piercing
    bool inside = false;
    std::uint32_t crossing = 0;
  };

  struct Found {
    std::uint32_t index;
    bool of_a;
    std::uint32_t crossing;
  };

  void find_crossings(std::span<const TrianglePair> pairs, const PartRunner& parts) {
    std::vector<Crossing> all(pairs.size());
    std::vector<std::uint8_t> cross(pairs.size());
    parts((pairs.size() + pairs_a_task - 1) / pairs_a_task, [&](std::size_t task) {
      const std::size_t begin = task * pairs_a_task, end = std::min(pairs.size(), begin + pairs_a_task);
      each_crossing(m_, pairs.subspan(begin, end - begin), [&](std::size_t k, const Crossing& c) {
        all[begin + k] = c;
        cross[begin + k] = 1;
      });
    });
    for (std::size_t k = 0; k < pairs.size(); ++k)
      if (cross[k] != 0) crossings_.push_back(all[k]);
  }

  // Joins crossings over A and over B, separately and then together. The root of a set is its first crossing, in
  // whatever order it was joined.
  void flood_both(const PartRunner& parts) {
    std::pmr::monotonic_buffer_resource memory;  // one for each thread: it is not thread-safe
    DisjointSets sets(crossings_.size(), &memory);
    List<Found> inside(&memory), touched(&memory);
    parts(2, [&](std::size_t task) {
      if (task == 0)
        join_and_flood(true, sets_, inside_, touched_, memory_);
      else
        join_and_flood(false, sets, inside, touched, &memory);
    });
    WorkMeter meter(m_.limit);
    for (std::uint32_t c = 0; c < crossings_.size(); ++c) {
      meter.spend();
      sets_.join(c, sets.find(c));
    }
    inside_.insert(inside_.end(), inside.begin(), inside.end());
    touched_.insert(touched_.end(), touched.begin(), touched.end());
  }

  struct Crossed {
    std::uint32_t crossing;  // one of its crossings
    std::uint32_t edges;     // bits of the edges crossed
  };
  /// The crossed triangles of a mesh, and the ends of their crossed edges, each with its nearest piercing.
  struct CrossedMesh {
    // Most triangles and vertices have two crossings each.
    CrossedMesh(Memory memory, std::size_t crossings)
        : triangles(memory, crossings / 2), vertices(memory, crossings / 2) {}
    IndexMap<Crossed> triangles;
    IndexMap<Inner> vertices;
  };

  // Joins curves that share a triangle, and curves between which the surface lies inside: they bound one patch.
  void join_and_flood(bool of_a, DisjointSets& sets, List<Found>& inside, List<Found>& touched, Memory memory) const {
    WorkMeter meter(m_.limit);
    CrossedMesh crossed(memory, crossings_.size());
    join(of_a, sets, crossed, meter);
    for (const auto& [vertex, n] : crossed.vertices) {
      meter.spend();
      if (n.inside) inside.push_back({vertex, of_a, n.crossing});
    }
    for (const auto& [t, c] : flood(of_a, sets, crossed, inside, memory, meter)) touched.push_back({t, of_a, c});
  }

  void join(bool of_a, DisjointSets& sets, CrossedMesh& crossed, WorkMeter& meter) const {
    const MeshModel& mesh = m_.mesh(of_a);
    for (std::uint32_t c = 0; c < crossings_.size(); ++c) {
      meter.spend(6);
      const std::uint32_t t = crossings_[c].triangles[of_a ? 0 : 1];
      const auto [entry, fresh] = crossed.triangles.emplace(t, {c, 0});
      if (!fresh) sets.join(entry.crossing, c);
      for (const Piercing& p : crossings_[c].end) {
        if (p.edge_of_a != of_a) continue;
        entry.edges |= 1u << p.corner;
        // The side of an edge's end is given by the piercing nearest to it.
        const double length = (mesh.vertices[p.to] - mesh.vertices[p.from]).norm();
        for (const bool start : {true, false}) {
          Inner& n = crossed.vertices.emplace(start ? p.from : p.to, Inner()).first;
          const double away = (start ? p.fraction : 1 - p.fraction) * length;
          if (away < n.distance) n = {away, p.from_inside == start, c};
        }
      }
    }
  }

  // A flood fill from crossed triangles over edges whose ends are inside to triangles that are entirely inside. Returns
  // all triangles of patches, each with one of its crossings.
  List<std::pair<std::uint32_t, std::uint32_t>> flood(bool of_a, DisjointSets& sets, CrossedMesh& crossed,
                                                      List<Found>& inside, Memory memory, WorkMeter& meter) const {
    const MeshModel& mesh = m_.mesh(of_a);
    const auto& neighbours = mesh.neighbours();
    IndexMap<std::uint32_t> reached(memory);
    List<std::pair<std::uint32_t, std::uint32_t>> stack(memory), all(memory);
    const auto visit = [&](std::uint32_t t, std::uint32_t c) {
      if (t == no_index) return;
      if (const Crossed* hit = crossed.triangles.find(t)) return sets.join(hit->crossing, c);
      const auto [origin, fresh] = reached.emplace(t, c);
      if (fresh)
        stack.emplace_back(t, c);
      else
        sets.join(origin, c);
    };
    for (const auto& [t, hit] : crossed.triangles) {
      meter.spend();
      for (std::uint32_t k = 0; k < 3; ++k) {
        if (hit.edges >> k & 1u) continue;
        const Inner* from = crossed.vertices.find(mesh.triangles[t][k]);
        const Inner* to = crossed.vertices.find(mesh.triangles[t][(k + 1) % 3]);
        if (from && to && from->inside && to->inside) visit(neighbours[t][k], hit.crossing);
      }
      while (!stack.empty()) {
        meter.spend(6);
        const auto [next, origin] = stack.back();
        stack.pop_back();
        for (std::uint32_t k = 0; k < 3; ++k) {
          if (crossed.vertices.emplace(mesh.triangles[next][k], {0, true, origin}).second)
            inside.push_back({mesh.triangles[next][k], of_a, origin});
          visit(neighbours[next][k], origin);
        }
      }
    }
    for (const auto& [t, hit] : crossed.triangles) all.emplace_back(t, hit.crossing);
    for (const auto& [t, c] : reached) all.emplace_back(t, c);
    return all;
  }

  void collect() {
    WorkMeter meter(m_.limit);
    List<std::uint32_t> place(crossings_.size(), no_index, memory_);
    const auto patch_of = [&](std::uint32_t c) -> Patch& {
      meter.spend();
      const std::uint32_t root = sets_.find(c);
      if (place[root] == no_index)
        place[root] = static_cast<std::uint32_t>(patches_.size()), patches_.emplace_back(memory_);
      return patches_[place[root]];
    };
    for (std::uint32_t c = 0; c < crossings_.size(); ++c) patch_of(c).crossings.push_back(c);
    for (const auto& v : inside_)
      patch_of(v.crossing)
          .vertices.push_back({m_.vertex(v.of_a, v.index), v.of_a, feature_of(v.of_a ? 0 : 1, v.index)});
    for (const auto& t : touched_) {
      patch_of(t.crossing).triangles[t.of_a ? 1 : 0].push_back(t.index);
    }
  }

  const PosedMeshes& m_;
  const Memory memory_;
  DisjointSets sets_;
  List<Crossing> crossings_{memory_};
  List<Found> inside_{memory_}, touched_{memory_};
  List<Patch> patches_{memory_};
};

}  // namespace

CrossingPatches::CrossingPatches(const PosedMeshes& m, std::span<const TrianglePair> pairs, const PartRunner& parts,
                                 Memory memory)
    : crossings_(memory), patches_(memory) {
  PatchFinder finder(m, pairs, parts, memory);
  crossings_ = std::move(finder.crossings());
  patches_ = std::move(finder.patches());
}

}  // namespace tandem
