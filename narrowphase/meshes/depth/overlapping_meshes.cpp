// Two meshes that overlap: queries of the search for a separating translation.
#include "meshes/depth/overlapping_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "meshes/depth/off_parts.h"
#include "meshes/traversal/hierarchy.h"
#include "meshes/traversal/mesh_nearest.h"
#include "pairs/convex_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "shapes/triangle_height.h"
#include "shapes/unit_vector.h"
#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr SearchEffort effort_of_meshes{.least_reach = tolerance::least_reach,
                                        .rounds = 12,
                                        .plane_reach = 0.02,
                                        .margin = 4,
                                        .plane_slack = 1.0 / 8,
                                        .trust_planes = false};

// A border edge of a face in a pose, with its distance from the point where the face is pierced.
struct Border : Edge {
  double distance;
};

// The borders of a face that is pierced at a point: the nearest few first, sorted.
constexpr std::size_t most_lines = 4;
template <class Place>
std::vector<Border> nearest_borders(const CoplanarRegion& face, const Vec3& point, const Place& place) {
  std::vector<Border> borders;
  borders.reserve(face.border.size());
  for (const Edge& border : face.border) {
    const Vec3 p = place(border.from), q = place(border.to), d = q - p;
    const double length2 = d.squaredNorm();
    // A border too short to be squared is a point.
    const double fraction = length2 > 0 ? std::clamp((point - p).dot(d) / length2, 0.0, 1.0) : 0;
    borders.push_back({{p, q}, (p + fraction * d - point).norm()});
  }
  const std::size_t lines = std::min(most_lines, borders.size());
  std::partial_sort(borders.begin(), borders.begin() + static_cast<std::ptrdiff_t>(lines), borders.end(),
                    [](const Border& x, const Border& y) { return x.distance < y.distance; });
  return borders;
}

// Known separating planes; the last one that separated is tried first.
class SeparatingPlanes {
 public:
  struct Plane {
    Vec3 n, of_a, of_b;  // world axes; A's and B's, absolute
    double gap;
  };

  // True if one of them separates two objects, by its gap.
  template <class GapAlong>
  bool separate(GapAlong&& gap_along) {
    if (last_ < planes_.size() && gap_along(planes_[last_]) >= planes_[last_].gap) return true;
    for (std::size_t k = 0; k < planes_.size(); ++k)
      if (k != last_ && gap_along(planes_[k]) >= planes_[k].gap) {
        last_ = k;
        return true;
      }
    return false;
  }
  void add(const Plane& plane) { planes_.push_back(plane); }

 private:
  std::vector<Plane> planes_;
  std::size_t last_ = 0;
};

double gap_along(const Vec3& n, const Corners& s, const Corners& t) { return least_along(n, t) - most_along(n, s); }

}  // namespace

OverlappingMeshes::OverlappingMeshes(const Posed& a, const Posed& b, std::span<const TrianglePair> pairs,
                                     const NarrowPhaseOptions& options)
    : OverlappingPair(a.shape.size() + b.shape.size(), effort_of_meshes),
      a_(a),
      b_(b),
      pairs_(pairs),
      options_(options),
      between_(b.pose.translation - a.pose.translation),
      features_{MeshFeatures(mesh_of(b.shape), slack), MeshFeatures(mesh_of(a.shape), slack)} {
  for (const Posed* posed : {&a, &b}) mesh_of(posed->shape).neighbours(options.limit);  // needed for the features
}

Vec3 OverlappingMeshes::placed(bool of_a, const Vec3& v, const Vec3& at) const {
  return of_a ? Vec3(a_.pose.rotation * v) : Vec3(b_.pose.rotation * v + between_ + at);
}

bool OverlappingMeshes::collide(const Vec3& move) const {
  return meshes_collide(a_, {b_.shape, moved_b(move)}, options_.limit);
}

// By bisection; translations in between need not be free.
double OverlappingMeshes::free_length(const Vec3& direction, const Separation& known) const {
  constexpr int halvings = 12;
  double free = tolerance::worth_shortening * std::min(known.length, size), blocked = known.certain;
  if (!is_free(free * direction)) return infinity;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (free + blocked) / 2;
    (is_free(middle * direction) ? free : blocked) = middle;
  }
  return free;
}

