#include "round/round_depth.h"

#include <utility>

#include "round/circle_distance.h"
#include "round/circle_floor.h"
#include "round/ellipsoid_normal.h"
#include "round/face_reach.h"
#include "round/hull_projection.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int max_vertices = 480;
constexpr int max_faces = 2 * max_vertices;  // a closed triangulation has 2 v - 4
constexpr int max_known = 24;

struct Face {
  int v[3];
  int next[3];  ///< the face across the edge v[i] -> v[i + 1]
  Vec3 normal;  ///< unit, outward
};

/// Is it a triangle that no rounding makes a segment?
bool spans_plane(std::span<const Vec3> v) {
  if (v.size() != 3) return false;
  const Vec3 a = v[1] - v[0], b = v[2] - v[0], c = v[2] - v[1];
  const double longest2 = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
  return a.cross(b).squaredNorm() > tolerance::spans_plane2 * longest2 * longest2;
}

/// Is the body's core one point, a ball's or all of its corners?
bool is_point(const RoundBody& body) {
  const std::span<const Vec3> corners = body.view().vertices;
  if (corners.empty()) return body.kind() == ShapeKind::sphere;
  return std::all_of(corners.begin(), corners.end(), [&](const Vec3& v) { return v == corners.front(); });
}

/// The axis about which the body is the same all around, but for rounding; zero where there is none, or any.
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

class Search {
 public:
  /// From a minimum of h, or from any direction, from which is then not descended if another one is better.
  Search(const RoundPair& pair, const Support& start, bool descended)
      : pair_(pair), rounding_(16 * epsilon * pair.scale), descended_(descended) {
    best_ = start;
    if (descended) known_[known_count_++] = start.n;
  }

  Depth run();

 private:
  void try_axes();
  Vec3 try_from(const Vec3& n);
  bool try_face(int which, std::size_t face, const Vec3& n);
  void search_circle(int which, const Circle& circle, bool kink);
  double off_axis() const;
  double search_meridian();
  void search_arcs(int which);
  void try_faces(int which);
  void search_near_edges(int which);
  bool by_arcs(int which) const;
  Vec3 face_normal(int which, std::size_t face) const;
  template <class Supporting>
  void search_spans(const Circle& circle, const Span* spans, int count, double add, const Supporting& supporting,
                    const CircleFloor& floor);
  void search_circles();
  void search_circles(const CircleDistance& circles);
  void search_smooth();
  double expand();
  bool is_known(const Face& f, const Vec3& w) const;
  double foot_margin(const Face& f, double offset) const;
  bool begin();
  void new_face(int slot, int a, int b, int c);
  bool add(int face, const Vec3& w);

  const RoundPair& pair_;
  double rounding_;
  bool descended_;
  Support best_;
  FaceReach reach_[2];  ///< of a polytope with a circle
  Vec3 known_[max_known];
  int known_count_ = 0;
  double gap_ = 0;
  Vec3 vertex_[max_vertices];
  int vertices_ = 0;
  Face face_[max_faces];
  double key_[max_faces];     ///< offset of the faces still to be looked at, else
                              ///< infinity
  double offset_[max_faces];  ///< infinity: a free slot or a sliver
  int faces_ = 0;
  int free_[max_faces];
  int free_count_ = 0;
};

/// Returns the minimum's direction.
Vec3 Search::try_from(const Vec3& n) {
  const Support s = minimize(pair_, n, -infinity);
  if (known_count_ < max_known) known_[known_count_++] = s.n;
  if (s.h < best_.h) best_ = s;
  return s.n;
}

