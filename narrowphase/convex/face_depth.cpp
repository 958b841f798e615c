// The depth of two small polytopes by the faces of their difference A - B.
#include "convex/face_depth.h"

#include <array>
#include <cmath>
#include <span>

#include "convex/face_heights.h"
#include "convex/gjk.h"
#include "lanes/fetch_ahead.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// A small polytope in single precision relative to a point of it, lengths in a unit near its size.
class SmallPolytope {
 public:
  explicit SmallPolytope(const ConvexView& v) {
    if (v.kind == ShapeKind::box) {
      box(v.param);
    } else if (v.hull != nullptr && v.hull->face_table.faces > 0) {
      const Hull& hull = *v.hull;
      planes_ = {hull.face_table.planes.data(), hull.face_table.faces, hull.face_table.stride(), 1};
      arcs = hull.face_table.arcs;
      middle = hull.support.middle();
      unit = hull.support.unit();
      hull_ = &hull;
    }
  }
  SmallPolytope(const SmallPolytope&) = delete;
  SmallPolytope& operator=(const SmallPolytope&) = delete;

  bool known() const { return planes_.faces > 0; }
  std::size_t faces() const { return planes_.faces; }
  /// Prefetches all data of a search.
  [[gnu::always_inline]] void fetch() const {
    if (hull_ == nullptr) return;
    constexpr std::size_t block = SupportMap::block;
    fetch_ahead(std::span(hull_->face_table.planes));
    fetch_ahead(std::span(hull_->support.blocks(), (hull_->vertices.size() + block - 1) / block));
    fetch_ahead(arcs);
    fetch_ahead(std::span(hull_->vertices));
  }
  /// The planes, with offsets in the given unit.
  FacePlanes planes(double in) const {
    FacePlanes p = planes_;
    p.unit = static_cast<float>(unit / in);
    return p;
  }
  Vec3 normal(std::size_t face) const {
    if (hull_ != nullptr) return hull_->faces[face].normal;
    Vec3 n = Vec3::Zero();
    n[static_cast<int>(face / 2)] = face % 2 != 0 ? -1.0 : 1.0;
    return n;
  }
  /// True if a point of the face's plane is on the face, to within the slack.
  bool holds(std::size_t face, const Vec3& p, double slack) const {
    if (hull_ == nullptr) {
      for (int k = 0; k < 3; ++k)
        if (std::abs(p[k]) > half_[static_cast<std::size_t>(k)] + slack) return false;
      return true;
    }
    const Hull::Face& f = hull_->faces[face];
    const std::uint32_t* const loop = &hull_->loop[f.first];
    for (std::uint32_t k = 0; k < f.count; ++k) {
      const Vec3 &a = hull_->vertices[loop[k]], &b = hull_->vertices[loop[k + 1 < f.count ? k + 1 : 0]];
      const Vec3 out = (b - a).cross(f.normal);
      if (out.dot(p - a) > slack * out.norm()) return false;
    }
    return true;
  }
  /// The vertices relative to the middle, in the given unit.
  void vertices(double in, SmallVertices& out) const {
    const auto scale = static_cast<float>(unit / in);
    if (hull_ == nullptr) {
      for (std::uint32_t i = 0; i < 8; ++i) {
        const auto at = [&](std::uint32_t k) {
          const double h = half_[k] / in;
          return static_cast<float>(i >> k & 1u ? -h : h);
        };
        out.x[i] = at(0), out.y[i] = at(1), out.z[i] = at(2);
      }
      out.count = 8;
      return;
    }
    out.count = hull_->vertices.size();
    const SupportMap::Block* b = hull_->support.blocks();
    for (std::size_t i = 0; i < out.count; i += SupportMap::block, ++b)
      for (std::size_t l = 0; l < SupportMap::block; ++l) {
        out.x[i + l] = scale * b->x[l];
        out.y[i + l] = scale * b->y[l];
        out.z[i + l] = scale * b->z[l];
      }
  }

  std::span<const FaceArc> arcs;
  Vec3 middle = Vec3::Zero();
  double unit = 1;

