// The signed distance of a triangle and a box or triangle, by separating axes and nearest edges.
#include "triangles/triangle_distance.h"

#include <bit>

#include "shapes/cyclic.h"
#include "tolerances.h"
#include "triangles/triangle_kernel.h"

namespace tandem {
namespace {

/// Up to four corners in order: a point, an edge or a face.
struct CornerLoop {
  Vec3 corner[4];
  int count = 0;
};

/// A triangle in A's frame.
struct TriangleSides {
  Vec3 corner[3];
  Vec3 edge[3];  ///< from its corner to the next
  double length2[3];
  Vec3 normal;  ///< unit
  double area2;
  TriangleColumns rows;

  /// False if the area is almost zero.
  bool measure(std::span<const Vec3> v) {
    if (v.size() != 3) return false;
    for (int i = 0; i < 3; ++i) {
      corner[i] = v[static_cast<std::size_t>(i)];
      edge[i] = v[static_cast<std::size_t>(next_of_three[i])] - v[static_cast<std::size_t>(i)];
      length2[i] = edge[i].squaredNorm();
    }
    int i = 2;
    Vec3 n = edge[0].cross(edge[1]);
    double n2 = n.squaredNorm();
    if (!(n2 > tolerance::clearly_crossing2 * length2[0] * length2[1])) {
      // The two shorter sides give the most exact normal.
      i = length2[0] > length2[1] ? 0 : 1;
      if (length2[2] > length2[i]) i = 2;
      n = edge[next_of_three[i]].cross(edge[last_of_three[i]]);
      n2 = n.squaredNorm();
    }
    const double longest = std::max({length2[0], length2[1], length2[2]});
    if (!(longest < 1e60 && n2 > tolerance::slanting2 * length2[next_of_three[i]] * length2[last_of_three[i]] &&
          n2 > tolerance::least_area2))
      return false;
    area2 = std::sqrt(n2);
    normal = n / area2;
    return true;
  }

  void turn(const RelativePose& pose) {
    corner[0] = pose.rotation * corner[0] + pose.translation;
    for (Vec3& e : edge) e = pose.rotation * e;
    normal = pose.rotation * normal;
  }

  /// Computes the other corners from the first and the rotated edges: the rounding of rotated corners would matter for
  /// a thin triangle.
  void place(const Vec3& first) {
    corner[0] = first;
    corner[1] = first + edge[0];
    corner[2] = first - edge[2];
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 4; ++j) rows.corner[k][j] = corner[j % 3][k], rows.edge[k][j] = edge[j % 3][k];
      rows.area[k] = area2 * normal[k];
    }
    for (int j = 0; j < 4; ++j) rows.length2[j] = length2[j % 3];
  }

  double reach(const Vec3& n) const { return std::max({n.dot(corner[0]), n.dot(corner[1]), n.dot(corner[2])}); }

  const Vec3& farthest(const Vec3& n) const {
    const double x = n.dot(corner[0]), y = n.dot(corner[1]), z = n.dot(corner[2]);
    const int k = y > x ? 1 : 0;
    return corner[z > std::max(x, y) ? 2 : k];
  }

  /// True if the point lies over its face.
  bool below(const Vec3& p, const Vec3& /*normal*/) const {
    double least = infinity;
    for (int i = 0; i < 3; ++i) least = std::min(least, normal.cross(edge[i]).dot(p - corner[i]));
    return least >= 0;
  }

  CornerLoop side(int i, const Vec3& /*normal*/) const { return {{corner[i], corner[next_of_three[i]]}, 2}; }

  CornerLoop deepest(const Vec3& n, double slack) const {
    const double along[3] = {n.dot(corner[0]), n.dot(corner[1]), n.dot(corner[2])};
    const double most = std::max({along[0], along[1], along[2]}) - slack;
    CornerLoop f;
    for (int i = 0; i < 3; ++i)
      if (along[i] >= most) f.corner[f.count++] = corner[i];
    return f;
  }
};

struct BoxSides {
  Vec3 half;

  double reach(const Vec3& n) const { return n.cwiseAbs().dot(half); }

  Vec3 farthest(const Vec3& n) const {
    return {std::copysign(half[0], n[0]), std::copysign(half[1], n[1]), std::copysign(half[2], n[2])};
  }