/// Is the face, whose normal n is, where the other body reaches farthest, well over its middle? Then h is least there
/// among all directions near, and no descent is needed to tell.
bool Search::try_face(int which, std::size_t face, const Vec3& n) {
  const RoundBody &body = pair_.body[which], &other = pair_.body[1 - which];
  if (body.kind() == ShapeKind::triangle) return false;
  Support s;
  s.n = n;
  s.point[1 - which] = other.support(n);
  const Vec3 corner = body.support(n);
  s.h = n.dot(corner + s.point[1 - which]);
  s.point[which] = s.h * n - s.point[1 - which];
  const Vec3 q = body.axes().transpose() * (s.point[which] - body.centre());
  if (body.kind() == ShapeKind::box) {
    for (std::size_t k = 0; k < 3; ++k)
      if (k != face / 2 && !(std::abs(q[static_cast<int>(k)]) < body.view().param[k] - rounding_)) return false;
  } else if (!on_face(body.hull(), static_cast<std::uint32_t>(face), q, rounding_)) {
    return false;
  }
  s.optimal = true;
  if (known_count_ < max_known) known_[known_count_++] = n;
  if (s.h < best_.h) best_ = s;
  return true;
}

/// Is the body a polytope whose faces and arcs between them have all minima that a circle alone does not?
bool Search::by_arcs(int which) const {
  const RoundBody& body = pair_.body[which];
  if (!pair_.body[1 - which].has_circle()) return false;
  if (body.kind() == ShapeKind::triangle) return spans_plane(body.view().vertices);
  return body.kind() == ShapeKind::box || (body.kind() == ShapeKind::convex && body.hull().dimension == 3);
}