 private:
  void box(const std::array<double, 4>& half) {
    half_ = half;
    unit = std::ldexp(1.0, std::ilogb(std::max({half[0], half[1], half[2]})));
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t s = 0; s < 2; ++s) {
        box_planes_[k * FaceTable::step + 2 * k + s] = s != 0 ? -1.0f : 1.0f;
        box_planes_[3 * FaceTable::step + 2 * k + s] = static_cast<float>(half[k] / unit);
      }
    planes_ = {box_planes_.data(), 6, FaceTable::step, 1};
    arcs = box_arcs;
  }
  FacePlanes planes_;
  const Hull* hull_ = nullptr;
  std::array<double, 4> half_{};
  std::array<float, 4 * FaceTable::step> box_planes_{};
};

/// One shape of the difference A - B in A's frame: B's vertices and normals are negated.
struct Side {
  const ConvexView& view;
  const SmallPolytope& small;
  const RelativePose& pose;
  bool of_b;

  Vec3 turned(const Vec3& v) const { return of_b ? Vec3(-(pose.rotation * v)) : v; }
  Vec3 vertex(std::uint32_t i) const {
    const Vec3 v = core_vertex(view, i);
    return of_b ? Vec3(-(pose.rotation * v) - pose.translation) : v;
  }
  /// The vector between two vertices, exact relative to the edge's own length.
  Vec3 edge(std::uint32_t i, std::uint32_t j) const { return turned(core_vertex(view, j) - core_vertex(view, i)); }
  Vec3 normal(std::size_t face) const { return turned(small.normal(face)); }
  std::uint32_t number(const MinkowskiPoint& p) const { return of_b ? p.vertex_b : p.vertex_a; }
};

class FaceSearch {
 public:
  FaceSearch(const MinkowskiDifference& d, const SmallPolytope& a, const SmallPolytope& b)
      : d_(d),
        a_{d.a, a, d.pose, false},
        b_{d.b, b, d.pose, true},
        unit_(std::max(a.unit, b.unit)),
        rounding_(4 * epsilon * d.scale()) {}

  bool run(LocalAnswer& answer) {
    const Mat3& r = d_.pose.rotation;
    const Vec3 between = (r * b_.small.middle + d_.pose.translation - a_.small.middle) / unit_;
    const double reach = (d_.a.size + d_.b.size) / unit_ + between.norm();
    if (!(reach < 1e3)) return false;
    // The error of a height: twice the precision of the 16-bit numbers, and rounding.
    slack_ = static_cast<float>(tolerance::height_of_shorts * reach);
    a_.small.vertices(unit_, own_a_);
    b_.small.vertices(unit_, own_b_);
    measure(a_.small, own_b_, Mat3(-r), -between, b_in_a_, over_a_);
    measure(b_.small, own_a_, Mat3(-r.transpose()), r.transpose() * between, a_in_b_, over_b_);
    const float least = std::min(over_a_.least, over_b_.least);
    if (!try_faces(a_, b_, over_a_, least) || !try_faces(b_, a_, over_b_, least)) return false;
    const bool by_a = a_.small.arcs.size() <= b_.small.arcs.size();
    if (!(by_a ? follow_arcs(a_, b_, b_in_a_, over_a_) : follow_arcs(b_, a_, a_in_b_, over_b_))) return false;
    // The search is valid only if the origin lies inside, which is then certain.
    if (!(best_ > tolerance::near_surface * d_.scale())) return false;
    answer.signed_distance = -best_;
    answer.normal = normal_;
    answer.gap = 0;
    if (!witness(answer)) pair_points(d_, answer);
    return true;
  }

