// The depth of two bodies of which one is round: the least minimum of h.
#include "round/round_depth.h"

#include <utility>

#include "closed_forms/surface_distance.h"
#include "round/arc_search.h"
#include "round/hull_projection.h"
#include "round/minima.h"
#include "round/smooth_search.h"
#include "round/support_polytope.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// True for a triangle that is not a segment to rounding.
bool spans_plane(std::span<const Vec3> v) {
  if (v.size() != 3) return false;
  const Vec3 a = v[1] - v[0], b = v[2] - v[0], c = v[2] - v[1];
  const double longest2 = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
  return a.cross(b).squaredNorm() > tolerance::spans_plane2 * longest2 * longest2;
}

/// True if the body's core is one point: a ball's, or all of its vertices coincide.
bool is_point(const RoundBody& body) {
  const std::span<const Vec3> corners = body.view().vertices;
  if (corners.empty()) return body.kind() == ShapeKind::sphere;
  return std::all_of(corners.begin(), corners.end(), [&](const Vec3& v) { return v == corners.front(); });
}

/// The axis about which the body is rotationally symmetric, to rounding; zero if there is none, or any.
Vec3 axis_of_revolution(const RoundBody& body) {
  if (body.has_circle() || body.kind() == ShapeKind::capsule) return body.axis();
  if (body.is_segment()) return body.axes() * (body.view().vertices[1] - body.view().vertices[0]).stableNormalized();
  if (body.kind() != ShapeKind::ellipsoid) return Vec3::Zero();
  const auto& radii = body.view().param;
  for (std::size_t k = 0; k < 3; ++k) {
    const double u = radii[(k + 1) % 3], v = radii[(k + 2) % 3];
    if (std::abs(u - v) <= 4 * epsilon * u) return body.axes().col(static_cast<int>(k));
  }
  return Vec3::Zero();
}

/// The direction in which a point of the other summand leaves the ellipsoid first.
Vec3 way_out(const RoundBody& ellipsoid, const Vec3& point) {
  const auto& radii = ellipsoid.view().param;
  const Vec3 at = -(ellipsoid.axes().transpose() * (ellipsoid.centre() + point));
  return (ellipsoid.axes() * ellipsoid_normal({radii[0], radii[1], radii[2]}, at)).normalized();
}

class Search {
 public:
  /// From a minimum of h, or from any direction, from which no descent is made if another one is better.
  Search(const RoundPair& pair, const Support& start, bool descended)
      : pair_(pair), m_(pair, start), descended_(descended) {
    if (descended) m_.note(start.n);
  }

  Depth run();

 private:
  void try_axes();
  bool try_face(int which, std::size_t face, const Vec3& n);
  bool by_arcs(int which) const;
  void search_kinks();
  void try_faces(int which);
  void search_near_edges(int which);
  double off_axis() const;
  double search_meridian();
  bool search_ellipsoid();
  double expand();
  bool is_proven() const;
  bool may_have_more(const Vec3& n, double angle) const;
  bool is_known(const Vec3& n, const Vec3& w) const;

  const RoundPair& pair_;
  Minima m_;
  bool descended_;
  FaceReach reach_[2];  ///< of a polytope with a circle
};

/// True if the other body is supported well inside the face with normal n. Then h has a local minimum there, and no
/// descent is needed.
bool Search::try_face(int which, std::size_t face, const Vec3& n) {
  const RoundBody &body = pair_.body[which], &other = pair_.body[1 - which];
  if (body.kind() == ShapeKind::triangle || (body.kind() == ShapeKind::convex && body.hull().dimension == 2))
    return false;
  Support s;
  s.n = n;
  s.point[1 - which] = other.support(n);
  const Vec3 corner = body.support(n);
  s.h = n.dot(corner + s.point[1 - which]);
  s.point[which] = s.h * n - s.point[1 - which];
  const Vec3 q = body.axes().transpose() * (s.point[which] - body.centre());
  if (body.kind() == ShapeKind::box) {
    for (std::size_t k = 0; k < 3; ++k)
      if (k != face / 2 && !(std::abs(q[static_cast<int>(k)]) < body.view().param[k] - m_.rounding)) return false;
  } else if (!on_face(body.hull(), static_cast<std::uint32_t>(face), q, m_.rounding)) {
    return false;
  }
  s.optimal = true;
  m_.note(n);
  if (s.h < m_.best.h) m_.best = s;
  return true;
}

/// True if the body is a polytope whose faces and arcs between them have all minima that lie on no circle alone.
bool Search::by_arcs(int which) const {
  const RoundBody& body = pair_.body[which];
  if (!pair_.body[1 - which].has_circle()) return false;
  if (body.kind() == ShapeKind::triangle) return spans_plane(body.view().vertices);
  return body.kind() == ShapeKind::box || (body.kind() == ShapeKind::convex && body.hull().dimension > 1);
}

