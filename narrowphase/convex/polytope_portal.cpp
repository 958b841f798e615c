// Minkowski portal refinement for two polytopes (Snethen, XenoCollide, Game Programming Gems 7, 2008), vector kernel.
#include "convex/polytope_portal.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "tolerances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "convex/polytope_portal.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "convex/core_search-inl.h"
#include "convex/portal_steps-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A point of the difference with the numbers of its vertices, A's in the upper half; or a point of one shape.
struct Corner {
  Point at;
  std::uint64_t id;

  HWY_INLINE Corner operator+(const Corner& c) const { return {at + c.at, id | c.id}; }
};

/// One shape: its initial corners, and the search for more.
class PortalSide {
 public:
  explicit PortalSide(const ConvexView& v) : view_(v), core_(v) {}

  bool usable() const { return view_.kind == ShapeKind::box || view_.vertices.size() == 3 || has_rays(); }
  /// Finds three corners near the point where the ray from the interior point leaves.
  HWY_INLINE void begin(const Point& ray, Corner (&out)[3]) const {
    if (view_.kind == ShapeKind::box) return begin_box(ray, out);
    RayMap::Corners corners{0, 1, 2};
    if (view_.vertices.size() > 3) corners = view_.hull->rays.corners(ray.x, ray.y, ray.z);
    for (std::size_t i = 0; i < 3; ++i) out[i] = {point(view_.vertices[corners[i]]), corners[i]};
  }
  HWY_INLINE Corner farthest(const Point& n, double length) const {
    Point p;
    std::uint32_t vertex;
    if (!core_.small_hull() || !core_.farthest_vertex(n, length, vertex, p)) vertex = core_.farthest(n, p);
    return {p, vertex};
  }

 private:
  bool has_rays() const { return view_.hull != nullptr && !view_.hull->rays.empty(); }
  HWY_INLINE void begin_box(const Point& ray, Corner (&out)[3]) const {
    const double x = std::abs(ray.x) / view_.param[0], y = std::abs(ray.y) / view_.param[1],
                 z = std::abs(ray.z) / view_.param[2];
    const std::uint32_t k = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
    // The corner of the face to which the ray leans, and its neighbours.
    const auto bit = [](double along, std::uint32_t i) { return std::signbit(along) ? 1u << i : 0u; };
    const std::uint32_t at = bit(ray.x, 0) | bit(ray.y, 1) | bit(ray.z, 2);
    constexpr std::uint32_t beside[3][2] = {{2, 4}, {4, 1}, {1, 2}};
    for (const auto& [i, number] : {std::pair(0, at), std::pair(1, at ^ beside[k][0]), std::pair(2, at ^ beside[k][1])})
      out[i] = {point(core_vertex(view_, number)), number};
  }
  const ConvexView& view_;
  Core core_;
};

using PortalFace = Portal<Corner>;

/// The triangle that `leave` found; `place` < 12: by an edge of each, 4 times A's plus B's (3: B's first); else by a
/// face.
HWY_INLINE PortalFace face_at(const Corner (&a)[3], const Corner (&b)[3], const Point& from, const Point& d,
                              std::uint64_t place) {
  PortalFace t;
  if (place < 12) {
    constexpr std::size_t next[3] = {1, 2, 0};
    const std::size_t i = place / 4, j = place % 4 == 3 ? 0 : place % 4;
    const Corner &a0 = a[i], &a1 = a[next[i]], &b0 = b[j], &b1 = b[next[j]];
    t.v1 = a1 + b0, t.v2 = a0 + b1;
    // The half of the parallelogram on the ray's side of the diagonal.
    const Point across = (t.v1.at - from).cross(t.v2.at - from);
    const Corner corner = a0 + b0, other = a1 + b1;
    t.v3 = (across.dot(d) < 0) == (across.dot(corner.at - from) < 0) ? corner : other;
  } else {
    const bool of_a = place != 13;
    const Corner(&face)[3] = of_a ? a : b;
    const Corner(&rest)[3] = of_a ? b : a;
    Point n = (face[1].at - face[0].at).cross(face[2].at - face[0].at);
    if (n.dot(d) < 0) n = -n;
    const double along[3] = {n.dot(rest[0].at), n.dot(rest[1].at), n.dot(rest[2].at)};
    std::size_t far = along[1] > along[0] ? 1 : 0;
    far = along[2] > along[far] ? 2 : far;
    t = {face[0] + rest[far], face[1] + rest[far], face[2] + rest[far]};
  }
  if ((t.v2.at - t.v1.at).cross(t.v3.at - t.v1.at).dot(d) < 0) std::swap(t.v2, t.v3);
  return t;
}