std::span<const TrianglePair> OverlappingMeshes::pairs_at(const Vec3& at, PairMemory& memory,
                                                          TrianglePairs& found) const {
  if (at.isZero(0)) return pairs_;
  const Pose pose = moved_b(at);
  TriangleTest test(a_.pose, pose, reach(mesh(false)));
  found = meeting_pairs(a_, {b_.shape, pose}, test, options_, memory, nullptr);
  return found;
}

bool OverlappingMeshes::add_constraints(const Vec3& at, LocalConstraints& constraints) const {
  constexpr std::size_t most_pairs = 512;
  constexpr std::size_t at_once = 16;  // contradictory ones are found early
  PairMemory memory(std::pmr::get_default_resource());
  TrianglePairs there(&memory.resource);
  const std::span<const TrianglePair> pairs = pairs_at(at, memory, there);
  bool is_new = false;
  WorkMeter meter(options_.limit);
  for (std::size_t first = 0; first < std::min(pairs.size(), most_pairs); first += at_once) {
    for (const auto& [i, j] : pairs.subspan(first, std::min(at_once, pairs.size() - first))) {
      meter.spend(64);
      for (std::size_t k = 0; k < 3; ++k) {
        is_new = add_edge_through_face(true, i, k, j, at, constraints) || is_new;
        is_new = add_edge_through_face(false, j, k, i, at, constraints) || is_new;
      }
    }
    if (Vec3 to; !constraints.shortest(0, slack, to)) return false;
  }
  return is_new;
}

// With B translated by `at`, off each pair of triangles that intersect there.
bool OverlappingMeshes::add_off_triangles(const Vec3& at, LocalConstraints& constraints) const {
  constexpr std::size_t most_pairs = 512;
  PairMemory memory(std::pmr::get_default_resource());
  TrianglePairs found(&memory.resource);
  const std::span<const TrianglePair> all = pairs_at(at, memory, found);
  const std::span<const TrianglePair> pairs = all.first(std::min(most_pairs, all.size()));
  const auto corners = [&](bool of_a, std::uint32_t t) {
    Corners p = mesh(of_a).corners(t);
    for (Vec3& v : p) v = placed(of_a, v, at);
    return p;
  };
  // From A to B.
  const auto outside = [&](bool of_a, const Corners& p) {
    return mesh(of_a).solid ? Vec3((of_a ? 1 : -1) * area_vector(p).stableNormalized()) : Vec3(Vec3::Zero());
  };
  OffParts off(at, slack / 8, constraints);
  for (const auto& [i, j] : pairs) {
    off.add_outside(outside(true, corners(true, i)));
    off.add_outside(outside(false, corners(false, j)));
  }
  WorkMeter meter(options_.limit);
  constexpr std::size_t at_once = 16;  // those of bodies deep in each other are found early
  for (std::size_t first = 0; first < pairs.size(); first += at_once) {
    for (const auto& [i, j] : pairs.subspan(first, std::min(at_once, pairs.size() - first))) {
      meter.spend(16);
      const Corners p = corners(true, i), q = corners(false, j);
      const auto gap = [&](const Vec3& n) { return gap_along(n, p, q); };
      const Vec3 out_a = outside(true, p), out_b = outside(false, q);
      const Vec3& out = out_a.isZero(0) || (!out_b.isZero(0) && gap(out_b) > gap(out_a)) ? out_b : out_a;
      if (off.leave(out, gap)) continue;
      off.add(solve_convex(TriangleView(p), {}, TriangleView(q), {}, Request::distance, {}, nullptr), out, gap);
    }
    if (Vec3 to; !constraints.shortest(infinity, 0, to) || to.norm() > longest_off()) return false;
  }
  if (pairs.empty()) {
    // One inside the other: through the nearest triangles.
    NearestSearch search(a_, {b_.shape, moved_b(at)}, options_.limit);
    Nearest near = search();
    const Vec3 out = -search.normal(options_, near);
    off.add(out, -near.distance);
  }
  return off.finish();
}