  /// True if the point lies over the face with the normal n.
  bool below(const Vec3& p, const Vec3& n) const {
    const Vec3 over = p.cwiseAbs() - half;
    bool yes = true;
    for (int k = 0; k < 3; ++k) yes = yes && (over[k] <= 0 || n[k] != 0);
    return yes;
  }

  /// The edge along axis i that is farthest along n.
  CornerLoop side(int i, const Vec3& n) const {
    CornerLoop f{{farthest(n), farthest(n)}, 2};
    f.corner[0][i] = -half[i];
    f.corner[1][i] = half[i];
    return f;
  }

  CornerLoop deepest(const Vec3& n, double slack) const {
    Vec3 p;
    int level_axis[3], levels = 0;
    for (int k = 0; k < 3; ++k) {
      p[k] = std::copysign(half[k], n[k]);
      if (2 * half[k] * std::abs(n[k]) <= slack) level_axis[levels++] = k;
    }
    CornerLoop f;
    f.corner[f.count++] = p;
    for (int i = 0; i < std::min(levels, 2); ++i) {
      const int k = level_axis[i];
      p[k] = -p[k];
      f.corner[f.count++] = p;
    }
    if (levels >= 2) {
      p[level_axis[0]] = -p[level_axis[0]];
      f.corner[f.count++] = p;
    }
    return f;
  }
};

/// The direction of largest separation from A to B, and the features it is perpendicular to.
struct TriangleAxis {
  double distance;
  Vec3 normal;
  enum class Of : std::uint8_t { face_of_a, face_of_b, edges } of;
  int i = 0, j = 0;             ///< for edges: the edge of A and that of B
  double doubtful = -infinity;  ///< upper bound on the separation along axes that are inexact
};

/// True if a point that is outside of no side by more than the slack lies over the face, or about as near to it: beyond
/// the tip of a sliver, the strips along its two long sides overlap much farther out.
bool near_face(const Vec3& point, const CornerLoop& face, const Vec3 (&side)[4], const Vec3& n, double slack) {
  bool inside = true;
  double least2 = infinity;
  for (int i = 0; i < face.count; ++i) {
    const Vec3 along = face.corner[(i + 1) % face.count] - face.corner[i], w = point - face.corner[i];
    inside = inside && side[i].dot(w) >= 0;
    const Vec3 off = w - std::clamp(w.dot(along) / along.squaredNorm(), 0.0, 1.0) * along;
    least2 = std::min(least2, (off - off.dot(n) * n).squaredNorm());
  }
  return inside || least2 <= 4 * slack * slack;
}

/// Finds a point of `points` that lies over `face` (3 corners or more), seen along n.
bool over(const CornerLoop& points, const CornerLoop& face, const Vec3& n, double slack, Vec3& point) {
  // A face smaller than the slack may be seen edge-on: it bounds nothing then.
  const Vec3 own = (face.corner[1] - face.corner[0]).cross(face.corner[2] - face.corner[1]);
  if (!(std::abs(own.dot(n)) > 0.5 * own.norm())) return false;
  Vec3 side[4];
  double offset[4];
  for (int i = 0; i < face.count; ++i) {
    const Vec3& from = face.corner[i];
    const Vec3 along = face.corner[(i + 1) % face.count] - from;
    side[i] = n.cross(along);
    if (side[i].dot(face.corner[(i + 2) % face.count] - from) < 0) side[i] = -side[i];
    offset[i] = side[i].dot(from) - slack * side[i].norm();
  }
  const int edges = points.count == 2 ? 1 : points.count;
  for (int k = 0; k < edges; ++k) {
    const Vec3 &from = points.corner[k], along = points.corner[(k + 1) % points.count] - from;
    double lo = 0, hi = points.count == 1 ? 0 : 1;
    for (int i = 0; i < face.count && lo <= hi; ++i) {
      const double at = side[i].dot(from) - offset[i], slope = side[i].dot(along);
      if (at + lo * slope >= 0 && at + hi * slope >= 0) continue;
      const double t = -at / slope;
      if (slope > 0)
        lo = std::max(lo, t);
      else if (slope < 0)
        hi = std::min(hi, t);
      else
        hi = -1;
    }
    if (!(lo <= hi)) continue;
    point = from + 0.5 * (lo + hi) * along;
    if (near_face(point, face, side, n, slack)) return true;
  }
  return false;
}

