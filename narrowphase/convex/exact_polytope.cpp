// The expanding polytope algorithm (van den Bergen 2001) in integers.
#include "convex/exact_polytope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "shapes/work_meter.h"
#include "tolerances.h"

namespace tandem {
namespace {

__extension__ using Int128 = __int128;

/// A coordinate on the grid, or a difference of two: at most `coordinate_bits` bits and two more.
using GridVector = std::array<std::int64_t, 3>;
constexpr int coordinate_bits = 58;

GridVector operator-(const GridVector& p, const GridVector& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }

/// The cross product of two differences; exact, in 121 bits.
struct GridNormal {
  std::array<Int128, 3> along{};

  GridNormal() = default;
  GridNormal(const GridVector& u, const GridVector& v) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      along[k] = Int128{u[i]} * v[j] - Int128{u[j]} * v[i];
    }
  }
  Vec3 direction() const {
    const Vec3 n(static_cast<double>(along[0]), static_cast<double>(along[1]), static_cast<double>(along[2]));
    return n.stableNormalized();
  }
  /// The sign of the dot product with a difference; exact: the products have up to 181 bits, so the normal is split.
  int side(const GridVector& v) const {
    constexpr int half = 60;
    constexpr Int128 low_bits = (Int128{1} << half) - 1;
    Int128 high = 0, low = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      high += (along[k] >> half) * v[k];
      low += (along[k] & low_bits) * v[k];
    }
    high += low >> half;
    if (high != 0) return high > 0 ? 1 : -1;
    return (low & low_bits) != 0 ? 1 : 0;
  }
};

struct GridPoint {
  GridVector at;
  MinkowskiPoint point;
};

class ExactPolytope {
 public:
  explicit ExactPolytope(const MinkowskiDifference& d)
      : d_(d), rounding_(8 * epsilon * d.scale()), to_grid_(coordinate_bits - 1 - std::ilogb(d.scale())) {}

  /// Begins with a tetrahedron; false for a difference without volume.
  bool begin();
  /// Expands until the nearest face is the difference's own; false after too many points.
  bool expand(EpaResult& r);

 private:
  static constexpr std::size_t most_points = 4096;

  struct Face {
    std::array<std::uint32_t, 3> corner;
    GridNormal exact;
    Vec3 normal;
    double offset;
    bool own = false;  ///< the difference has no point beyond it
  };

  GridPoint farthest(const Vec3& n) const {
    GridPoint p;
    p.point = d_.support(n);
    for (int k = 0; k < 3; ++k)
      p.at[static_cast<std::size_t>(k)] = std::llrint(std::ldexp(p.point.w[k], to_grid_));
    return p;
  }
  bool sees(const GridPoint& p, const Face& f) const {
    const double beyond = f.normal.dot(p.point.w) - f.offset;
    if (std::abs(beyond) > rounding_) return beyond > 0;
    return f.exact.side(p.at - points_[f.corner[0]].at) > 0;
  }
  void make_face(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void add(const GridPoint& p);
  void choose_points(EpaResult& r) const;

  const MinkowskiDifference& d_;
  double rounding_;  ///< an upper bound on the errors of offsets of faces
  int to_grid_;      ///< coordinates are multiples of 2^-to_grid_
  std::vector<GridPoint> points_;
  std::vector<Face> faces_;
  std::vector<std::array<std::uint32_t, 2>> horizon_;
};

void ExactPolytope::make_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const GridVector &p = points_[a].at, &q = points_[b].at, &r = points_[c].at;
  Face f{{a, b, c}, GridNormal(q - p, r - p), {}, 0};
  f.normal = f.exact.direction();
  f.offset = std::max({f.normal.dot(points_[a].point.w), f.normal.dot(points_[b].point.w),
                       f.normal.dot(points_[c].point.w)});
  faces_.push_back(f);
}