std::optional<Vec3> OverlappingMeshes::off_triangles(const Vec3& first) const {
  if (pairs_.size() > few_pairs) return std::nullopt;
  const auto add = [&](const Vec3& at, int, LocalConstraints& off) { return add_off_triangles(at, off); };
  return translation_off_all(first, off_precision(), add, [&](const Vec3& at) { return collide(at); });
}

// Edge k of triangle i of one mesh, with B translated by `at`, through triangle j of the other.
bool OverlappingMeshes::add_edge_through_face(bool of_a, std::uint32_t i, std::size_t k, std::uint32_t j,
                                              const Vec3& at, LocalConstraints& constraints) const {
  MeshFeatures &own = features_[of_a ? 1 : 0], &other = features_[of_a ? 0 : 1];
  if (!own.is_edge(i, k)) return false;
  const Corners edges = mesh(of_a).corners(i);
  const Vec3 p = placed(of_a, edges[k], at), q = placed(of_a, edges[(k + 1) % 3], at);
  const auto all_placed = [&](const Corners& c) {
    return Corners{placed(!of_a, c[0], at), placed(!of_a, c[1], at), placed(!of_a, c[2], at)};
  };
  const CoplanarRegion& face = other.face(j);
  const Corners t = all_placed(mesh(!of_a).corners(j)), seed = mesh(!of_a).corners(face.triangles[0]);
  // From the given corners: the rounding of transformed ones would turn a sliver's normal.
  const Height own_face = height_of(seed[1] - seed[0], seed[2] - seed[1], seed[0] - seed[2]);
  const Mat3& turn = (of_a ? b_ : a_).pose.rotation;
  const Vec3 area = (turn * own_face.side).cross(turn * own_face.height);
  const double length = area.norm();
  if (!(length > 0)) return false;
  const Vec3 n = unit(area, length), foot = placed(!of_a, seed[0], at);
  const double from = n.dot(p - foot), to = n.dot(q - foot);
  if (!(from * to < 0)) return false;
  const Vec3 crossing = p + from / (from - to) * (q - p);
  if (!contains_point(t, crossing, slack)) return false;
  return add_constraints_of(of_a, own.straight_edge(i, k), face, n, crossing, at, constraints);
}

// An edge through the interior of a face with this normal. It leaves the face at one of its ends or over a border. On
// the inner side of a border's line the half disc about the crossing lies in the face as far as no other border enters
// it.
bool OverlappingMeshes::add_constraints_of(bool of_a, const Edge& edge, const CoplanarRegion& face, const Vec3& n,
                                           const Vec3& crossing, const Vec3& at, LocalConstraints& constraints) const {
  WorkMeter meter(options_.limit);
  meter.spend(1 + static_cast<int>(face.triangles.size()));
  const Vec3 from = placed(of_a, edge.from, at), to = placed(of_a, edge.to, at), u = unit(to - from);
  const double low = n.dot(from - crossing), high = n.dot(to - crossing), slope = n.dot(u);
  if (!(std::abs(slope) > tolerance::flush)) return false;
  const std::vector<Border> borders =
      nearest_borders(face, crossing, [&](const Vec3& v) { return placed(!of_a, v, at); });
  bool is_new = false;
  // `direction`: of the edge relative to the face, which it leaves at `place`.
  const auto add = [&](const Vec3& direction, double bound, double reach, const Vec3& place) {
    const Vec3 normal = of_a ? Vec3(-direction) : direction;
    const LocalConstraint found{
        {normal, normal.dot(at) + bound}, reach - at.norm(), place - (bound * direction + at) / 2};
    if (found.bound > 0 && found.reach > found.bound) is_new = constraints.add(found) || is_new;
  };
  const double inside = borders.empty() ? 0 : borders.front().distance * std::abs(slope);
  add(low < 0 ? n : Vec3(-n), std::abs(low), std::min(std::abs(high), inside), from - low * n);
  add(high < 0 ? n : Vec3(-n), std::abs(high), std::min(std::abs(low), inside), to - high * n);
  for (const Border& line : std::span(borders).first(std::min(most_lines, borders.size()))) {
    meter.spend(1 + static_cast<int>(borders.size() / 8));
    const Vec3 inward = n.cross(unit(line.to - line.from));
    const double beside = inward.dot(crossing - line.from);
    double reach = std::min(std::abs(low), std::abs(high));
    for (const Border& other : borders)
      if (inward.dot(other.from - line.from) > slack || inward.dot(other.to - line.from) > slack)
        reach = std::min(reach, other.distance * std::abs(slope));
    const Vec3 across = inward - (inward.dot(u) / slope) * n;
    const double steep = across.norm();
    if (!(beside > 0)) continue;
    const Vec3 direction = -across / steep;
    const double bound = beside / steep;
    add(direction, bound, reach, crossing + bound * (direction - (n.dot(direction) / slope) * u));
  }
  return is_new;
}