/// For the sums a + b of three points each: the face of their hull where the ray from `from` along d leaves. Its plane
/// is spanned by an edge of each, or by two edges of one; of all such planes it is the first that the ray meets.
HWY_INLINE PortalFace leave(const Corner (&a)[3], const Corner (&b)[3], const Point& from, const Point& d) {
  const hn::CappedTag<double, 4> tag;
  const hn::RebindToUnsigned<decltype(tag)> bits;
  using V = decltype(hn::Zero(tag));
  const Point edge_a[3] = {a[1].at - a[0].at, a[2].at - a[1].at, a[0].at - a[2].at},
              edge_b[3] = {b[1].at - b[0].at, b[2].at - b[1].at, b[0].at - b[2].at};
  struct Row {
    HWY_ALIGN double x[4], y[4], z[4];
    HWY_INLINE Row(const Point& p, const Point& q, const Point& r)
        : x{p.x, q.x, r.x, p.x}, y{p.y, q.y, r.y, p.y}, z{p.z, q.z, r.z, p.z} {}
  };
  const Row edges(edge_b[0], edge_b[1], edge_b[2]), first(edge_a[0], edge_b[0], edge_a[0]),
      second(edge_a[1], edge_b[1], edge_a[1]);
  constexpr double never = 1e300;
  constexpr std::uint64_t places = 15;
  V least = hn::Set(tag, never);
  for (std::size_t l = 0; l < 4; l += hn::Lanes(tag)) {
    // The position is stored in the last bits of the numbers, so the minimum brings it along.
    const auto meet = [&](std::uint64_t row, V px, V py, V pz, const Row& other) HWY_ATTR {
      const V qx = hn::Load(tag, other.x + l), qy = hn::Load(tag, other.y + l), qz = hn::Load(tag, other.z + l);
      V nx = hn::Sub(hn::Mul(py, qz), hn::Mul(pz, qy)), ny = hn::Sub(hn::Mul(pz, qx), hn::Mul(px, qz)),
        nz = hn::Sub(hn::Mul(px, qy), hn::Mul(py, qx));
      const auto along = [&](const Point& p) HWY_ATTR {
        return hn::Add(hn::Add(hn::Mul(nx, hn::Set(tag, p.x)), hn::Mul(ny, hn::Set(tag, p.y))),
                       hn::Mul(nz, hn::Set(tag, p.z)));
      };
      const V steep = along(d), sign = hn::And(steep, hn::SignBit(tag));
      nx = hn::Xor(nx, sign), ny = hn::Xor(ny, sign), nz = hn::Xor(nz, sign);
      const auto most = [&](const Corner(&p)[3])
                            HWY_ATTR { return hn::Max(hn::Max(along(p[0].at), along(p[1].at)), along(p[2].at)); };
      const V shift = hn::Div(hn::Sub(hn::Add(most(a), most(b)), along(from)), hn::Abs(steep));
      const V placed = hn::BitCast(
          tag, hn::Or(hn::And(hn::BitCast(bits, shift), hn::Set(bits, ~places)), hn::Iota(bits, 4 * row + l)));
      least = hn::IfThenElse(hn::Lt(shift, least), placed, least);
    };
    for (std::uint64_t i = 0; i < 3; ++i)
      meet(i, hn::Set(tag, edge_a[i].x), hn::Set(tag, edge_a[i].y), hn::Set(tag, edge_a[i].z), edges);
    meet(3, hn::Load(tag, first.x + l), hn::Load(tag, first.y + l), hn::Load(tag, first.z + l), second);
  }
  const std::uint64_t place = std::bit_cast<std::uint64_t>(hn::GetLane(hn::MinOfLanes(tag, least))) & places;
  return face_at(a, b, from, d, place);
}