/// Tries directions that are often minima: the axes of both, the common perpendicular, normals of faces.
void Search::try_axes() {
  Vec3 axes[12];
  int count = 0;
  double least = m_.best.h;
  Vec3 from = m_.best.n;
  int face_of = -1;  // the body whose face's normal `from` is
  std::size_t face_number = 0;
  for (int which = 0; which < 2; ++which) {
    const RoundBody& body = pair_.body[which];
    if (by_arcs(which)) {
      reach_[which].measure(body, pair_.body[1 - which]);
      const FaceReach::Least face = reach_[which].least();
      if (face.h < least - m_.rounding)
        least = face.h, from = face_normal(body, reach_[which], face.face), face_of = which, face_number = face.face;
      continue;
    }
    if (body.kind() == ShapeKind::sphere || body.kind() == ShapeKind::convex || body.kind() == ShapeKind::triangle)
      continue;
    axes[count++] = body.axes().col(2);
    if (body.kind() != ShapeKind::box && body.kind() != ShapeKind::ellipsoid) continue;
    axes[count++] = body.axes().col(0);
    axes[count++] = body.axes().col(1);
  }
  const RoundBody &a = pair_.body[0], &b = pair_.body[1];
  const auto across = [&](const Vec3& u, const Vec3& v) {
    const Vec3 c = u.cross(v);
    if (c.squaredNorm() > tolerance::parallel_planes2) axes[count++] = c.normalized();
  };
  const RoundBody* box = a.kind() == ShapeKind::box ? &a : b.kind() == ShapeKind::box ? &b : nullptr;
  if (box != nullptr && !descended_ && (a.has_circle() || b.has_circle())) {
    for (int k = 0; k < 3; ++k) across(box->axes().col(k), (box == &a ? b : a).axis());
  } else {
    across(a.axis(), b.axis());
  }
  for (int i = 0; i < count; ++i) {
    const Vec3 up = pair_.support(axes[i]), down = pair_.opposite(axes[i], up);
    const double h[2] = {axes[i].dot(up), -axes[i].dot(down)};
    for (int k = 0; k < 2; ++k)
      if (h[k] < least - m_.rounding) least = h[k], from = k == 0 ? axes[i] : Vec3(-axes[i]), face_of = -1;
  }
  if (descended_ && !(least < m_.best.h - m_.rounding)) return;
  if (!descended_) m_.best.h = infinity;
  if (face_of < 0 || !try_face(face_of, face_number, from)) m_.try_from(from);
}

/// True if there is a minimum near the face with normal n, towards which h falls; w supports it along n.
bool Search::is_known(const Vec3& n, const Vec3& w) const {
  for (int i = 0; i < m_.count; ++i) {
    const double c = m_.known[i].dot(n);
    if (c > tolerance::at_minimum && m_.known[i].dot(w) < c * n.dot(w)) return true;
  }
  return false;
}

/// True if a point of one body lies so deep in the other that h is nowhere less: h is at least the other's support
/// about that point, and the least of that is the point's depth.
bool Search::is_proven() const {
  for (int which = 0; which < 2; ++which) {
    const RoundBody& body = pair_.body[which];
    const Vec3& point = m_.best.point[1 - which];
    // The transpose of a rotation that is skew, as poses may be, is not its inverse.
    if ((body.axes().transpose() * body.axes() - Mat3::Identity()).norm() > 16 * epsilon) continue;
    double depth = 0;
    if (body.kind() == ShapeKind::ellipsoid) {
      const Vec3 n = way_out(body, point);
      depth = n.dot(body.support(n) + point);
    } else if (body.kind() == ShapeKind::convex) {
      const Vec3 at = -(body.axes().transpose() * (body.centre() + point));
      if (const auto surface = surface_distance(body.view(), at, 0)) depth = -surface->distance;
    }
    if (depth >= m_.best.h - m_.rounding) return true;
  }
  return false;
}

/// The number of places within this angle (radians) of m where a hull's support has a kink, at most 2: normals of
/// faces, and arcs between normals farther off.
int kinks_near(const Hull& hull, const Vec3& m, double angle, WorkMeter& meter) {
  constexpr std::uint32_t none = ~0u;
  std::uint32_t known = none;  // the first normal found
  int kinks = 0;
  meter.spend(static_cast<int>(hull.edges.size()));
  for (const Hull::Edge& edge : hull.edges) {
    const Vec3 e = hull.vertices[edge.v[1]] - hull.vertices[edge.v[0]];
    const double along = m.dot(e), reach2 = angle * angle * e.squaredNorm();
    if (along * along > reach2) continue;
    if (hull.faces.empty()) return 1;
    bool ends_near = false;
    for (const std::uint32_t face : edge.face) {
      if ((hull.faces[face].normal - m).squaredNorm() > angle * angle) continue;
      ends_near = true;
      if (face != known && ++kinks > 1) return kinks;
      known = face;
    }
    const double reach = std::sqrt(reach2);
    if (ends_near || m.dot(hull.faces[edge.face[0]].normal.cross(e)) > reach ||
        m.dot(e.cross(hull.faces[edge.face[1]].normal)) > reach)
      continue;
    if (++kinks > 1) return kinks;
  }
  return kinks;
}