/// The points where two edges pass each other, one shifted by `between`.
bool crossing(const CornerLoop& p, const CornerLoop& q, const Vec3& n, const Vec3& between, double slack, Vec3& point) {
  const Vec3 e = p.corner[1] - p.corner[0], f = q.corner[1] - q.corner[0], w = q.corner[0] - p.corner[0];
  const Vec3 across_e = n.cross(e), across_f = n.cross(f);
  const double by_det = 1 / e.dot(across_f);
  const double s = w.dot(across_f) * by_det, t = w.dot(across_e) * by_det;
  const double at_p = std::clamp(s, 0.0, 1.0), at_q = std::clamp(t, 0.0, 1.0);
  point = p.corner[0] + at_p * e;
  // On nearly parallel edges rounding moves the points far along both: together, or the result is invalid.
  const Vec3 off = w + at_q * f - at_p * e - between;
  return off.squaredNorm() <= slack * slack;
}

/// Points opposite each other along the axis, on the deepest features of either.
template <class A>
bool witness(const A& a, const TriangleSides& b, const TriangleAxis& axis, double slack, LocalAnswer& answer) {
  const Vec3 &n = axis.normal, between = axis.distance * n;
  const auto from_a = [&](const Vec3& p) {
    answer.point_a = p;
    answer.point_b = p + between;
    return true;
  };
  const auto from_b = [&](const Vec3& p) {
    answer.point_b = p;
    answer.point_a = p - between;
    return true;
  };
  Vec3 point;
  switch (axis.of) {
    case TriangleAxis::Of::face_of_a:
      point = b.farthest(-n);
      if (a.below(point, n)) return from_b(point);
      break;
    case TriangleAxis::Of::face_of_b:
      point = a.farthest(n);
      if (b.below(point, n)) return from_a(point);
      break;
    case TriangleAxis::Of::edges:
      if (crossing(a.side(axis.i, n), b.side(axis.j, n), n, between, slack, point)) return from_a(point);
  }
  // Other corners may be as deep: edges or faces that lie in each other's plane.
  const CornerLoop p = a.deepest(n, slack), q = b.deepest(-n, slack);
  if (p.count >= 3 && over(q, p, n, slack, point)) return from_b(point);
  if (q.count >= 3 && over(p, q, n, slack, point)) return from_a(point);
  return p.count == 2 && q.count == 2 && crossing(p, q, n, between, slack, point) && from_a(point);
}

/// The index of the entry equal to `value`, the first if there are several; the fourth of each row does not count.
template <std::size_t n>
int index_of(double value, const double* rows) {
  unsigned bits = 0;
  for (std::size_t k = 0; k < n; ++k) bits |= (rows[k] == value ? 1u : 0u) << k;
  return std::countr_zero(bits & 0x77777777u);
}
double most_of(const double (&x)[3][4]) {
  return std::max({std::max({x[0][0], x[0][1], x[0][2]}), std::max({x[1][0], x[1][1], x[1][2]}),
                   std::max({x[2][0], x[2][1], x[2][2]})});
}
double least_of(const double (&x)[3][4]) {
  return std::min({std::min({x[0][0], x[0][1], x[0][2]}), std::min({x[1][0], x[1][1], x[1][2]}),
                   std::min({x[2][0], x[2][1], x[2][2]})});
}

/// The vector from A to B between the nearest of their corners and edges, and its start on A.
struct FromEdge {
  Vec3 from, d;
};

/// p - (q + t e) for the t on the edge where that is shortest.
Vec3 offset_from_edge(const Vec3& p, const Vec3& q, const Vec3& e, double length2) {
  const Vec3 w = p - q;
  const double t = w.dot(e) / length2;
  if (!(t > 0)) return w;
  if (t >= 1) return w - e;
  const Vec3 d = w - t * e;
  return d - (d.dot(e) / length2) * e;  // removes what rounding left along the edge
}