class PolytopePortal {
 public:
  explicit PolytopePortal(const MinkowskiDifference& d)
      : a_(d.a),
        b_(d.b),
        shift_(point(d.pose.translation)),
        scale_(rounding_scale(d)),
        // Rotations are orthonormal only to 1e-6.
        ball_((1 - tolerance::askew) * (core_inner_radius(d.a) + core_inner_radius(d.b))) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        turn_.column[j][i] = d.pose.rotation(i, j);
        back_.column[i][j] = d.pose.rotation(i, j);
      }
    centre_ = point(core_centre(d.a)) - placed(point(core_centre(d.b)));
  }

  bool usable() const {
    return a_.usable() && b_.usable() && ball_ > tolerance::no_centre_line * scale_ &&
           centre_.dot(centre_) > tolerance::no_centre_line2 * scale_ * scale_;
  }
  double ball() const { return ball_; }
  double scale() const { return scale_; }
  const Point& centre() const { return centre_; }
  double rounding() const { return 16 * epsilon * scale_; }

  /// Ends early if the shapes are more than `beyond` apart. Requires `usable()`.
  template <PortalAim aim>
  HWY_INLINE PortalEnd search(double beyond, PortalFace& face) {
    beyond_ = beyond;
    face = begin();
    return PortalSteps<Corner, PolytopePortal>(*this).search<aim>(face);
  }
  /// The farthest point along n; false if that shows the shapes more than `beyond` apart.
  HWY_ATTR bool farthest(const Point& n, Corner& w) const {
    const double at_most = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);  // an upper bound on its length
    const Corner a = a_.farthest(n, at_most), b = b_.farthest(back_ * -n, at_most);
    w = {a.at - placed(b.at), a.id << 32 | b.id};
    return !(n.dot(w.at) < -beyond_ * at_most);
  }

 private:
  HWY_INLINE Point placed(const Point& p) const { return turn_ * p + shift_; }
  HWY_INLINE PortalFace begin() const {
    Corner a[3], b[3];
    a_.begin(-centre_, a);
    b_.begin(back_ * centre_, b);
    for (Corner& c : a) c.id <<= 32;
    for (Corner& c : b) c.at = -placed(c.at);
    return leave(a, b, centre_, -centre_);
  }

  PortalSide a_, b_;
  Columns turn_, back_;
  Point shift_, centre_;
  double scale_, ball_, beyond_ = 0;
};

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void search_polytopes(const MinkowskiDifference& d, PortalResult& r) {
  using Verdict = PortalResult::Verdict;
  PolytopePortal portal(d);
  r.verdict = Verdict::open;
  r.normal = (-portal.centre()).vec();
  if (!portal.usable()) return;
  PortalFace face;
  const PortalEnd end = portal.search<PortalAim::verdict>(portal.rounding(), face);
  r.normal = face.n.vec();
  if (end == PortalEnd::apart) r.verdict = Verdict::apart;
  if (end == PortalEnd::overlapping) r.verdict = Verdict::overlapping;
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void search_surface(const MinkowskiDifference& d, double beyond, SurfaceFace& r) {
  PolytopePortal portal(d);
  r.end = SurfaceFace::End::open;
  if (!portal.usable()) return;
  PortalFace face;
  const PortalEnd end = portal.search<PortalAim::surface>(std::max(beyond, portal.rounding()), face);
  if (end == PortalEnd::open) return;
  r.end = end == PortalEnd::apart ? SurfaceFace::End::apart : SurfaceFace::End::reached;
  r.normal = face.n.vec();
  r.centre = portal.centre().vec();
  r.ball = portal.ball();
  const Corner* const corners[3] = {&face.v1, &face.v2, &face.v3};
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<std::uint32_t>(corners[i]->id >> 32), b = static_cast<std::uint32_t>(corners[i]->id);
    r.corner[i] = {corners[i]->at.vec(), core_vertex(d.a, a), a, b};
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(search_polytopes);
HWY_EXPORT(search_surface);
PortalKernel portal_kernel() { return HWY_DYNAMIC_DISPATCH(search_polytopes); }
SurfaceKernel surface_kernel() { return HWY_DYNAMIC_DISPATCH(search_surface); }
}  // namespace tandem
#endif
