// Pairs of features of meshes within a margin.
#include "meshes/feature_pairs.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>

#include "closed_forms/closed_forms.h"
#include "meshes/edges_met.h"
#include "shapes/run_parts.h"
#include "shapes/shape_insides.h"
#include "shapes/triangle_height.h"
#include "shapes/work_meter.h"
#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {
namespace {

double point_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double dd = d.squaredNorm(), t = dd > 0 ? std::clamp(d.dot(p - a) / dd, 0.0, 1.0) : 0.0;
  return (p - (a + t * d)).norm();
}

// The distance to the projection on the triangle's plane if that is inside, else to a side. The projection is computed
// along the longest side, which is accurate even for slivers.
double point_triangle(const Vec3& p, const Corners& t) {
  double least = std::min({point_segment(p, t[0], t[1]), point_segment(p, t[1], t[2]), point_segment(p, t[2], t[0])});
  std::size_t i = 0;
  double side2 = 0;
  for (std::size_t k = 0; k < 3; ++k)
    if (const double length2 = (t[(k + 1) % 3] - t[k]).squaredNorm(); length2 > side2) side2 = length2, i = k;
  const Vec3 side = t[(i + 1) % 3] - t[i], slant = t[(i + 2) % 3] - t[i], height = Height(side, slant).height;
  const double height2 = height.squaredNorm();
  if (!(height2 > 0)) return least;
  const Vec3 r = p - t[i];
  const double up = r.dot(height) / height2, along = (r - up * slant).dot(side) / side2;
  if (up >= 0 && along >= 0 && up + along <= 1) least = std::min(least, (r - up * slant - along * side).norm());
  return least;
}

// The distance of points in both interiors (Ericson, Real-Time Collision Detection, 5.1.9), or at an end of one.
double segment_segment(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  const Vec3 d = q - p, e = s - r, w = p - r;
  const double dd = d.squaredNorm(), ee = e.squaredNorm(), de = d.dot(e), det = dd * ee - de * de;
  if (!(det > tolerance::crossing2 * dd * ee))  // squares have lost half of the digits of the cross product
    return segment_distance((p + q) / 2, d / 2, (r + s) / 2, e / 2).distance;
  const double least =
      std::min({point_segment(p, r, s), point_segment(q, r, s), point_segment(r, p, q), point_segment(s, p, q)});
  const double at = (de * e.dot(w) - d.dot(w) * ee) / det, on = (dd * e.dot(w) - de * d.dot(w)) / det;
  return at > 0 && at < 1 && on > 0 && on < 1 ? std::min(least, (w + at * d - on * e).norm()) : least;
}

// The features of a mesh by triangle: a vertex or edge, by its numbers of vertices, belongs to the first triangle that
// has it.
class NearFeatureRows {
 public:
  NearFeatureRows(const MeshModel& mesh, std::span<const std::uint32_t> first, const WorkLimit* limit)
      : mesh_(mesh), first_(first) {
    WorkMeter meter(limit);
    const MeshModel::Neighbours& neighbours = mesh.neighbours(limit);
    std::vector<std::uint8_t> seen(mesh.vertices.size(), 0);
    own_.resize(mesh.triangles.size(), 0);
    EdgesMet met(mesh.triangles.size());
    for (std::uint32_t t = 0; t < own_.size(); ++t) {
      meter.spend();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = vertex(t, k), beside = neighbours[t][k];
        if (seen[v] == 0) own_[t] |= static_cast<std::uint8_t>(1u << k);
        seen[v] = 1;
        const auto [v_lo, v_hi] = edge(t, k);
        // A neighbour before it had the edge, unless only its coordinates are the same.
        const bool had = beside != no_index && beside < t && has_vertex(beside, v_lo) && has_vertex(beside, v_hi);
        if (!had && v_lo != v_hi && met.is_new({v_lo, v_hi})) own_[t] |= static_cast<std::uint8_t>(8u << k);
      }
    }
  }

  std::uint32_t vertex(std::uint32_t t, std::size_t k) const {
    const std::uint32_t v = mesh_.triangles[t][k];
    return first_.empty() ? v : first_[v];
  }
  std::array<std::uint32_t, 2> edge(std::uint32_t t, std::size_t k) const {
    const std::uint32_t v = vertex(t, k), w = vertex(t, (k + 1) % 3);
    return {std::min(v, w), std::max(v, w)};
  }
  bool owns_vertex(std::uint32_t t, std::size_t k) const { return (own_[t] >> k & 1) != 0; }
  bool owns_edge(std::uint32_t t, std::size_t k) const { return (own_[t] >> (3 + k) & 1) != 0; }
  bool has_vertex(std::uint32_t t, std::uint32_t v) const {
    return vertex(t, 0) == v || vertex(t, 1) == v || vertex(t, 2) == v;
  }

 private:
  const MeshModel& mesh_;
  const std::span<const std::uint32_t> first_;
  std::vector<std::uint8_t> own_;  // for each triangle, three bits for vertices and three for edges
};