// Descends both hierarchies, the larger box first, to triangles; pairs separated by a known plane are skipped.
bool OverlappingMeshes::separating_planes(const Vec3& at, double reach, std::vector<Constraint>& planes) {
  const MeshModel &ma = mesh(true), &mb = mesh(false);
  const Mat3 &turn_a = a_.pose.rotation, &turn_b = b_.pose.rotation;
  const Vec3 shift = between_ + at;
  const double far = reach + tolerance::askew * size;  // rotations may be slightly inexact
  SeparatingPlanes known;
  WorkMeter meter(options_.limit);
  planes.clear();
  // False: they touch.
  const auto separate = [&](std::uint32_t i, std::uint32_t j) {
    constexpr std::size_t most = 64;
    Corners s = ma.corners(i), t = mb.corners(j);
    for (std::size_t k = 0; k < 3; ++k) s[k] = placed(true, s[k], at), t[k] = placed(false, t[k], at);
    if (known.separate([&](const SeparatingPlanes::Plane& plane) { return gap_along(plane.n, s, t); })) return true;
    const Pose none;
    const PairAnswer r = solve_convex(TriangleView(s), none, TriangleView(t), none, Request::distance, {}, nullptr);
    if (r.signed_distance > reach) return true;
    const double gap = gap_along(r.normal, s, t);
    if (planes.size() == most || !(r.signed_distance > 0 && gap > 0)) return false;
    known.add({r.normal, (turn_a.transpose() * r.normal).cwiseAbs(), (turn_b.transpose() * r.normal).cwiseAbs(), gap});
    planes.push_back({r.normal, r.normal.dot(at) - gap});
    return true;
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> stack{{whole, whole}};
  while (!stack.empty()) {
    const std::uint32_t x = stack.back().first, y = stack.back().second;
    stack.pop_back();
    const BoxOf box_a(ma, x), box_b(mb, y);
    const Vec3 d = turn_b * box_b.mid + shift - turn_a * box_a.mid;
    if (d.norm() - box_a.half.norm() - box_b.half.norm() > far) continue;
    if (known.separate([&](const SeparatingPlanes::Plane& plane) {
          return plane.n.dot(d) - plane.of_a.dot(box_a.half) - plane.of_b.dot(box_b.half);
        }))
      continue;
    meter.spend(8);
    if (work_left_ == 0) return false;
    --work_left_;
    const bool leaf_a = is_leaf(ma, x), leaf_b = is_leaf(mb, y);
    if (leaf_b ? !leaf_a : !leaf_a && box_a.half.squaredNorm() >= box_b.half.squaredNorm()) {
      each_child(ma, x, [&](std::uint32_t child) { stack.emplace_back(child, y); });
    } else if (!leaf_b) {
      each_child(mb, y, [&](std::uint32_t child) { stack.emplace_back(x, child); });
    } else {
      bool all = true;
      all = all && separate(leaf_triangle(ma, x), leaf_triangle(mb, y));
      if (!all) return false;
    }
  }
  return true;
}

}  // namespace tandem