 private:
  /// The heights over the faces of one shape, in its frame about its middle.
  void measure(const SmallPolytope& faces, const SmallVertices& other, const Mat3& turn, const Vec3& shift,
               SmallVertices& placed, FaceHeights& out) const {
    float m[9], s[3];
    for (int i = 0; i < 3; ++i) {
      s[i] = static_cast<float>(shift[i]);
      for (int j = 0; j < 3; ++j) m[3 * i + j] = static_cast<float>(turn(i, j));
    }
    height_kernel()(faces.planes(unit_), other, m, s, placed, out);
  }
  /// Computes in double the supports along faces that may be the nearest to the origin. False if these are too many.
  bool try_faces(const Side& side, const Side& other, FaceHeights& heights, float least) {
    for (std::size_t i = 0; i < side.small.faces(); ++i) {
      if (heights.at[i] > least + 2 * slack_) continue;
      if (++steps_ > most_steps) return false;
      const Vec3 n = side.normal(i);
      const MinkowskiPoint p = d_.support(n);
      const double h = n.dot(p.w);
      heights.vertex[i] = static_cast<std::int32_t>(other.number(p));
      if (h < best_) {
        best_ = h;
        normal_ = n;
        point_ = p;
        face_ = i;
        face_of_b_ = side.of_b;
        edges_ = false;
      }
    }
    return true;
  }

