// Normals of two polytopes that almost touch, from the directions that their features define.
#include "convex/feature_normals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "convex/gjk.h"
#include "shapes/hull.h"
#include "shapes/triangle_height.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int few_corners = 8;    // any two of so few count as an edge, any three as a face
constexpr int most_corners = 64;  // among more than a few, only the hull's edges and faces count

/// The corners of a core that are (almost) farthest along a direction.
struct CornerSet {
  Vec3 at[most_corners];
  std::uint32_t vertex[most_corners];
  int count = 0;
};

std::uint32_t corner_count(const ConvexView& v) {
  switch (v.kind) {
    case ShapeKind::box:
      return 8;
    case ShapeKind::capsule:
      return 2;
    case ShapeKind::convex:
    case ShapeKind::triangle:
      return static_cast<std::uint32_t>(v.vertices.size());
    case ShapeKind::sphere:
    case ShapeKind::cylinder:
    case ShapeKind::cone:
    case ShapeKind::ellipsoid:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  return 1;
}

/// The CornerSet within `near` of the farthest along d (in the core's frame), the farthest first; if these are few, a
/// few within `depth`.
CornerSet farthest_corners(const ConvexView& v, const Vec3& d, double near, double depth) {
  CornerSet c;
  double reach[most_corners];
  const double most = d.dot(core_support(v, d));
  const std::uint32_t count = corner_count(v);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 p = core_vertex(v, i);
    const double along = d.dot(p);
    if (along < most - depth) continue;
    int k = c.count;
    if (k == most_corners) {
      if (along <= reach[most_corners - 1]) continue;
      --k;
    } else {
      ++c.count;
    }
    for (; k > 0 && reach[k - 1] < along; --k)
      reach[k] = reach[k - 1], c.at[k] = c.at[k - 1], c.vertex[k] = c.vertex[k - 1];
    reach[k] = along;
    c.at[k] = p;
    c.vertex[k] = i;
  }
  while (c.count > few_corners && reach[c.count - 1] < most - near) --c.count;
  return c;
}

/// Edges between corners: all of a few, else those of the hull.
class Edges {
 public:
  Edges(const ConvexView& v, const CornerSet& c)
      : view_(v), corners_(c), few_(c.count <= few_corners || v.hull == nullptr) {
    if (few_) return;
    place_.assign(v.vertices.size(), -1);
    for (int i = 0; i < c.count; ++i) place_[c.vertex[i]] = i;
  }

  /// Calls edge(i, j) for the numbers of an edge's corners.
  template <class Call>
  void each_edge(Call&& edge) const {
    if (few_) {
      for (int i = 0; i < corners_.count; ++i)
        for (int j = i + 1; j < corners_.count; ++j) edge(i, j);
      return;
    }
    for (const Hull::Edge& e : view_.hull->edges)
      if (const int i = place_[e.v[0]], j = place_[e.v[1]]; i >= 0 && j >= 0) edge(i, j);
  }
  /// Calls face(i, j, k) for three corners of a face.
  template <class Call>
  void each_face(Call&& face) const {
    if (few_) {
      for (int i = 0; i < corners_.count; ++i)
        for (int j = i + 1; j < corners_.count; ++j)
          for (int k = j + 1; k < corners_.count; ++k) face(i, j, k);
      return;
    }
    const Hull& hull = *view_.hull;
    for (const Hull::Face& f : hull.faces)
      for (std::uint32_t k = 1; k + 1 < f.count; ++k) {
        const std::uint32_t* const loop = hull.loop.data() + f.first;
        if (const int p = place_[loop[0]], q = place_[loop[k]], r = place_[loop[k + 1]]; p >= 0 && q >= 0 && r >= 0)
          face(p, q, r);
      }
  }

 private:
  const ConvexView& view_;
  const CornerSet& corners_;
  bool few_;
  std::vector<int> place_;  // for each vertex its place among the corners, -1: none
};

class Features {
 public:
  Features(const MinkowskiDifference& d, const Vec3& n, double near, double depth) : d_(d) {
    a_ = farthest_corners(d.a, n, near, depth);
    b_ = own_b_ = farthest_corners(d.b, -(d.pose.rotation.transpose() * n), near, depth);
    for (int i = 0; i < b_.count; ++i) b_.at[i] = d.pose.rotation * b_.at[i];
  }

