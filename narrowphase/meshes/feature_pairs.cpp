#include "meshes/feature_pairs.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>

#include "closed_forms/closed_forms.h"
#include "convex/triangle_height.h"
#include "shapes/run_parts.h"
#include "shapes/shape_insides.h"
#include "tolerances.h"

namespace tandem {
namespace {

double point_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double dd = d.squaredNorm(), t = dd > 0 ? std::clamp(d.dot(p - a) / dd, 0.0, 1.0) : 0.0;
  return (p - (a + t * d)).norm();
}

// To the foot on its plane where that lies inside, or to a side. The foot keeps its place along the longest side,
// whatever rounding makes of a sliver's normal.
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

// Where both are nearest inside (Ericson, Real-Time Collision Detection, 5.1.9), or at an end of one.
double segment_segment(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  const Vec3 d = q - p, e = s - r, w = p - r;
  const double dd = d.squaredNorm(), ee = e.squaredNorm(), de = d.dot(e), det = dd * ee - de * de;
  if (!(det > tolerance::crossing2 * dd * ee))  // squares have lost half of the crossing's digits
    return segment_distance((p + q) / 2, d / 2, (r + s) / 2, e / 2).distance;
  const double least =
      std::min({point_segment(p, r, s), point_segment(q, r, s), point_segment(r, p, q), point_segment(s, p, q)});
  const double at = (de * e.dot(w) - d.dot(w) * ee) / det, on = (dd * e.dot(w) - de * d.dot(w)) / det;
  return at > 0 && at < 1 && on > 0 && on < 1 ? std::min(least, (w + at * d - on * e).norm()) : least;
}

// A mesh's features: a vertex belongs to the first of its triangles, an edge to the first of those beside it.
class NearFeatureRows {
 public:
  NearFeatureRows(const MeshModel& mesh, std::span<const std::uint32_t> first) : mesh_(mesh), first_(first) {
    std::vector<std::uint8_t> seen(mesh.vertices.size(), 0);
    own_.resize(mesh.triangles.size(), 0);
    for (std::uint32_t t = 0; t < own_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = vertex(t, k), beside = mesh.neighbours[t][k];
        if (seen[v] == 0) own_[t] |= static_cast<std::uint8_t>(1u << k);
        seen[v] = 1;
        // Beside itself where it is given with one corner twice.
        if ((beside == no_index || t <= beside) && v != vertex(t, (k + 1) % 3))
          own_[t] |= static_cast<std::uint8_t>(8u << k);
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
  std::vector<std::uint8_t> own_;  // of each triangle, three bits for vertices and three for edges
};

// Looks at the features of each pair of triangles.
class FeaturePairs final : public PairVisitor {
 public:
  /// Corners of A as they are, of B turned and moved. `self`: one mesh.
  FeaturePairs(const MeshModel& a, const NearFeatureRows& of_a, const MeshModel& b, const NearFeatureRows& of_b,
               bool self, const Pose& b_in_a, double margin, NearFeatures& found)
      : PairVisitor(nullptr),
        a_(a),
        of_a_(of_a),
        b_(b),
        of_b_(of_b),
        self_(self),
        b_in_a_(b_in_a),
        margin_(margin),
        found_(found) {}

  bool visit(std::uint32_t i, std::uint32_t j) override {
    const Corners p = a_.corners(i);
    Corners q = b_.corners(j);
    if (!self_)
      for (Vec3& corner : q) corner = b_in_a_ * corner;
    for (std::size_t k = 0; k < 3; ++k) {
      if (of_a_.owns_vertex(i, k)) add_point(of_a_.vertex(i, k), p[k], j, of_b_, q, found_.points);
      if (of_b_.owns_vertex(j, k))
        add_point(of_b_.vertex(j, k), q[k], i, of_a_, p, self_ ? found_.points : found_.points_of_b);
      for (std::size_t l = 0; l < 3 && of_a_.owns_edge(i, k); ++l)
        if (of_b_.owns_edge(j, l))
          add_edges(of_a_.edge(i, k), of_b_.edge(j, l), segment_segment(p[k], p[(k + 1) % 3], q[l], q[(l + 1) % 3]));
    }
    return false;
  }

 private:
  void add_point(std::uint32_t v, const Vec3& place, std::uint32_t t, const NearFeatureRows& of_t,
                 const Corners& corners, std::vector<NearPoint>& points) const {
    if (self_ && of_t.has_vertex(t, v)) return;
    if (const double distance = point_triangle(place, corners); distance <= margin_) points.push_back({v, t, distance});
  }

  void add_edges(const std::array<std::uint32_t, 2>& a, const std::array<std::uint32_t, 2>& b, double distance) {
    if (!(distance <= margin_)) return;
    if (self_ && (a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1])) return;
    const bool exchanged = self_ && b < a;
    found_.edges.push_back({exchanged ? b : a, exchanged ? a : b, distance});
  }

  const MeshModel& a_;
  const NearFeatureRows& of_a_;
  const MeshModel& b_;
  const NearFeatureRows& of_b_;
  const bool self_;
  const Pose b_in_a_;
  const double margin_;
  NearFeatures& found_;
};

bool before(const NearPoint& x, const NearPoint& y) {
  return std::tie(x.vertex, x.triangle, x.distance) < std::tie(y.vertex, y.triangle, y.distance);
}
bool before(const NearEdges& x, const NearEdges& y) {
  return std::tie(x.a, x.b, x.distance) < std::tie(y.a, y.b, y.distance);
}
bool same(const NearPoint& x, const NearPoint& y) { return x.vertex == y.vertex && x.triangle == y.triangle; }
bool same(const NearEdges& x, const NearEdges& y) { return x.a == y.a && x.b == y.b; }

// What the parts have found, sorted; edges with more than two triangles are found more than once.
template <class Pair>
void join(std::vector<NearFeatures>& found, std::vector<Pair> NearFeatures::*list, NearFeatures& all) {
  std::vector<Pair>& pairs = all.*list;
  for (NearFeatures& some : found) {
    pairs.insert(pairs.end(), (some.*list).begin(), (some.*list).end());
    some.*list = {};
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) { return before(x, y); });
  pairs.erase(std::unique(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) { return same(x, y); }),
              pairs.end());
}