  /// Follows the arcs of one shape on which the other's support changes: edge-edge normals. False after too many steps.
  bool follow_arcs(const Side& side, const Side& other, const SmallVertices& placed, const FaceHeights& heights) {
    std::array<std::uint8_t, 3 * FaceTable::most_faces> open;
    std::size_t count = 0;
    for (std::size_t i = 0; i < side.small.arcs.size(); ++i) {
      const FaceArc& arc = side.small.arcs[i];
      open[count] = static_cast<std::uint8_t>(i);
      count += heights.vertex[arc.face[0]] != heights.vertex[arc.face[1]] ? 1 : 0;
    }
    const FacePlanes planes = side.small.planes(unit_);
    const auto along = [&](std::size_t face, std::size_t vertex) {
      const float* const n = planes.planes + face;
      return planes.unit * n[3 * planes.stride] + n[0] * placed.x[vertex] + n[planes.stride] * placed.y[vertex] +
             n[2 * planes.stride] * placed.z[vertex];
    };
    for (std::size_t k = 0; k < count; ++k) {
      const FaceArc& arc = side.small.arcs[open[k]];
      const std::size_t f = arc.face[0], g = arc.face[1];
      const auto from = static_cast<std::size_t>(heights.vertex[f]), to = static_cast<std::size_t>(heights.vertex[g]);
      // Along the arc the support of the difference is at least that of the vertices at the arc's ends. Each of these
      // is concave, so the larger of the two is least at an end or where both are equal, in the direction p n_f + q
      // n_g. Nearby, however p and q are rounded, one of them is at least that large.
      const float height_f = heights.at[f], height_g = heights.at[g], from_at_g = along(g, from);
      const float p = std::max(0.0f, height_g - from_at_g), q = std::max(0.0f, height_f - along(f, to));
      const float* const n = planes.planes;
      const float cosine = n[f] * n[g] + n[planes.stride + f] * n[planes.stride + g] +
                           n[2 * planes.stride + f] * n[2 * planes.stride + g];
      const float length2 = p * p + q * q + 2 * p * q * cosine;
      const float level = p * height_f + q * from_at_g;
      const float limit = static_cast<float>(best_ / unit_) + 4 * slack_;
      if (length2 > 0.125f * (p + q) * (p + q) && level > 0 && level * level > limit * limit * length2) continue;
      if (!follow(side, other, arc, static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to))) return false;
    }
    return true;
  }

  bool follow(const Side& side, const Side& other, const FaceArc& arc, std::uint32_t first, std::uint32_t last) {
    const Vec3 mid = side.normal(arc.face[0]) + side.normal(arc.face[1]);
    const Vec3 corner = side.vertex(arc.v[0]), edge = side.edge(arc.v[0], arc.v[1]);
    struct Interval {
      std::uint32_t from, to;  // vertices of the other shape
    };
    std::array<Interval, 64> open;
    std::size_t count = 0;
    open[count++] = {first, last};
    while (count > 0) {
      const Interval interval = open[--count];
      if (interval.from == interval.to) continue;
      const Vec3 across = other.edge(interval.to, interval.from);
      Vec3 m = edge.cross(across);
      const double length2 = m.squaredNorm();
      if (!(length2 > tolerance::parallel_edges2 * edge.squaredNorm() * across.squaredNorm()))
        continue;  // parallel edges: equal along the whole arc
      m /= m.dot(mid) < 0 ? -std::sqrt(length2) : std::sqrt(length2);
      const double level = m.dot(corner + other.vertex(interval.from));
      if (level >= best_ - rounding_) continue;
      const MinkowskiPoint p = d_.support(m);
      const double h = m.dot(p.w);
      if (h < best_ - rounding_) {
        best_ = h;
        normal_ = m;
        edges_ = true;
        const bool b = side.of_b;
        ends_a_[0] = b ? interval.from : arc.v[0], ends_a_[1] = b ? interval.to : arc.v[1];
        ends_b_[0] = b ? arc.v[0] : interval.from, ends_b_[1] = b ? arc.v[1] : interval.to;
      }
      const std::uint32_t between = other.number(p);
      if (h - level <= rounding_ || between == interval.from || between == interval.to) continue;
      if (count + 2 > open.size() || ++steps_ > most_steps) return false;
      open[count++] = {interval.from, between};
      open[count++] = {between, interval.to};
    }
    return true;
  }

  /// The points that touch once B has been moved out.
  bool witness(LocalAnswer& answer) const {
    const double slack = tolerance::on_feature * d_.scale();
    if (edges_) {
      const Vec3 a = core_vertex(d_.a, ends_a_[0]), e = core_vertex(d_.a, ends_a_[1]) - a;
      const Vec3 b = d_.pose.rotation * core_vertex(d_.b, ends_b_[0]) + d_.pose.translation + best_ * normal_;
      const Vec3 f = d_.pose.rotation * (core_vertex(d_.b, ends_b_[1]) - core_vertex(d_.b, ends_b_[0]));
      const Vec3 n = e.cross(f), between = b - a;
      const double n2 = n.squaredNorm();
      const double s = between.cross(f).dot(n) / n2, t = between.cross(e).dot(n) / n2;
      if (!(s >= 0 && s <= 1 && t >= 0 && t <= 1)) return false;
      answer.point_a = a + s * e;
      answer.point_b = answer.point_a - best_ * normal_;
      return (b + t * f - answer.point_a).squaredNorm() <= slack * slack;
    }
    // A vertex of one shape, on the face of the other.
    if (face_of_b_) {
      answer.point_a = point_.a;
      answer.point_b = point_.a - best_ * normal_;
      return b_.small.holds(face_, d_.pose.rotation.transpose() * (answer.point_b - d_.pose.translation), slack);
    }
    answer.point_b = point_.a - point_.w;
    answer.point_a = answer.point_b + best_ * normal_;
    return a_.small.holds(face_, answer.point_a, slack);
  }

  static constexpr int most_steps = 256;

  const MinkowskiDifference& d_;
  Side a_, b_;
  double unit_, rounding_;
  float slack_ = 0;  ///< the error of a height
  SmallVertices own_a_, own_b_, b_in_a_, a_in_b_;
  FaceHeights over_a_, over_b_;
  double best_ = infinity;
  Vec3 normal_ = Vec3::UnitX();
  bool edges_ = false;
  MinkowskiPoint point_{};  ///< if the best normal is a face's: the point and the face
  std::size_t face_ = 0;
  bool face_of_b_ = false;
  std::array<std::uint32_t, 2> ends_a_{}, ends_b_{};  ///< if it is a cross product: the edges' ends
  int steps_ = 0;
};

}  // namespace

bool depth_by_faces(const MinkowskiDifference& d, LocalAnswer& answer) {
  const SmallPolytope a(d.a), b(d.b);
  if (!a.known() || !b.known()) return false;
  a.fetch();
  b.fetch();
  return FaceSearch(d, a, b).run(answer);
}

}  // namespace tandem