  /// Finds the best direction of all, if it separates by more than `best`. Of equally good ones the first is kept:
  /// those from a corner to a corner, or square to an edge from it, come first, as they lead between the nearest
  /// points.
  void search(double& best, Vec3& n) {
    best_ = &best, n_ = &n;
    try_corners();
    const Edges of_a(d_.a, a_), of_b(d_.b, b_);
    try_faces(of_a, a_, Mat3::Identity());
    // From its untransformed corners: transformed ones are rounded, which matters for a thin triangle.
    try_faces(of_b, own_b_, d_.pose.rotation);
    of_a.each_edge([&](int i, int j) {
      of_b.each_edge([&](int k, int l) { try_across(a_.at[j] - a_.at[i], b_.at[l] - b_.at[k]); });
    });
  }

 private:
  void try_corners() {
    const int few_a = std::min(a_.count, few_corners), few_b = std::min(b_.count, few_corners);
    for (int i = 0; i < few_a; ++i)
      for (int k = 0; k < few_b; ++k) {
        const Vec3 between = b_.at[k] + d_.pose.translation - a_.at[i];
        try_direction(between);
        for (int j = 0; j < few_a; ++j)
          if (j != i) try_beside(between, a_.at[j] - a_.at[i]);
        for (int l = 0; l < few_b; ++l)
          if (l != k) try_beside(between, b_.at[l] - b_.at[k]);
      }
  }
  void try_faces(const Edges& edges, const CornerSet& c, const Mat3& turn) {
    edges.each_face([&](int i, int j, int k) {
      try_across(height_of(c.at[j] - c.at[i], c.at[k] - c.at[j], c.at[i] - c.at[k]), turn);
    });
  }
  /// Tries the direction perpendicular to two edges: to the longer, then to the component of the shorter across it.
  void try_across(const Vec3& e, const Vec3& f) {
    const bool longer = e.squaredNorm() > f.squaredNorm();
    try_across(Height(longer ? e : f, longer ? f : e), Mat3::Identity());
  }
  void try_across(const Height& h, const Mat3& turn) {
    if (!(h.height.squaredNorm() > tolerance::parallel_edges2 * h.side.squaredNorm())) return;
    const Vec3 n = turn * h.side.cross(h.height);
    try_direction(n);
    try_direction(-n);
  }
  void try_beside(const Vec3& between, const Vec3& edge) {
    const double length2 = edge.squaredNorm();
    if (!(length2 > 0)) return;
    Vec3 n = between - (between.dot(edge) / length2) * edge;
    n -= (n.dot(edge) / length2) * edge;  // a second pass removes what rounding left
    try_direction(n);
  }
  void try_direction(const Vec3& direction) {
    const double length = direction.norm();
    if (!(length > 0)) return;
    const Vec3 n = unit(direction, length);
    // The selected corners give an upper bound.
    const double t = n.dot(d_.pose.translation);
    double a = -infinity;
    for (int i = 0; i < a_.count; ++i) a = std::max(a, n.dot(a_.at[i]));
    for (int i = 0; i < b_.count; ++i)
      if (!(n.dot(b_.at[i]) + t - a > *best_)) return;
    const double separation = separation_along(d_, n);
    if (separation > *best_) *best_ = separation, *n_ = n;
  }

  const MinkowskiDifference& d_;
  CornerSet a_, b_;  ///< in A's frame, relative to each origin
  CornerSet own_b_;  ///< B's in its own frame
  double* best_ = nullptr;
  Vec3* n_ = nullptr;
};

}  // namespace

double separation_along(const MinkowskiDifference& d, const Vec3& n) { return -n.dot(d.support(n).w); }

bool settle_by_features(const MinkowskiDifference& d, LocalAnswer& answer) {
  constexpr double near = tolerance::near_features;
  const double scale = d.scale(), rounding = 4 * epsilon * scale, claimed = answer.signed_distance;
  double best = separation_along(d, answer.normal);
  // The distance of two points that a direction separates as far is right: others separate farther by rounding alone.
  if (claimed > 0 && std::abs(best - claimed) <= rounding) return false;
  Vec3 n = answer.normal;
  for (int round = 0; round < 3; ++round) {
    const double before = best;
    const double band = std::max(near * scale, 4 * std::abs(claimed - best));
    Features(d, n, near * scale, band).search(best, n);
    if (!(best > before + rounding)) break;
  }
  if (std::abs(best - claimed) <= rounding && n == answer.normal) return false;
  answer.signed_distance = best;
  answer.normal = n;
  answer.gap = std::max(0.0, claimed + (claimed < 0 ? answer.gap : 0) - best);
  pair_points(d, answer);
  return true;
}

}  // namespace tandem
