// Finds the intersecting or close pairs among the meshes of an assembly.
#include "clash.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>
#include <optional>

#include "formats/input_error.h"
#include "tandem/formats/mesh_file.h"
#include "tandem/narrowphase/clearance.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem::clash {
namespace {

Part made(const std::filesystem::path& file) {
  Mesh mesh = read_mesh_file(file);
  std::string open;
  mesh.solid = true;
  std::optional<Shape> shape;
  try {
    shape.emplace(mesh);
  } catch (const std::invalid_argument& not_closed) {
    open = not_closed.what();
    mesh.solid = false;
    try {
      shape.emplace(std::move(mesh));
    } catch (const std::invalid_argument& no_mesh) {
      throw InputError(file.string(), no_mesh.what());
    }
  }
  const Bounds bounds = shape->bounds(Pose{});
  return {file.string(), *std::move(shape), bounds, std::move(open)};
}

bool near(const Bounds& a, const Bounds& b, double clearance) {
  return ((a.lo.array() - clearance <= b.hi.array()) && (b.lo.array() - clearance <= a.hi.array())).all();
}

void add_zones(Clash& clash, const Part& a, const Part& b) {
  const auto zones = clearance_zones(a.shape, {}, b.shape, {}, NearOptions{});
  clash.zone_count = zones.size();
  for (const ClearanceZone& zone : zones) {
    clash.triangle_pairs += zone.intersecting_pairs;
    if (clash.zones.size() < most_zones)
      clash.zones.push_back({zone.intersecting_pairs, (zone.point_a + zone.point_b) / 2, zone.bounds});
  }
}

Clash intersecting(const NarrowPhase& narrow_phase, const Part& a, const Part& b) {
  std::vector<Contact> contacts;
  const PairAnswer found = narrow_phase.solve(a.shape, {}, b.shape, {}, Request::contacts, &contacts);
  Clash out;
  out.intersects = true;
  add_zones(out, a, b);
  out.distance = found.signed_distance;
  out.status = found.status;
  out.error_bound = found.error_bound;
  out.place = (found.point_a + found.point_b) / 2;
  out.normal = found.normal;
  const auto deepest = std::max_element(contacts.begin(), contacts.end(),
                                        [](const Contact& x, const Contact& y) { return x.depth < y.depth; });
  if (deepest != contacts.end()) {
    out.place = deepest->point;
    out.normal = deepest->normal;
  }
  return out;
}

}  // namespace

std::vector<Part> read_parts(const std::vector<std::filesystem::path>& files, const Done& done) {
  std::vector<std::optional<Part>> parts(files.size());
  std::mutex telling;
  std::size_t count = 0;
  tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t i) {
    parts[i] = made(files[i]);
    const std::lock_guard lock(telling);
    done(++count);
  });
  std::vector<Part> out;
  out.reserve(parts.size());
  for (auto& part : parts) out.push_back(*std::move(part));
  return out;
}

std::vector<Pair> candidates(const std::vector<Part>& parts, double clearance) {
  std::vector<std::size_t> by_x(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) by_x[i] = i;
  std::sort(by_x.begin(), by_x.end(),
            [&](std::size_t i, std::size_t j) { return parts[i].bounds.lo.x() < parts[j].bounds.lo.x(); });
  std::vector<Pair> out;
  for (std::size_t i = 0; i < by_x.size(); ++i) {
    const Bounds& box = parts[by_x[i]].bounds;
    for (std::size_t j = i + 1; j < by_x.size() && parts[by_x[j]].bounds.lo.x() - clearance <= box.hi.x(); ++j)
      if (near(box, parts[by_x[j]].bounds, clearance))
        out.push_back({std::min(by_x[i], by_x[j]), std::max(by_x[i], by_x[j])});
  }
  std::sort(out.begin(), out.end(), [](const Pair& p, const Pair& q) { return p.a != q.a ? p.a < q.a : p.b < q.b; });
  return out;
}

Answer answer(const std::vector<Part>& parts, const Pair& pair, double clearance) {
  const Part &a = parts[pair.a], &b = parts[pair.b];
  NarrowPhaseOptions options;
  options.cutoff = clearance;
  const NarrowPhase narrow_phase(options);
  Answer out;
  if (narrow_phase.solve(a.shape, {}, b.shape, {}, Request::collide).collide) {
    out.near = true;
    out.clash = intersecting(narrow_phase, a, b);
  } else if (clearance > 0) {
    const PairAnswer found = narrow_phase.solve(a.shape, {}, b.shape, {}, Request::distance);
    out.near = !found.farther && found.signed_distance <= clearance;
    out.clash.distance = found.signed_distance;
    out.clash.place = (found.point_a + found.point_b) / 2;
    out.clash.normal = found.normal;
    out.clash.status = found.status;
    out.clash.error_bound = found.error_bound;
  }
  out.clash.a = pair.a;
  out.clash.b = pair.b;
  return out;
}

void answer_all(const std::vector<Part>& parts, std::vector<Pair> pairs, double clearance,
                const std::function<void(const Pair&, const Answer&)>& report) {
  const auto work = [&](const Pair& p) {
    return parts[p.a].shape.triangles().size() + parts[p.b].shape.triangles().size();
  };
  std::stable_sort(pairs.begin(), pairs.end(), [&](const Pair& p, const Pair& q) { return work(p) > work(q); });
  std::mutex telling;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, pairs.size(), 1),
      [&](const tbb::blocked_range<std::size_t>& some) {
        for (std::size_t i = some.begin(); i < some.end(); ++i) {
          const Answer found = answer(parts, pairs[i], clearance);
          const std::lock_guard lock(telling);
          report(pairs[i], found);
        }
      },
      tbb::simple_partitioner());
}

}  // namespace tandem::clash