/// The directions where minima like to sit: the axes of both, the common
/// perpendicular, normals of faces.
void Search::try_axes() {
  Vec3 axes[12];
  int count = 0;
  double least = best_.h;
  Vec3 from = best_.n;
  int face_of = -1;  // whose face's normal `from` is
  std::size_t face_number = 0;
  for (int which = 0; which < 2; ++which) {
    const RoundBody& body = pair_.body[which];
    if (by_arcs(which)) {
      reach_[which].measure(body, pair_.body[1 - which]);
      const FaceReach::Least face = reach_[which].least();
      if (face.h < least - rounding_)
        least = face.h, from = face_normal(which, face.face), face_of = which, face_number = face.face;
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
      if (h[k] < least - rounding_) least = h[k], from = k == 0 ? axes[i] : Vec3(-axes[i]), face_of = -1;
  }
  if (descended_ && !(least < best_.h - rounding_)) return;
  if (!descended_) best_.h = infinity;
  if (face_of < 0 || !try_face(face_of, face_number, from)) try_from(from);
}

Vec3 Search::face_normal(int which, std::size_t face) const {
  const RoundBody& body = pair_.body[which];
  if (body.kind() == ShapeKind::triangle) return reach_[which].normal(face);
  if (body.kind() != ShapeKind::box) return body.axes() * body.hull().faces[face].normal;
  const Vec3 n = body.axes().col(static_cast<int>(face / 2));
  return face % 2 == 0 ? n : Vec3(-n);
}

void Search::new_face(int slot, int a, int b, int c) {
  Face& f = face_[slot];
  f.v[0] = a, f.v[1] = b, f.v[2] = c;
  const Vec3 &p = vertex_[a], &q = vertex_[b], &r = vertex_[c];
  const Vec3 pq = q - p, qr = r - q, rp = p - r;
  const double pq2 = pq.squaredNorm(), qr2 = qr.squaredNorm(), rp2 = rp.squaredNorm();
  const double longest = std::max({pq2, qr2, rp2});
  const Vec3 n = longest == qr2 ? Vec3(rp.cross(pq)) : longest == rp2 ? Vec3(pq.cross(qr)) : Vec3(qr.cross(rp));
  const double length = n.norm();
  if (length > rounding_ * std::sqrt(longest)) {
    f.normal = n / length;
    offset_[slot] = f.normal.dot(p);
  } else {
    f.normal.setZero();
    offset_[slot] = infinity;
  }
  key_[slot] = offset_[slot];
}

bool Search::begin() {
  vertex_[0] = best_.point[0] + best_.point[1];
  vertex_[1] = pair_.support(-best_.n);
  const Vec3 line = vertex_[1] - vertex_[0];
  const auto farther = [&](const Vec3& axis) {
    const Vec3 p = pair_.support(axis), q = pair_.support(-axis);
    return axis.dot(p - vertex_[0]) >= axis.dot(vertex_[0] - q) ? p : q;
  };
  vertex_[2] = farther(any_perpendicular(line));
  const Vec3 across = line.cross(vertex_[2] - vertex_[0]);
  if (!(across.norm() > rounding_ * line.norm())) return false;
  vertex_[3] = farther(across.normalized());
  const double side = across.dot(vertex_[3] - vertex_[0]);
  if (!(std::abs(side) > rounding_ * across.norm())) return false;
  if (side > 0) std::swap(vertex_[1], vertex_[2]);
  vertices_ = faces_ = 4;
  new_face(0, 0, 1, 2);
  new_face(1, 0, 3, 1);
  new_face(2, 1, 3, 2);
  new_face(3, 2, 3, 0);
  constexpr int next[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  for (int i = 0; i < 4; ++i) std::copy(next[i], next[i] + 3, face_[i].next);
  return true;
}

/// Adds w, seen by `face`. False if the horizon is not one loop: rounding has
/// the last word.
bool Search::add(int face, const Vec3& w) {
  if (vertices_ == max_vertices) return false;
  int seen[max_faces], seen_count = 0;
  bool is_seen[max_faces];
  std::fill(is_seen, is_seen + faces_, false);
  seen[seen_count++] = face;
  is_seen[face] = true;
  for (int k = 0; k < seen_count; ++k)
    for (const int other : face_[seen[k]].next) {
      if (is_seen[other]) continue;
      const Face& f = face_[other];
      if (f.normal.dot(w - vertex_[f.v[0]]) > -rounding_ && f.normal != Vec3::Zero()) {
        is_seen[other] = true;
        seen[seen_count++] = other;
      }
    }
  struct Edge {
    int from, to, outer;
  } horizon[max_faces];
  int edges = 0;
  for (int k = 0; k < seen_count; ++k) {
    const Face& f = face_[seen[k]];
    for (int i = 0; i < 3; ++i)
      if (!is_seen[f.next[i]]) horizon[edges++] = {f.v[i], f.v[(i + 1) % 3], f.next[i]};
  }
  if (edges < 3 || faces_ + edges - seen_count - free_count_ > max_faces) return false;
  for (int k = 0; k + 1 < edges; ++k) {
    int found = -1;
    for (int j = k + 1; j < edges; ++j)
      if (horizon[j].from == horizon[k].to) {
        if (found >= 0) return false;
        found = j;
      }
    if (found < 0) return false;
    std::swap(horizon[k + 1], horizon[found]);
  }
  if (horizon[edges - 1].to != horizon[0].from) return false;

  for (int k = 0; k < seen_count; ++k) {
    key_[seen[k]] = offset_[seen[k]] = infinity;
    free_[free_count_++] = seen[k];
  }
  const int added = vertices_++;
  vertex_[added] = w;
  int first = -1, last = -1;
  for (int k = 0; k < edges; ++k) {
    const auto [from, to, outer] = horizon[k];
    const int i = free_count_ > 0 ? free_[--free_count_] : faces_++;
    new_face(i, from, to, added);
    face_[i].next[0] = outer;
    for (int j = 0; j < 3; ++j)
      if (face_[outer].v[j] == to && face_[outer].v[(j + 1) % 3] == from) face_[outer].next[j] = i;
    if (last >= 0) {
      face_[last].next[1] = i;
      face_[i].next[2] = last;
    } else {
      first = i;
    }
    last = i;
  }
  face_[last].next[1] = first;
  face_[first].next[2] = last;
  return true;
}

/// How far within its triangle the origin's foot on the face lies; negative:
/// outside.
double Search::foot_margin(const Face& f, double offset) const {
  const Vec3 foot = offset * f.normal;
  double least = infinity;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &p = vertex_[f.v[i]], &q = vertex_[f.v[(i + 1) % 3]];
    const Vec3 in = f.normal.cross(q - p);
    least = std::min(least, in.dot(foot - p) / in.norm());
  }
  return least;
}

/// Is there a minimum near the face towards which h falls? w supports it along
/// the face's normal.
bool Search::is_known(const Face& f, const Vec3& w) const {
  for (int i = 0; i < known_count_; ++i) {
    const double c = known_[i].dot(f.normal);
    if (c > 0.9998 && known_[i].dot(w) < c * f.normal.dot(w)) return true;
  }
  return false;
}

/// Expands the polytope; returns what is not known.
double Search::expand() {
  constexpr double narrow = 0.02;  // radians: a hole so small holds one minimum
  if (!begin()) return best_.h;
  for (;;) {
    int nearest = 0;
    for (int i = 1; i < faces_; ++i)
      if (key_[i] < key_[nearest]) nearest = i;
    const double offset = key_[nearest];
    if (offset >= best_.h - rounding_) return 0;
    const Face& f = face_[nearest];
    const double margin = offset > 0 ? foot_margin(f, offset) : 0;
    if (margin < 0) {  // its neighbour there is nearer the origin
      key_[nearest] = infinity;
      continue;
    }
    const Vec3 w = pair_.support(f.normal);
    const double h = f.normal.dot(w);
    if (h < best_.h - rounding_) {
      try_from(f.normal);
      if (best_.h < 0) return 0;
    }
    if (h - offset <= rounding_) {
      key_[nearest] = infinity;
      continue;
    }
    if (offset > 0 && best_.h - offset < narrow * margin) {
      if (!is_known(f, w)) try_from(f.normal);
      key_[nearest] = infinity;
      continue;
    }
    if (!add(nearest, w)) return best_.h - offset;
  }
}

/// How far points of one body are at most from where they would be if both were the same all around one axis (metres);
/// infinity if they are not nearly so.
double Search::off_axis() const {
  const RoundBody &a = pair_.body[0], &b = pair_.body[1];
  const Vec3 u = axis_of_revolution(a), v = axis_of_revolution(b), middle = a.middle() + b.middle();
  if (u.isZero(0) || v.isZero(0)) return infinity;
  constexpr double leaning = 1e-3;
  const double sine = u.cross(v).norm();
  return sine < leaning ? u.cross(middle).norm() + 2 * sine * b.view().size : infinity;
}

/// The least of h in a plane through the axis about which both bodies are the same all around: there is no less
/// elsewhere. Returns what is not known of it.
double Search::search_meridian() {
  const Vec3 axis = axis_of_revolution(pair_.body[0]), across = axis.cross(best_.n);
  const double sine = across.norm();
  const double known = std::exchange(gap_, 0.0);
  // Through the best direction known, so that it is found again; not where it hardly tells the plane.
  search_circle(pair_.body[0].kind() == ShapeKind::ellipsoid ? 1 : 0,
                {sine > 1e-3 ? Vec3(across / sine) : any_perpendicular(axis)}, false);
  return std::exchange(gap_, known);
}

/// The least of h on a circle, one where body `which` has a kink or another through its centre.
void Search::search_circle(int which, const Circle& circle, bool kink) {
  constexpr int start = 8;
  const RoundBody &body = pair_.body[which], &other = pair_.body[1 - which];
  const bool level = kink && body.is_level();
  const double ball = other.rolling_ball(circle), lift = circle.height, radius = circle.radius;
  const double add = (level ? body.level() : 0.0) + ball;
  const auto support = [&](const Vec3& n) -> Vec3 {
    return (level ? Vec3(body.middle() + other.support(n)) : pair_.support(n)) - ball * n;
  };
  const auto opposite = [&](const Vec3& n, const Vec3& along) -> Vec3 {
    if (lift != 0 || !other.symmetric() || !body.symmetric()) return support(lift * circle.axis - radius * n);
    return 2 * (body.centre() + other.centre()) - along;
  };
  const auto at = [&](const Vec3& out, const Vec3& p) {
    const Vec3 n = lift * circle.axis + radius * out;
    if (n.dot(p) + add < best_.h - rounding_) try_from(n);
    return Sample{out, p};
  };
  const Vec3 x = any_perpendicular(circle.axis), y = circle.axis.cross(x);
  constexpr double half = 0.70710678118654752440;
  constexpr double turn[start / 2][2] = {{1, 0}, {half, half}, {0, 1}, {-half, half}};
  Sample samples[start];
  for (int i = 0; i < start / 2; ++i) {
    const Vec3 out = turn[i][0] * x + turn[i][1] * y;
    samples[i] = at(out, support(lift * circle.axis + radius * out));
    samples[i + start / 2] = at(-out, opposite(out, samples[i].p));
  }
  Span spans[start];
  for (int i = 0; i < start; ++i) spans[i] = {samples[i], samples[(i + 1) % start]};
  search_spans(circle, spans, start, add, support, level ? CircleFloor(other, circle, body.middle()) : CircleFloor(circle));
}

/// The least of h on the arcs between the normals of a polytope's faces, where two of its corners reach as far.
void Search::search_arcs(int which) {
  const RoundBody &body = pair_.body[which], &other = pair_.body[1 - which];
  const FaceReach& reach = reach_[which];
  const auto follow = [&](std::uint32_t v, std::uint32_t f, std::uint32_t g) {
    if (!(best_.h > 0) || reach.reaches(f, g, best_.h - rounding_)) return;
    const Vec3 n0 = face_normal(which, f), n1 = face_normal(which, g);
    const Vec3 across = n0.cross(n1);
    const double sine = across.norm();
    if (!(sine > tolerance::parallel_lines)) return;
    const Vec3 corner = body.point(static_cast<int>(v), n0);
    const auto support = [&](const Vec3& n) { return Vec3(corner + other.support(n)); };
    const Circle circle{across / sine};
    const Span span{{n0, support(n0)}, {n1, support(n1)}};
    for (const Sample* end : {&span.first, &span.last})
      if (end->out.dot(end->p) < best_.h - rounding_) try_from(end->out);
    search_spans(circle, &span, 1, 0, support, CircleFloor(other, circle, corner));
  };
  if (body.kind() == ShapeKind::box) {
    for (const FaceArc& arc : box_arcs) follow(arc.v[0], arc.face[0], arc.face[1]);
  } else if (body.kind() == ShapeKind::triangle) {
    for (const std::uint32_t i : {0u, 1u, 2u})
      for (const std::uint32_t face : {0u, 1u}) follow(i, face, 2 + i);
  } else {
    for (const Hull::Edge& e : body.hull().edges) follow(e.v[0], e.face[0], e.face[1]);
  }
}

/// From the normals of a hull's faces that are less far: those of a flat hull lie so near each other that a descent from
/// a polytope's face finds one of their minima.
void Search::try_faces(int which) {
  const RoundBody &body = pair_.body[which], &other = pair_.body[1 - which];
  const Hull& hull = body.hull();
  for (const Hull::Face& face : hull.faces) {
    const Vec3 n = body.axes() * face.normal;
    const Vec3 corner = body.axes() * hull.vertices[hull.loop[face.first]] + body.centre();
    if (best_.h > 0 && n.dot(corner + other.support(n)) < best_.h - rounding_) try_from(n);
  }
}

/// The least of h of a hull that is hardly deep, all around those of its edges that reach as far as its deepest corner: a
/// needle's have minima so near each other that descents from a polytope's faces find one of them.
void Search::search_near_edges(int which) {
  if (!(best_.h < tolerance::near_surface * pair_.scale)) return;
  const RoundBody& body = pair_.body[which];
  const Hull& hull = body.hull();
  const Vec3 m = body.axes().transpose() * best_.n;
  const double level = m.dot(hull.vertices[static_cast<std::size_t>(body.support_piece(best_.n))]) -
                       tolerance::near_features * pair_.scale;
  for (const Hull::Edge& e : hull.edges) {
    const Vec3 &p = hull.vertices[e.v[0]], &q = hull.vertices[e.v[1]];
    if (best_.h > 0 && m.dot(p) >= level && m.dot(q) >= level)
      search_circle(which, {body.axes() * (q - p).stableNormalized()}, true);
  }
}

/// The least of h on spans of a circle, where it is `add` more than `supporting` reaches. Between two directions h is
/// at least what the points that support them reach; where that is less than the best known, the direction in which
/// both reach as far is looked at too.
template <class Supporting>
void Search::search_spans(const Circle& circle, const Span* spans, int count, double add, const Supporting& supporting,
                          const CircleFloor& floor) {
  constexpr int most = 96, most_spans = 8;
  constexpr double narrow = 0.1;
  const double lift = circle.height, radius = circle.radius;
  const auto direction = [&](const Vec3& out) { return Vec3(lift * circle.axis + radius * out); };
  const auto evaluate = [&](const Vec3& out) {
    const Vec3 n = direction(out), p = supporting(n);
    if (n.dot(p) + add < best_.h - rounding_) try_from(n);
    return Sample{out, p};
  };
  Span stack[most_spans + most];
  int height = count;
  std::copy(spans, spans + count, stack);
  // Where the larger of what the two ends' points reach is least: where they
  // are equal, or one of them least.
  const auto lowest = [&](const Span& span, Vec3& out) {
    const Vec3 &u = span.first.out, v = circle.axis.cross(u), apart = span.first.p - span.last.p;
    double least = infinity;
    const auto consider = [&](const Vec3& at) {
      const Vec3 n = direction(at);
      const double value = std::max(n.dot(span.first.p), n.dot(span.last.p)) + add;
      if (value < least) least = value, out = at;
    };
    // k + a cos + b sin = 0, in the tangent of half the angle.
    const double k = lift * apart.dot(circle.axis), a = radius * apart.dot(u), b = radius * apart.dot(v);
    const double root = std::sqrt(std::max(0.0, b * b + a * a - k * k)) - b;
    if (root > 0) {
      const double t = std::max(0.0, k + a) / root;
      consider(((1 - t * t) * u + 2 * t * v) / (1 + t * t));
    }
    if (lift != 0 || add != 0)
      for (const Sample* end : {&span.first, &span.last}) {
        const Vec3 inward = end->p.dot(circle.axis) * circle.axis - end->p;
        const double length = inward.norm();
        if (!(length > rounding_ && inward.dot(v) > 0 && circle.axis.dot(inward.cross(span.last.out)) > 0)) continue;
        const Vec3 at = inward / length;
        consider((at - at.dot(circle.axis) * circle.axis).normalized());
      }
    return least;
  };
  // One end's point may reach as far at the other end: then between them too, unless it is least there.
  const auto ruled_out = [&](const Span& span) {
    const auto reaches = [&](const Vec3& p, const Vec3& out, const Vec3& own) {
      const double limit = best_.h - rounding_ - add - lift * circle.axis.dot(p);
      return radius * out.dot(p) >= limit && (limit >= 0 || own.dot(p) >= 0);
    };
    return reaches(span.first.p, span.last.out, span.first.out) || reaches(span.last.p, span.first.out, span.last.out);
  };
  for (int looked = 0; height > 0;) {
    const Span span = stack[--height];
    if (ruled_out(span)) continue;
    Vec3 out;
    double least = lowest(span, out);
    if (least >= best_.h - rounding_) continue;
    least = std::max(least, floor.over(span) + add);
    if (least >= best_.h - rounding_) continue;
    if (looked == most) {
      gap_ = std::max(gap_, best_.h - least);
      continue;
    }
    const Vec3 along = span.last.out - span.first.out;
    const double width = along.squaredNorm();
    if (width < narrow * narrow) {
      // So short a span holds one minimum, unless what is found from it lies elsewhere.
      const auto holds = [&](const Vec3& n) {
        const Vec3 to = n - direction(span.first.out);
        const double place = to.dot(along) / (radius * width);
        return std::abs(n.dot(circle.axis) - lift) < tolerance::flush && to.squaredNorm() < narrow * narrow && place > -0.01 &&
               place < 1.01;
      };
      bool known = false;
      for (int i = 0; i < known_count_ && !known; ++i) known = holds(known_[i]);
      // From beside a narrow one a descent leads past it: then only what the points say counts.
      constexpr double beside = 1e-3;
      if (known || (width > beside * beside && holds(try_from(direction(out))))) continue;
    }
    const Sample middle = evaluate(out);
    ++looked;
    if (best_.h < 0) return;
    if (direction(out).dot(middle.p) + add - least <= rounding_) continue;
    stack[height++] = {span.first, middle};
    stack[height++] = {middle, span.last};
  }
}

/// Minima where h is smooth: on a circle of each.
void Search::search_circles() {
  CircleDistance circles(pair_.body[0], pair_.body[1]);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      if (best_.h > 0 && pair_.body[0].is_circle(i) && pair_.body[1].is_circle(j) && circles.take(i, j, best_.h, rounding_))
        search_circles(circles);
}

/// By branch and bound: arcs of the smaller circle are halved until they are known to have one minimum, or none.
void Search::search_circles(const CircleDistance& circles) {
  using Sample = CircleDistance::Sample;
  using Minima = CircleDistance::Minima;
  constexpr int most = 400, deepest = 64;  // 53 halvings leave nothing
  const auto evaluate = [&](const Sample& s) {
    const double limit = best_.h - rounding_;
    if (!(s.squared < limit * limit && s.squared > rounding_ * rounding_ && circles.supports(s, rounding_))) return;
    const Vec3 n = circles.direction(s);
    if (n.dot(pair_.support(n)) < limit) try_from(n);
  };
  const double nothing = rounding_ / std::min(pair_.body[0].radius(), pair_.body[1].radius());
  CircleDistance::Arc stack[CircleDistance::most_arcs + deepest];
  int height = circles.arcs(best_.h, rounding_, stack);
  for (int halved = 0; height > 0 && best_.h > rounding_;) {
    const CircleDistance::Arc arc = stack[--height];
    if (!circles.may_have_minimum(arc, best_.h, rounding_)) continue;
    const double limit = best_.h - rounding_, least = circles.least_squared(arc);
    if (least >= limit * limit) continue;
    const Minima minima = circles.minima(arc);
    if (minima == Minima::one) evaluate(circles.minimum(arc));
    // An arc as short as rounding is what its ends are, and these were looked at.
    if (minima != Minima::unknown || arc.chord2() <= nothing * nothing) continue;
    if (halved++ >= most) {
      gap_ = std::max(gap_, best_.h - std::sqrt(std::max(0.0, least)));
      continue;
    }
    const Sample middle = circles.middle(arc);
    evaluate(middle);
    stack[height++] = {arc.first, middle};
    stack[height++] = {middle, arc.last};
  }
}

/// Minima where h is smooth, on two ellipsoids: from wherever Newton's step is not seen to lead to a known one.
void Search::search_smooth() {
  // The corners of an icosahedron and the middles of its edges: 42 directions,
  // none farther than 21 degrees from one.
  constexpr double phi = 1.61803398874989484820, c = 0.52573111211913360603, d = phi * c;
  constexpr double q = 0.5 / phi, w = 0.5 * phi;
  constexpr double base[21][3] = {{0, c, d},    {0, c, -d},   {c, d, 0},    {c, -d, 0},   {d, 0, c},    {-d, 0, c},
                                  {1, 0, 0},    {0, 1, 0},    {0, 0, 1},    {q, 0.5, w},  {-q, 0.5, w}, {q, -0.5, w},
                                  {q, 0.5, -w}, {0.5, w, q},  {-0.5, w, q}, {0.5, -w, q}, {0.5, w, -q}, {w, q, 0.5},
                                  {-w, q, 0.5}, {w, -q, 0.5}, {w, q, -0.5}};
  constexpr double cosine = 0.934, sine = 0.358, far = 1.0;
  const auto evaluate = [&](const Vec3& n, const Vec3& p) {
    const double h = n.dot(p);
    const Vec3 across = p - h * n;
    if (h * cosine - across.norm() * sine >= best_.h) return;
    const Vec3 u = any_perpendicular(n), v = n.cross(u);
    double m[3] = {-h, 0, -h};
    for (const RoundBody& body : pair_.body) body.add_curvature(body.support_piece(n), n, u, v, m);
    const double det = m[0] * m[2] - m[1] * m[1];
    if (m[0] + m[2] > 0 && det > 0) {
      const double gu = across.dot(u), gv = across.dot(v);
      const double x = -(m[2] * gu - m[1] * gv) / det, y = -(m[0] * gv - m[1] * gu) / det;
      if (x * x + y * y < far * far) {
        const Vec3 target = (n + x * u + y * v).normalized();
        for (int k = 0; k < known_count_; ++k)
          if ((known_[k] - target).squaredNorm() < 0.1 * 0.1) return;
      }
    }
    try_from(n);
  };
  for (const auto& b : base) {
    const Vec3 n{b[0], b[1], b[2]};
    const Vec3 p = pair_.support(n);
    evaluate(n, p);
    evaluate(-n, pair_.opposite(n, p));
    if (best_.h < 0) return;
  }
}

Depth Search::run() {
  try_axes();
  Depth r;
  const auto has = [&](ShapeKind k) { return pair_.body[0].kind() == k || pair_.body[1].kind() == k; };
  for (int which = 0; which < 2 && best_.h > 0; ++which) {
    const RoundBody& body = pair_.body[which];
    if (reach_[which].known()) {
      search_arcs(which);
    } else if (body.kind() == ShapeKind::convex && pair_.body[1 - which].has_circle()) {
      // Between a flat hull's face and its back, or all around a segment.
      const Hull& hull = body.hull();
      for (const Hull::Edge& e : hull.edges)
        if (best_.h > 0)
          search_circle(which, {body.axes() * (hull.vertices[e.v[1]] - hull.vertices[e.v[0]]).stableNormalized()},
                        true);
    } else if (body.kind() == ShapeKind::convex) {
      try_faces(which);
      search_near_edges(which);
    } else {
      Circle circles[3];
      const int count = body.kinks(circles);
      for (int i = 0; i < count && best_.h > 0; ++i) search_circle(which, circles[i], true);
    }
  }
  if (best_.h > 0) {
    // Among stretched ellipsoids, and between one and what has edges, a minimum may be narrower than a grid of
    // directions: of such pairs one in 500 got a depth too large from it, up to 2 %.
    constexpr double stretched = 4;
    const RoundBody &a = pair_.body[0], &b = pair_.body[1];
    const bool ellipsoid = has(ShapeKind::ellipsoid);
    if (ellipsoid && (is_point(a) || is_point(b))) {
      const RoundBody &body = a.kind() == ShapeKind::ellipsoid ? a : b, &point = &body == &a ? b : a;
      const Vec3 radii{body.view().param[0], body.view().param[1], body.view().param[2]};
      const Vec3 n = nearest_normal(radii, -(body.axes().transpose() * (body.centre() + point.support(best_.n))));
      try_from((body.axes() * n).stableNormalized());
      r.best = best_;
      return r;
    }
    const auto smooth = [](const RoundBody& body) {
      return body.kind() == ShapeKind::sphere || (body.kind() == ShapeKind::ellipsoid && body.aspect() <= stretched);
    };
    if (ellipsoid && !(smooth(a) && smooth(b))) {
      // Where h is as low all around the axis, points of a polytope would have to be as dense there as the bound is
      // tight.
      const double off = off_axis(), around = off < infinity ? search_meridian() + 2 * off : infinity;
      if (around > tolerance::search_left * pair_.scale && best_.h > 0) gap_ = std::max(gap_, expand());
      gap_ = std::min(gap_, around);
    } else if (ellipsoid) {
      search_smooth();
    } else if (a.has_circle() && b.has_circle()) {
      search_circles();
    }
  }
  r.best = best_;
  r.gap = best_.h > 0 ? gap_ : 0;
  return r;
}

}  // namespace

Depth least_depth(const RoundPair& pair, const Support& start, bool descended) {
  return Search(pair, start, descended).run();
}

}  // namespace tandem
