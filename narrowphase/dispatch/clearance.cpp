// Pairs of triangles of two meshes that intersect or are near each other, one by one and by zones.
#include "tandem/narrowphase/clearance.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory_resource>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "meshes/mesh_pair.h"
#include "meshes/traversal/meeting_pairs.h"
#include "meshes/traversal/mesh_nearest.h"
#include "pairs/centre_test.h"
#include "pairs/convex_pair.h"
#include "shapes/disjoint_sets.h"
#include "shapes/index_map.h"
#include "shapes/metered_sort.h"
#include "shapes/shape_insides.h"
#include "shapes/unit_vector.h"
#include "shapes/work_meter.h"
#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {
namespace {

Corners world_corners(const Shape& shape, const Pose& pose, std::uint32_t t) {
  Corners c = mesh_of(shape).corners(t);
  for (Vec3& v : c) v = pose * v;
  return c;
}

Bounds box_of(const Corners& c) { return {c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2])}; }

// The intersection of the boxes of two intersecting triangles; rounding may make it empty if they only touch.
Bounds shared_box(const Corners& p, const Corners& q) {
  const Bounds x = box_of(p), y = box_of(q);
  const Vec3 lo = x.lo.cwiseMax(y.lo), hi = x.hi.cwiseMin(y.hi);
  return {lo.cwiseMin(hi), lo.cwiseMax(hi)};
}

void require_triangles(const Shape& shape) {
  if (!has_triangles(shape))
    throw std::invalid_argument("clearance: " + std::string(name(shape.kind())) +
                                " has no triangles, a triangle or a mesh is needed");
  if (shape.rounding() > 0)
    throw std::invalid_argument("clearance: rounding " + written(shape.rounding()) +
                                ", a shape without rounding is needed");
}

// False: the visitor ended it.
bool visit_meeting(const Posed& a, const Posed& b, const NearTrianglesVisitor& visitor, const NearOptions& options) {
  const bool in_order = goes_first(a, b);
  const auto take = [&](const TrianglePair& found) {
    NearTriangles near;
    near.triangles = in_order ? found : TrianglePair{found[1], found[0]};
    const Bounds shared = shared_box(world_corners(a.shape, a.pose, near.triangles[0]),
                                     world_corners(b.shape, b.pose, near.triangles[1]));
    near.point_a = near.point_b = (shared.lo + shared.hi) / 2;
    return visitor(near);
  };
  return each_meeting_pair(in_order ? a : b, in_order ? b : a, options.limit, take, options.progress);
}

// Reports the pairs of triangles that are at most a clearance apart.
bool visit_near(const Posed& a, const Posed& b, const NearTrianglesVisitor& visitor, const NearOptions& options) {
  const MeshModel &ma = mesh_of(a.shape), &mb = mesh_of(b.shape);
  TriangleTest test(a.pose, b.pose, reach(mb));
  const auto meet = [&](std::uint32_t i, std::uint32_t j) {
    const Corners p = ma.corners(i), q = mb.corners(j), in_a{test.in_a(q[0]), test.in_a(q[1]), test.in_a(q[2])};
    const Bounds x = box_of(p), y = box_of(in_a);
    const double slack = 2 * test.delta();
    if (((x.lo - y.hi).array() > slack).any() || ((y.lo - x.hi).array() > slack).any()) return false;
    return test(p, q, in_a);
  };
  const auto visit = [&](const TrianglePair& pair, const Nearest& nearest) {
    NearTriangles near{pair, nearest.distance, nearest.on_a + a.pose.translation, nearest.on_b + a.pose.translation};
    if (near.distance == 0) {
      const Bounds shared =
          shared_box(world_corners(a.shape, a.pose, pair[0]), world_corners(b.shape, b.pose, pair[1]));
      near.point_a = near.point_b = (shared.lo + shared.hi) / 2;
    }
    return visitor(near);
  };
  return NearestSearch(a, b, options.limit).each_within(options.clearance, meet, visit, options.progress);
}