// Two meshes, or one (`self`); corners of A as given, of B transformed.
struct FeatureSides {
  const MeshModel& a;
  const NearFeatureRows& of_a;
  const MeshModel& b;
  const NearFeatureRows& of_b;
  bool self;
  Pose b_in_a;
};

// Tests the features of each pair of triangles and calls the visitor.
class FeaturePairs final : public PairVisitor {
 public:
  FeaturePairs(const FeatureSides& sides, double margin, const NearFeatureVisitor& visitor, const WorkLimit* limit)
      : PairVisitor(limit), s_(sides), margin_(margin), visitor_(visitor) {}

  bool visit(std::uint32_t i, std::uint32_t j) override {
    meter.spend(a_pair);
    const Corners p = s_.a.corners(i);
    Corners q = s_.b.corners(j);
    if (!s_.self)
      for (Vec3& corner : q) corner = s_.b_in_a * corner;
    for (std::size_t k = 0; k < 3; ++k) {
      if (s_.of_a.owns_vertex(i, k)) add_point(s_.of_a.vertex(i, k), p[k], j, s_.of_b, q, visitor_.point);
      if (s_.of_b.owns_vertex(j, k))
        add_point(s_.of_b.vertex(j, k), q[k], i, s_.of_a, p, s_.self ? visitor_.point : visitor_.point_of_b);
      for (std::size_t l = 0; l < 3 && s_.of_a.owns_edge(i, k); ++l)
        if (s_.of_b.owns_edge(j, l))
          add_edges(s_.of_a.edge(i, k), s_.of_b.edge(j, l),
                    segment_segment(p[k], p[(k + 1) % 3], q[l], q[(l + 1) % 3]));
    }
    return ended_;
  }
  bool ended() const { return ended_; }

 private:
  static constexpr int a_pair = 8;  // of triangles: units of work

  template <class Found>
  void report(const std::function<bool(const Found&)>& function, const Found& found) {
    if (function && !ended_) ended_ = !function(found);
  }

  void add_point(std::uint32_t v, const Vec3& place, std::uint32_t t, const NearFeatureRows& of_t,
                 const Corners& corners, const std::function<bool(const NearPoint&)>& function) {
    if (s_.self && of_t.has_vertex(t, v)) return;
    if (const double distance = point_triangle(place, corners); distance <= margin_)
      report(function, NearPoint{v, t, distance});
  }

  void add_edges(const std::array<std::uint32_t, 2>& a, const std::array<std::uint32_t, 2>& b, double distance) {
    if (!(distance <= margin_)) return;
    if (s_.self && (a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1])) return;
    const bool exchanged = s_.self && b < a;
    report(visitor_.edges, NearEdges{exchanged ? b : a, exchanged ? a : b, distance});
  }

  const FeatureSides& s_;
  const double margin_;
  const NearFeatureVisitor& visitor_;
  bool ended_ = false;
};

bool before(const NearPoint& x, const NearPoint& y) {
  return std::tie(x.vertex, x.triangle) < std::tie(y.vertex, y.triangle);
}
bool before(const NearEdges& x, const NearEdges& y) { return std::tie(x.a, x.b) < std::tie(y.a, y.b); }

// The results of the parts, sorted.
template <class Pair>
void join(std::vector<NearFeatures>& found, std::vector<Pair> NearFeatures::*list, NearFeatures& all) {
  std::vector<Pair>& pairs = all.*list;
  for (NearFeatures& some : found) {
    pairs.insert(pairs.end(), (some.*list).begin(), (some.*list).end());
    some.*list = {};
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) { return before(x, y); });
}