/// True if h may have several minima within this angle (radians) of n: where a hull's support has several kinks, or an
/// ellipsoid's radii of curvature are not the same within a tenth. With equal ones h curves upwards all over, or
/// downwards beside the kinks.
bool Search::may_have_more(const Vec3& n, double angle) const {
  constexpr double even = 32;  // ratio of an ellipsoid's height along n to its change; its radii are as the height^-3
  WorkMeter meter(pair_.difference.limit);
  for (const RoundBody& body : pair_.body) {
    if (body.kind() == ShapeKind::convex) {
      if (kinks_near(body.hull(), body.axes().transpose() * n, angle, meter) > 1) return true;
    } else if (body.kind() == ShapeKind::ellipsoid) {
      const auto& radii = body.view().param;
      const double height = n.dot(body.support(n) - body.centre());
      if (height < even * angle * std::max({radii[0], radii[1], radii[2]})) return true;
    }
  }
  return false;
}

/// Expands a polytope within A - B until no face is nearer than the best minimum; returns the remaining uncertainty.
/// Where a hole between a face and the surface is small, a descent finds the minimum; where it may have several and
/// nothing proves that none is lower, the polytope grows on.
double Search::expand() {
  constexpr double narrow = 0.02;  // radians
  constexpr int a_face = 64;       // units of work, with a descent
  SupportPolytope polytope(pair_, m_.rounding);
  WorkMeter meter(pair_.difference.limit);
  meter.spend(a_face);
  if (!polytope.begin(m_.best)) return m_.best.h;
  for (;;) {
    meter.spend(a_face);
    const int nearest = polytope.nearest();
    const double offset = polytope.offset(nearest);
    if (offset >= m_.best.h - m_.rounding) return 0;
    const double margin = offset > 0 ? polytope.foot_margin(nearest) : 0;
    if (margin < 0) {  // its neighbour there is nearer the origin
      polytope.leave(nearest);
      continue;
    }
    const Vec3& n = polytope.face(nearest).normal;
    const Vec3 w = pair_.support(n);
    const double h = n.dot(w);
    if (h < m_.best.h - m_.rounding) {
      m_.try_from(n);
      if (m_.best.h < 0) return 0;
    }
    if (h - offset <= m_.rounding) {
      polytope.leave(nearest);
      continue;
    }
    const double hole = m_.best.h - offset;
    if (offset > 0 && hole < narrow * margin) {
      if (!is_known(n, w)) m_.try_from(n);
      if (!may_have_more(n, hole / margin) || is_proven()) {
        polytope.leave(nearest);
        continue;
      }
    }
    if (!polytope.add(nearest, w)) return m_.best.h - offset;
  }
}

/// A bound on how far points of one body are from where they would be if both were rotationally symmetric about one
/// axis (metres); infinity if they are not nearly so.
double Search::off_axis() const {
  const RoundBody &a = pair_.body[0], &b = pair_.body[1];
  const Vec3 u = axis_of_revolution(a), v = axis_of_revolution(b), middle = a.middle() + b.middle();
  if (u.isZero(0) || v.isZero(0)) return infinity;
  const double sine = u.cross(v).norm();
  return sine < tolerance::leaning_axes ? u.cross(middle).norm() + 2 * sine * b.view().size : infinity;
}

/// The least of h in a plane through the axis about which both bodies are symmetric, which is the least of all. Returns
/// its uncertainty.
double Search::search_meridian() {
  const Vec3 axis = axis_of_revolution(pair_.body[0]), across = axis.cross(m_.best.n);
  const double sine = across.norm();
  const double known = std::exchange(m_.gap, 0.0);
  // Through the best known direction, so that it is found again, unless it hardly determines the plane.
  search_circle(m_, pair_.body[0].kind() == ShapeKind::ellipsoid ? 1 : 0,
                {sine > tolerance::leaning_axes ? Vec3(across / sine) : any_perpendicular(axis)}, false);
  return std::exchange(m_.gap, known);
}