// Throws WorkStopped.
bool visit_all(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
               const NearTrianglesVisitor& visitor, const NearOptions& options) {
  for (const Shape* shape : {&a, &b}) require_triangles(*shape);
  require_valid(pose_a, "clearance: pose of A");
  require_valid(pose_b, "clearance: pose of B");
  if (!(options.clearance >= 0) || !std::isfinite(options.clearance))
    throw std::invalid_argument("clearance: " + written(options.clearance) + " is not finite and >= 0");
  WorkMeter(options.limit).spend();
  if (test_hulls(a, pose_a, b, pose_b, options.limit).at_least > options.clearance) return true;
  const Posed posed_a{a, pose_a}, posed_b{b, pose_b};
  return options.clearance > 0 ? visit_near(posed_a, posed_b, visitor, options)
                               : visit_meeting(posed_a, posed_b, visitor, options);
}

// Numbers of corners, equal for equal coordinates, for the triangles concerned.
class CornerNumbers {
 public:
  CornerNumbers(const MeshModel& mesh, std::span<const NearTriangles> pairs, std::size_t side, WorkMeter& meter)
      : mesh_(mesh) {
    std::vector<std::uint32_t> corners;
    for (const NearTriangles& pair : pairs) {
      meter.spend();
      for (const std::uint32_t v : mesh.triangles[pair.triangles[side]])
        if (numbers_.emplace(v, 0).second) corners.push_back(v);
    }
    const auto before = [&](std::uint32_t x, std::uint32_t y) {
      const Vec3 &p = mesh.vertices[x], &q = mesh.vertices[y];
      return p[0] != q[0] ? p[0] < q[0] : p[1] != q[1] ? p[1] < q[1] : p[2] < q[2];
    };
    sort_metered(meter, corners.begin(), corners.end(), before);
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (i > 0 && before(corners[i - 1], corners[i])) ++number;
      *numbers_.find(corners[i]) = number;
    }
  }

  std::array<std::uint32_t, 3> of(std::uint32_t triangle) {
    const auto& t = mesh_.triangles[triangle];
    return {*numbers_.find(t[0]), *numbers_.find(t[1]), *numbers_.find(t[2])};
  }

 private:
  const MeshModel& mesh_;
  IndexMap<std::uint32_t> numbers_{std::pmr::get_default_resource()};  // of vertices
};

// Joins pairs whose triangles share a corner, or are the same, on both sides: pairs with a pair of corners in common.
void join_neighbours(const MeshModel& a, const MeshModel& b, std::span<const NearTriangles> pairs, WorkMeter& meter,
                     DisjointSets& sets) {
  CornerNumbers of_a(a, pairs, 0, meter), of_b(b, pairs, 1, meter);
  struct Key {
    std::uint64_t corners;
    std::uint32_t pair;
  };
  std::vector<Key> keys;
  keys.reserve(9 * pairs.size());
  for (std::uint32_t k = 0; k < pairs.size(); ++k) {
    meter.spend();
    for (const std::uint32_t u : of_a.of(pairs[k].triangles[0]))
      for (const std::uint32_t v : of_b.of(pairs[k].triangles[1])) keys.push_back({std::uint64_t{u} << 32 | v, k});
  }
  sort_metered(meter, keys.begin(), keys.end(), [](const Key& x, const Key& y) {
    return x.corners != y.corners ? x.corners < y.corners : x.pair < y.pair;
  });
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].corners == keys[i - 1].corners) sets.join(keys[i].pair, keys[i - 1].pair);
}

class ZoneBuilder {
 public:
  ZoneBuilder(const Posed& a, const Posed& b) : a_(a), b_(b) {}

  void add(ClearanceZone& zone, const NearTriangles& pair) const {
    const Corners p = world_corners(a_.shape, a_.pose, pair.triangles[0]),
                  q = world_corners(b_.shape, b_.pose, pair.triangles[1]);
    Bounds box{pair.point_a.cwiseMin(pair.point_b), pair.point_a.cwiseMax(pair.point_b)};
    NearTriangles found = pair;
    Vec3 normal = Vec3::Zero();
    if (pair.distance == 0) {
      ++zone.intersecting_pairs;
      box = shared_box(p, q);
      const PairAnswer depth = answer(pair);
      found.distance = std::min(depth.signed_distance, 0.0);
      if (depth.normal.norm() > 0.5)
        normal = depth.normal, found.point_a = depth.point_a, found.point_b = depth.point_b;
    }
    if (zone.pairs == 0) zone.bounds = box;
    zone.bounds = {zone.bounds.lo.cwiseMin(box.lo), zone.bounds.hi.cwiseMax(box.hi)};
    if (zone.pairs++ == 0 || found.distance < zone.signed_distance) {
      zone.signed_distance = found.distance;
      zone.triangles = found.triangles;
      zone.point_a = found.point_a;
      zone.point_b = found.point_b;
      zone.normal = normal;
    }
  }