NearFeatures list_features(const NearBoxPairs& near, const FeatureSides& sides, double margin,
                           const PartRunner& parts) {
  const std::vector<NodePair> subtrees = near.subtrees();
  std::vector<NearFeatures> found(subtrees.size());
  run_parts(parts, subtrees.size(), [&](std::size_t k) {
    NearFeatures& its = found[k];
    const NearFeatureVisitor keep{[&](const NearPoint& p) { return its.points.push_back(p), true; },
                                  [&](const NearPoint& p) { return its.points_of_b.push_back(p), true; },
                                  [&](const NearEdges& e) { return its.edges.push_back(e), true; }};
    FeaturePairs pairs(sides, margin, keep, nullptr);
    near.visit(subtrees[k], pairs);
  });
  NearFeatures all;
  join(found, &NearFeatures::points, all);
  join(found, &NearFeatures::points_of_b, all);
  join(found, &NearFeatures::edges, all);
  return all;
}

SearchEnd report_features(const NearBoxPairs& near, const FeatureSides& sides, double margin,
                          const NearFeatureVisitor& visitor, const SearchOptions& options) {
  FeaturePairs pairs(sides, margin, visitor, options.limit);
  return visit_in_turn(near, pairs, options, [&] { return pairs.ended(); });
}

void require_meshes(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  require_valid(pose_a, "a");
  require_valid(pose_b, "b");
  for (const Shape* shape : {&a, &b})
    if (!has_triangles(*shape))
      throw std::invalid_argument("near features: a shape is a " + std::string(name(shape->kind())) +
                                  "; both must be a mesh or a triangle");
}

Pose pose_in(const Pose& a, const Pose& b) {
  const Mat3 back = a.rotation.transpose();
  return {back * b.rotation, back * (b.translation - a.translation)};
}

}  // namespace

void require_feature_margin(double margin) {
  if (!(margin >= 0) || !std::isfinite(margin))
    throw std::invalid_argument("margin: " + written(margin) + " is not finite and >= 0");
}

NearFeatures near_features(const MeshModel& mesh, std::span<const std::uint32_t> first, double margin,
                           const PartRunner& parts) {
  const NearFeatureRows features(mesh, first, nullptr);
  return list_features(NearBoxPairs(mesh, margin), {mesh, features, mesh, features, true, Pose{}}, margin, parts);
}

SearchEnd visit_near_features(const MeshModel& mesh, std::span<const std::uint32_t> first, double margin,
                              const NearFeatureVisitor& visitor, const SearchOptions& options) try {
  const NearFeatureRows features(mesh, first, options.limit);
  return report_features(NearBoxPairs(mesh, margin), {mesh, features, mesh, features, true, Pose{}}, margin, visitor,
                         options);
} catch (const WorkStopped&) {
  return SearchEnd::stopped;
}

NearFeatures near_features(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                           const PartRunner& parts) {
  require_feature_margin(margin);
  require_meshes(a, pose_a, b, pose_b);
  const MeshModel &ma = mesh_of(a), &mb = mesh_of(b);
  const NearFeatureRows of_a(ma, {}, nullptr), of_b(mb, {}, nullptr);
  return list_features(NearBoxPairs({a, pose_a}, {b, pose_b}, margin),
                       {ma, of_a, mb, of_b, false, pose_in(pose_a, pose_b)}, margin, parts);
}

SearchEnd visit_near_features(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                              const NearFeatureVisitor& visitor, const SearchOptions& options) {
  require_feature_margin(margin);
  require_meshes(a, pose_a, b, pose_b);
  try {
    const MeshModel &ma = mesh_of(a), &mb = mesh_of(b);
    const NearFeatureRows of_a(ma, {}, options.limit), of_b(mb, {}, options.limit);
    return report_features(NearBoxPairs({a, pose_a}, {b, pose_b}, margin),
                           {ma, of_a, mb, of_b, false, pose_in(pose_a, pose_b)}, margin, visitor, options);
  } catch (const WorkStopped&) {
    return SearchEnd::stopped;
  }
}

}  // namespace tandem