FromEdge nearest_edges(const TriangleSides& a, const TriangleSides& b) {
  CornerOffsets offsets;
  corner_offsets(a.rows, b.rows, offsets);
  const double from_a = least_of(offsets.from_a), from_b = least_of(offsets.from_b);
  if (from_a <= from_b) {
    const int k = index_of<12>(from_a, offsets.from_a[0]), i = k / 4, j = k % 4;
    return {a.corner[i], -offset_from_edge(a.corner[i], b.corner[j], b.edge[j], b.length2[j])};
  }
  const int k = index_of<12>(from_b, offsets.from_b[0]), i = k / 4, j = k % 4;
  const Vec3 d = offset_from_edge(b.corner[j], a.corner[i], a.edge[i], a.length2[i]);
  return {b.corner[j] - d, d};
}

FromEdge nearest_edges(const BoxSides& a, const TriangleSides& b) {
  EdgeOffsets offsets;
  edge_offsets({a.half[0], a.half[1], a.half[2]}, b.rows, offsets);
  const int j = index_of<3>(std::min({offsets.squared[0], offsets.squared[1], offsets.squared[2]}), offsets.squared);
  const double t = offsets.at[j];
  const Vec3 p = t == 1 ? b.corner[next_of_three[j]] : Vec3(b.corner[j] + t * b.edge[j]);
  const Vec3 from = p.cwiseMax(-a.half).cwiseMin(a.half);
  Vec3 d = p - from;
  if (t > 0 && t < 1) d -= (d.dot(b.edge[j]) / b.length2[j]) * b.edge[j];
  return {from, d};
}

/// The gap between the projections of two shapes on a line, and whether B lies farther along it (1) or A (-1).
struct AxisGap {
  double distance, sign;
  AxisGap(double lo_a, double hi_a, double lo_b, double hi_b)
      : distance(std::max(lo_b - hi_a, lo_a - hi_b)), sign(lo_b - hi_a >= lo_a - hi_b ? 1.0 : -1.0) {}
};

template <class A>
AxisGap gap_along(const A& a, const TriangleSides& b, const Vec3& n) {
  return {-a.reach(-n), a.reach(n), -b.reach(-n), b.reach(n)};
}

/// The best of the edge axes, whose separations the kernel has computed. `reach`: of the shapes from the origin.
template <class A, class Product>
void take_products(const A& a, const TriangleSides& b, const EdgeProducts& products, double reach, TriangleAxis& axis,
                   const Product& product) {
  for (unsigned left = products.doubtful & 0x777u; left != 0; left &= left - 1) {
    const int k = std::countr_zero(left);
    double e2f2;
    const Vec3 n = product(k / 4, k % 4, e2f2);
    const double length2 = n.squaredNorm();
    if (!(length2 > tolerance::parallel_sides2 * e2f2)) continue;
    const double distance = gap_along(a, b, n / std::sqrt(length2)).distance;
    axis.doubtful = std::max(axis.doubtful, distance + 16 * epsilon * reach * std::sqrt(e2f2 / length2));
  }
  // An edge axis that coincides with a face normal must not win by its rounding.
  const double most = most_of(products.separation);
  if (!(most > axis.distance + 4 * epsilon * reach)) return;
  const int k = index_of<12>(most, products.separation[0]);
  double e2f2;
  Vec3 n = product(k / 4, k % 4, e2f2);
  n /= n.norm();
  const AxisGap along = gap_along(a, b, n);
  if (!(along.distance > axis.distance)) return;
  axis.distance = along.distance;
  axis.normal = along.sign * n;
  axis.of = TriangleAxis::Of::edges;
  axis.i = k / 4, axis.j = k % 4;
}