  /// Sets the normal of a zone whose triangles do not intersect: that of their features, which rounding does not turn.
  void complete(ClearanceZone& zone) const {
    if (!zone.normal.isZero(0)) return;
    const PairAnswer r = answer({.triangles = zone.triangles});
    const double length = (zone.point_b - zone.point_a).norm();
    zone.normal = r.normal.norm() > 0.5 ? r.normal
                  : length > 0          ? unit(zone.point_b - zone.point_a, length)
                                        : Vec3::UnitZ();
  }

 private:
  PairAnswer answer(const NearTriangles& pair) const {
    const Corners p = mesh_of(a_.shape).corners(pair.triangles[0]), q = mesh_of(b_.shape).corners(pair.triangles[1]);
    return solve_convex(TriangleView(p), a_.pose, TriangleView(q), b_.pose, Request::distance, {}, nullptr);
  }

  const Posed &a_, &b_;
};

// Adds the areas of each zone's triangles, each once; `zone_of`: for each pair.
void add_areas(const Shape& shape, std::span<const NearTriangles> pairs, std::span<const std::uint32_t> zone_of,
               std::size_t side, WorkMeter& meter, std::vector<ClearanceZone>& zones) {
  std::vector<std::array<std::uint32_t, 2>> parts;
  parts.reserve(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) parts.push_back({zone_of[k], pairs[k].triangles[side]});
  sort_metered(meter, parts.begin(), parts.end(), std::less<std::array<std::uint32_t, 2>>());
  parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  for (const auto& [zone, t] : parts) {
    const Corners c = mesh_of(shape).corners(t);
    zones[zone].area[side] += (c[1] - c[0]).cross(c[2] - c[0]).norm() / 2;
  }
}

}  // namespace

SearchEnd visit_triangles(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                          const NearTrianglesVisitor& visitor, const NearOptions& options) {
  // Exceptions of the visitor, even WorkStopped of its own queries, are for the caller.
  bool in_visitor = false;
  const auto guarded = [&](const NearTriangles& pair) {
    in_visitor = true;
    const bool goes_on = visitor(pair);
    in_visitor = false;
    return goes_on;
  };
  try {
    return visit_all(a, pose_a, b, pose_b, guarded, options) ? SearchEnd::done : SearchEnd::by_visitor;
  } catch (const WorkStopped&) {
    if (in_visitor) throw;
    return SearchEnd::stopped;
  }
}

std::vector<ClearanceZone> clearance_zones(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                           const NearOptions& options) {
  std::vector<NearTriangles> pairs;
  const auto keep = [&](const NearTriangles& pair) {
    pairs.push_back(pair);
    return true;
  };
  visit_all(a, pose_a, b, pose_b, keep, options);
  WorkMeter meter(options.limit);
  sort_metered(meter, pairs.begin(), pairs.end(),
               [](const NearTriangles& x, const NearTriangles& y) { return x.triangles < y.triangles; });
  DisjointSets sets(pairs.size(), std::pmr::get_default_resource());
  join_neighbours(mesh_of(a), mesh_of(b), pairs, meter, sets);
  const Posed posed_a{a, pose_a}, posed_b{b, pose_b};
  const ZoneBuilder builder(posed_a, posed_b);
  std::vector<ClearanceZone> zones;
  std::vector<std::uint32_t> zone_of(pairs.size());
  for (std::uint32_t k = 0; k < pairs.size(); ++k) {
    meter.spend(16);
    const std::uint32_t first = sets.find(k);  // at most k
    if (first == k) zone_of[k] = static_cast<std::uint32_t>(zones.size()), zones.emplace_back();
    zone_of[k] = zone_of[first];
    builder.add(zones[zone_of[k]], pairs[k]);
  }
  add_areas(a, pairs, zone_of, 0, meter, zones);
  add_areas(b, pairs, zone_of, 1, meter, zones);
  for (ClearanceZone& zone : zones) builder.complete(zone);
  std::sort(zones.begin(), zones.end(), [](const ClearanceZone& x, const ClearanceZone& y) {
    return x.signed_distance != y.signed_distance ? x.signed_distance < y.signed_distance : x.triangles < y.triangles;
  });
  return zones;
}

}  // namespace tandem