bool ExactPolytope::begin() {
  std::vector<GridPoint> found;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0}) found.push_back(farthest(sign * Vec3::Unit(k)));
  // The most distant from the first point, from the line through both, and from the plane through all three.
  const auto take = [&](const auto& distance) {
    const auto best = std::max_element(found.begin(), found.end(), [&](const GridPoint& p, const GridPoint& q) {
      return distance(p.point.w) < distance(q.point.w);
    });
    points_.push_back(*best);
  };
  const auto w = [&](std::size_t i) -> const Vec3& { return points_[i].point.w; };
  points_.push_back(found[0]);
  take([&](const Vec3& p) { return (p - w(0)).squaredNorm(); });
  const Vec3 line = (w(1) - w(0)).stableNormalized();
  const Vec3 beside = any_perpendicular(line);
  for (const Vec3& n : {beside, Vec3(line.cross(beside))})
    for (const double sign : {1.0, -1.0}) found.push_back(farthest(sign * n));
  take([&](const Vec3& p) { return line.cross(p - w(0)).squaredNorm(); });
  const GridNormal base(points_[1].at - points_[0].at, points_[2].at - points_[0].at);
  const Vec3 across = base.direction();
  for (const double sign : {1.0, -1.0}) found.push_back(farthest(sign * across));
  take([&](const Vec3& p) { return std::abs(across.dot(p - w(0))); });
  const int side = base.side(points_[3].at - points_[0].at);
  if (side == 0) return false;
  if (side > 0) std::swap(points_[1], points_[2]);
  make_face(0, 1, 2);
  make_face(1, 0, 3);
  make_face(2, 1, 3);
  make_face(0, 2, 3);
  return true;
}

/// Replaces the faces that the point is beyond by triangles to their outline.
void ExactPolytope::add(const GridPoint& p) {
  horizon_.clear();
  std::erase_if(faces_, [&](const Face& f) {
    if (!sees(p, f)) return false;
    for (std::size_t k = 0; k < 3; ++k) horizon_.push_back({f.corner[k], f.corner[(k + 1) % 3]});
    return true;
  });
  // Within the outline each edge is there in both directions.
  std::vector<std::array<std::uint32_t, 2>> sorted = horizon_;
  std::sort(sorted.begin(), sorted.end());
  const auto apex = static_cast<std::uint32_t>(points_.size());
  points_.push_back(p);
  for (const auto& [from, to] : horizon_)
    if (!std::binary_search(sorted.begin(), sorted.end(), std::array{to, from})) make_face(from, to, apex);
}

bool ExactPolytope::expand(EpaResult& r) {
  r.upper = infinity;
  WorkMeter meter(d_.limit, epa::a_hundred_points);
  double own = infinity;  // the least offset of the difference's own faces
  while (true) {
    meter.spend(epa::a_point);
    const auto nearest = std::min_element(faces_.begin(), faces_.end(), [](const Face& f, const Face& g) {
      return f.own != g.own ? g.own : f.offset < g.offset;
    });
    if (nearest->own || nearest->offset >= r.upper) break;
    const GridPoint p = farthest(nearest->normal);
    const double h = nearest->normal.dot(p.point.w);
    if (h < r.upper) r.upper = h, r.normal = nearest->normal;
    if (h - nearest->offset <= rounding_) {
      nearest->own = true;
      own = std::min(own, nearest->offset);
      continue;
    }
    if (points_.size() == most_points) return false;
    add(p);
  }
  r.lower = std::min(own, r.upper);
  choose_points(r);
  return true;
}

/// Of the triangles in the nearest face, the one that holds the origin's projection has the points.
void ExactPolytope::choose_points(EpaResult& r) const {
  // Of hulls far from their own origins, supports are less exact than offsets, and may be below them all.
  double lowest = infinity;
  for (const Face& f : faces_) lowest = std::min(lowest, f.offset);
  double least = infinity;
  for (const Face& f : faces_) {
    if (f.offset > std::max(lowest, r.upper) + rounding_) continue;
    EpaResult by = r;
    set_points(points_[f.corner[0]].point, points_[f.corner[1]].point, points_[f.corner[2]].point, by);
    const double aside = (by.point_a - by.point_b - r.upper * r.normal).squaredNorm();
    if (aside < least) least = aside, r = by;
  }
}

}  // namespace

bool expand_exactly(const MinkowskiDifference& d, EpaResult& result) {
  ExactPolytope polytope(d);
  EpaResult r;
  if (!polytope.begin() || !polytope.expand(r)) return false;
  result = r;
  return true;
}

}  // namespace tandem