/// Descends from the normals of a hull's faces with smaller supports: those of a flat hull lie so close together that a
/// descent from a polytope's face finds only one of their minima.
void Search::try_faces(int which) {
  const RoundBody &body = pair_.body[which], &other = pair_.body[1 - which];
  const Hull& hull = body.hull();
  WorkMeter meter(pair_.difference.limit, unchecked_edges(hull));
  for (const Hull::Face& face : hull.faces) {
    meter.spend();
    const Vec3 n = body.axes() * face.normal;
    const Vec3 corner = body.axes() * hull.vertices[hull.loop[face.first]] + body.centre();
    if (m_.best.h > 0 && n.dot(corner + other.support(n)) < m_.best.h - m_.rounding) m_.try_from(n);
  }
}

/// The least of h for a hull that is hardly deep, all around those of its edges that support as much as its deepest
/// vertex: a needle's minima lie so close together that descents from a polytope's faces find only one of them.
void Search::search_near_edges(int which) {
  if (!(m_.best.h < tolerance::near_surface * pair_.scale)) return;
  const RoundBody& body = pair_.body[which];
  const Hull& hull = body.hull();
  const Vec3 m = body.axes().transpose() * m_.best.n;
  const double level = m.dot(hull.vertices[static_cast<std::size_t>(body.support_piece(m_.best.n))]) -
                       tolerance::near_features * pair_.scale;
  WorkMeter meter(pair_.difference.limit, unchecked_edges(hull));
  for (const Hull::Edge& e : hull.edges) {
    meter.spend();
    const Vec3 &p = hull.vertices[e.v[0]], &q = hull.vertices[e.v[1]];
    if (m_.best.h > 0 && m.dot(p) >= level && m.dot(q) >= level)
      search_circle(m_, which, {body.axes() * (q - p).stableNormalized()}, true);
  }
}

/// Searches minima where a support has a kink: on arcs between faces, and on circles.
void Search::search_kinks() {
  for (int which = 0; which < 2 && m_.best.h > 0; ++which) {
    const RoundBody& body = pair_.body[which];
    if (reach_[which].known()) {
      search_face_arcs(m_, which, reach_[which]);
    } else if (body.kind() == ShapeKind::convex && pair_.body[1 - which].has_circle()) {
      const Hull& hull = body.hull();
      if (hull.dimension == 1)
        search_circle(m_, which, {body.axes() * (hull.vertices[1] - hull.vertices[0]).stableNormalized()}, true);
    } else if (body.kind() == ShapeKind::convex) {
      try_faces(which);
      search_near_edges(which);
    } else {
      Circle circles[3];
      const int count = body.kinks(circles);
      for (int i = 0; i < count && m_.best.h > 0; ++i) search_circle(m_, which, circles[i], true);
    }
  }
}

/// For pairs with an ellipsoid. True if the minimum found is certainly the least: the other body is a point.
bool Search::search_ellipsoid() {
  // Ratio of radii: between stretched ellipsoids, and between one and a body with edges, a minimum may be narrower than
  // a grid of directions: 1 in 500 of such pairs got a depth too large by up to 2 %.
  constexpr double stretched = 4;
  const RoundBody &a = pair_.body[0], &b = pair_.body[1];
  if (is_point(a) || is_point(b)) {
    const RoundBody &body = a.kind() == ShapeKind::ellipsoid ? a : b, &point = &body == &a ? b : a;
    m_.try_from(way_out(body, point.support(m_.best.n)));
    return true;
  }
  const auto smooth = [](const RoundBody& body) {
    return body.kind() == ShapeKind::sphere || (body.kind() == ShapeKind::ellipsoid && body.aspect() <= stretched);
  };
  if (smooth(a) && smooth(b)) {
    search_ellipsoids(m_);
    return false;
  }
  // Where h is as low all around the axis, a polytope would need points as dense as the bound is tight.
  const double off = off_axis(), around = off < infinity ? search_meridian() + 2 * off : infinity;
  if (around > tolerance::search_left * pair_.scale && m_.best.h > 0) m_.gap = std::max(m_.gap, expand());
  m_.gap = std::min(m_.gap, around);
  return false;
}

Depth Search::run() {
  try_axes();
  search_kinks();
  if (m_.best.h > 0) {
    const RoundBody &a = pair_.body[0], &b = pair_.body[1];
    if (a.kind() == ShapeKind::ellipsoid || b.kind() == ShapeKind::ellipsoid) {
      if (search_ellipsoid()) return {m_.best, 0};
    } else if (a.has_circle() && b.has_circle()) {
      search_circles(m_);
    }
  }
  return {m_.best, m_.best.h > 0 ? m_.gap : 0};
}

}  // namespace

Depth least_depth(const RoundPair& pair, const Support& start, bool descended) {
  return Search(pair, start, descended).run();
}

}  // namespace tandem