template <class MakeVisitor>
NearFeatures find(const NearBoxPairs& near, const PartRunner& parts, const MakeVisitor& make) {
  const std::vector<NodePair> subtrees = near.subtrees();
  std::vector<NearFeatures> found(subtrees.size());
  run_parts(parts, subtrees.size(), [&](std::size_t k) {
    FeaturePairs pairs = make(found[k]);
    near.visit(subtrees[k], pairs);
  });
  NearFeatures all;
  join(found, &NearFeatures::points, all);
  join(found, &NearFeatures::points_of_b, all);
  join(found, &NearFeatures::edges, all);
  return all;
}

}  // namespace

void require_feature_margin(double margin) {
  if (!(margin >= 0) || !std::isfinite(margin))
    throw std::invalid_argument("margin: " + std::to_string(margin) + " is not finite and >= 0");
}

NearFeatures near_features(const MeshModel& mesh, std::span<const std::uint32_t> first, double margin,
                           const PartRunner& parts) {
  const NearFeatureRows features(mesh, first);
  return find(NearBoxPairs(mesh, margin), parts, [&](NearFeatures& found) {
    return FeaturePairs(mesh, features, mesh, features, true, Pose{}, margin, found);
  });
}

NearFeatures near_features(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                           const PartRunner& parts) {
  require_feature_margin(margin);
  require_valid(pose_a, "a");
  require_valid(pose_b, "b");
  for (const Shape* shape : {&a, &b})
    if (!has_triangles(*shape))
      throw std::invalid_argument("near features: a shape is a " + std::string(name(shape->kind())) +
                                  "; both must be a mesh or a triangle");
  const MeshModel &ma = mesh_of(a), &mb = mesh_of(b);
  const NearFeatureRows of_a(ma, {}), of_b(mb, {});
  const Mat3 back = pose_a.rotation.transpose();
  const Pose b_in_a{back * pose_b.rotation, back * (pose_b.translation - pose_a.translation)};
  return find(NearBoxPairs({a, pose_a}, {b, pose_b}, margin), parts,
              [&](NearFeatures& found) { return FeaturePairs(ma, of_a, mb, of_b, false, b_in_a, margin, found); });
}

}  // namespace tandem