TriangleAxis best_axis(const BoxSides& a, const TriangleSides& b, double reach, double beyond) {
  double of_box[8] = {};
  for (int k = 0; k < 3; ++k) {
    of_box[k] = std::min({b.corner[0][k], b.corner[1][k], b.corner[2][k]}) - a.half[k];
    of_box[4 + k] = -std::max({b.corner[0][k], b.corner[1][k], b.corner[2][k]}) - a.half[k];
  }
  TriangleAxis axis;
  axis.of = TriangleAxis::Of::face_of_a;
  axis.distance = std::max(std::max({of_box[0], of_box[1], of_box[2]}), std::max({of_box[4], of_box[5], of_box[6]}));
  const int face = index_of<8>(axis.distance, of_box);
  axis.normal.setZero();
  axis.normal[face % 4] = face < 4 ? 1.0 : -1.0;
  if (axis.distance > beyond) return axis;
  const double at = b.normal.dot(b.corner[0]), of_triangle = std::abs(at) - a.reach(b.normal);
  if (of_triangle > axis.distance) {
    axis.distance = of_triangle;
    axis.normal = std::copysign(1.0, at) * b.normal;
    axis.of = TriangleAxis::Of::face_of_b;
    if (axis.distance > beyond) return axis;
  }
  EdgeProducts products;
  box_triangle_products({a.half[0], a.half[1], a.half[2]}, b.rows, products);
  take_products(a, b, products, reach, axis, [&](int i, int j, double& e2f2) {
    e2f2 = b.length2[j];
    return Vec3(Vec3::Unit(i).cross(b.edge[j]));
  });
  return axis;
}

TriangleAxis best_axis(const TriangleSides& a, const TriangleSides& b, double reach, double beyond) {
  const auto apart = [](const TriangleSides& flat, const TriangleSides& other) {
    double along[3];
    for (int k = 0; k < 3; ++k) along[k] = flat.normal.dot(other.corner[k] - flat.corner[0]);
    return AxisGap(0, 0, std::min({along[0], along[1], along[2]}), std::max({along[0], along[1], along[2]}));
  };
  const AxisGap of_a = apart(a, b), of_b = apart(b, a);
  const bool second = of_b.distance > of_a.distance;
  TriangleAxis axis;
  axis.distance = second ? of_b.distance : of_a.distance;
  axis.normal = (second ? -of_b.sign : of_a.sign) * (second ? b.normal : a.normal);
  axis.of = second ? TriangleAxis::Of::face_of_b : TriangleAxis::Of::face_of_a;
  if (axis.distance > beyond) return axis;
  EdgeProducts products;
  triangle_products(a.rows, b.rows, products);
  take_products(a, b, products, reach, axis, [&](int i, int j, double& e2f2) {
    e2f2 = a.length2[i] * b.length2[j];
    return Vec3(a.edge[i].cross(b.edge[j]));
  });
  return axis;
}

template <class A>
bool solve(const A& a, const TriangleSides& b, const MinkowskiDifference& d, double beyond, LocalAnswer& answer) {
  const double size = d.a.size + d.b.size;
  const double reach = size + b.corner[0].norm();
  if (!(reach < 1e60)) return false;  // squares overflow
  const TriangleAxis axis = best_axis(a, b, reach, beyond);
  answer.signed_distance = axis.distance;
  answer.normal = axis.normal;
  if (axis.distance > beyond) return true;
  if (!(axis.doubtful > axis.distance) && witness(a, b, axis, tolerance::over_face * size, answer)) return true;
  if (!(axis.distance > 0)) return false;
  const FromEdge nearest = nearest_edges(a, b);
  const double length = nearest.d.norm();
  if (!(length > 0)) return false;
  answer.signed_distance = length;
  answer.normal = nearest.d / length;
  answer.point_a = nearest.from;
  answer.point_b = nearest.from + nearest.d;
  const double along = -b.reach(-answer.normal) - a.reach(answer.normal);
  return length - along <= tolerance::same_distance * length + 4 * epsilon * reach;
}

}  // namespace

std::optional<LocalAnswer> triangle_distance(const MinkowskiDifference& d, double beyond) {
  TriangleSides b;
  if (!b.measure(d.b.vertices)) return std::nullopt;
  b.turn(d.pose);
  LocalAnswer answer;
  if (d.a.kind == ShapeKind::box) {
    b.place(b.corner[0]);
    const BoxSides a{{d.a.param[0], d.a.param[1], d.a.param[2]}};
    if (!solve(a, b, d, beyond, answer)) return std::nullopt;
    return answer;
  }
  TriangleSides a;
  if (!a.measure(d.a.vertices)) return std::nullopt;
  // Relative to A's first corner: nothing is lost however far its origin lies.
  const Vec3 origin = a.corner[0];
  a.place(Vec3::Zero());
  b.place(b.corner[0] - origin);
  if (!solve(a, b, d, beyond, answer)) return std::nullopt;
  answer.point_a += origin;
  answer.point_b += origin;
  return answer;
}

}  // namespace tandem
