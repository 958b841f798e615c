#include "epa.h"

#include <memory>

#include "constants.h"

namespace tandem {
namespace {

struct Face {
  int v[3];
  int next[3];  ///< the face across the edge v[i] -> v[i + 1]
  int back[3];  ///< which edge of that face it is
  int place;    ///< among the candidates; -1: none
  bool seen;    ///< by a point added: no more a face
  Vec3 normal;  ///< unit, outward; zero for a sliver
  double offset;
};

struct HorizonEdge {
  int face, edge;  ///< the unseen face's
};

/// From the origin to the farthest point.
double reach_of(const Simplex& s) {
  double squared = 0;
  for (int i = 0; i < s.count; ++i) squared = std::max(squared, s.p[i].w.squaredNorm());
  return std::sqrt(squared);
}

/// Room for a polytope of a number of vertices. Faces are numbered in order of birth and never reused.
template <int Vertices>
struct Workspace {
  static constexpr int max_vertices = Vertices, max_faces = 7 * Vertices;
  MinkowskiPoint vertex[max_vertices];
  Face face[max_faces];
  double candidate_offset[max_faces];
  int candidate[max_faces];
  HorizonEdge horizon[2 * max_vertices];
  int pending[3 * max_faces];
};

/// What a workspace holds, whatever its size.
struct Room {
  template <int Vertices>
  explicit Room(Workspace<Vertices>& w)
      : max_vertices(w.max_vertices),
        max_faces(w.max_faces),
        vertex(w.vertex),
        face(w.face),
        candidate_offset(w.candidate_offset),
        candidate(w.candidate),
        horizon(w.horizon),
        pending(w.pending) {}
  int max_vertices, max_faces;
  MinkowskiPoint* vertex;
  Face* face;
  double* candidate_offset;
  int* candidate;
  HorizonEdge* horizon;
  int* pending;
};

class Polytope {
 public:
  Polytope(const MinkowskiDifference& d, const Room& room) : vertex(room.vertex), d_(d), room_(room) {}

  int vertices = 0;
  MinkowskiPoint* vertex;
  Vec3 flat_normal;  ///< after span() < 3: a normal of the flat, line or point

  /// Four points that span a volume, from the start's and supports; returns the dimension reached (3: all is well).
  int span(const Simplex& start);
  void close_tetrahedron();
  /// The face whose plane is nearest the origin along its outward normal, among those below the limit; -1: none.
  int nearest_face() const;
  /// Faces whose offset is not below can not be the nearest any more.
  void limit(double upper) { limit_ = std::min(limit_, upper); }

  enum class Added { yes, full, torn };  ///< torn: the horizon is not one loop, rounding has the last word
  /// Adds vertex number `vertices`, which lies beyond `face`.
  Added add(int face);

  const Face& face(int i) const { return room_.face[i]; }
  double rounding() const { return rounding_; }

 private:
  int new_face(int a, int b, int c, const Vec3& normal, double offset);
  /// The triangles (from(i), to(i), apex), i < count.
  template <class From, class To>
  void fan(int apex, int count, const From& from, const To& to);
  void link(int f, int i, int g, int j) {
    room_.face[f].next[i] = g, room_.face[f].back[i] = j;
    room_.face[g].next[j] = f, room_.face[g].back[j] = i;
  }
  void drop(int face);

  const MinkowskiDifference& d_;
  Room room_;
  double rounding_ = 0;
  double limit_ = infinity;
  int faces_ = 0;
  int candidates_ = 0;
  PlaneKernel planes_ = plane_kernel();
  LeastKernel least_ = least_kernel();
  PlaneBatch batch_;
};

int Polytope::span(const Simplex& start) {
  // The most distant of the start's points and of supports along the axes are a sound seed where the start is thin.
  vertices = 0;
  const double reach = reach_of(start);
  rounding_ = 8 * epsilon * (d_.scale() + reach);
  if (is_solid(d_, start)) {
    for (; vertices < 4; ++vertices) vertex[vertices] = start.p[vertices];
    return 3;
  }
  vertex[vertices++] = start.p[0];

  const auto farther = [](double distance, const MinkowskiPoint& p, double& best, MinkowskiPoint& at) {
    if (distance > best) best = distance, at = p;
  };
  const auto try_axis = [&](const Vec3& axis, auto&& distance, double& best, MinkowskiPoint& at) {
    for (const double sign : {1.0, -1.0}) {
      const MinkowskiPoint p = d_.support(sign * axis);
      farther(distance(p.w), p, best, at);
    }
  };
  MinkowskiPoint at = start.p[0];
  const double thin = 1e-9 * (d_.scale() + reach);  // prefer the start's points unless they lie this close

  const auto from_point = [&](const Vec3& w) { return (w - vertex[0].w).norm(); };
  double best = 0;
  for (int i = 1; i < start.count; ++i) farther(from_point(start.p[i].w), start.p[i], best, at);
  if (best <= thin)
    for (int k = 0; k < 3; ++k) try_axis(Vec3::Unit(k), from_point, best, at);
  if (best <= rounding_) {
    flat_normal = Vec3::UnitX();
    return 0;
  }
  vertex[vertices++] = at;

  const Vec3 line = (vertex[1].w - vertex[0].w).normalized();
  const auto from_line = [&](const Vec3& w) { return line.cross(w - vertex[0].w).norm(); };
  best = 0;
  for (int i = 1; i < start.count; ++i) farther(from_line(start.p[i].w), start.p[i], best, at);
  if (best <= thin) {
    const Vec3 e1 = any_perpendicular(line), e2 = line.cross(e1);
    try_axis(e1, from_line, best, at);
    try_axis(e2, from_line, best, at);
  }
  if (best <= rounding_) {
    flat_normal = any_perpendicular(line);
    return 1;
  }
  vertex[vertices++] = at;

  const Vec3 plane = line.cross(vertex[2].w - vertex[0].w).normalized();
  const auto from_plane = [&](const Vec3& w) { return std::abs(plane.dot(w - vertex[0].w)); };
  best = 0;
  for (int i = 1; i < start.count; ++i) farther(from_plane(start.p[i].w), start.p[i], best, at);
  if (best <= thin) try_axis(plane, from_plane, best, at);
  if (best <= rounding_) {
    flat_normal = plane;
    return 2;
  }
  vertex[vertices++] = at;
  return 3;
}

int Polytope::new_face(int a, int b, int c, const Vec3& normal, double offset) {
  const int i = faces_++;
  Face& f = room_.face[i];
  f.v[0] = a, f.v[1] = b, f.v[2] = c;
  f.seen = false;
  f.normal = normal;
  f.offset = offset;
  const bool candidate = offset < limit_;
  room_.candidate[candidates_] = i;
  room_.candidate_offset[candidates_] = offset;
  f.place = candidate ? candidates_ : -1;
  candidates_ += candidate ? 1 : 0;
  return i;
}

template <class From, class To>
void Polytope::fan(int apex, int count, const From& from, const To& to) {
  const Vec3& r = vertex[apex].w;
  for (int first = 0; first < count; first += static_cast<int>(PlaneBatch::most)) {
    const auto n = std::min(PlaneBatch::most, static_cast<std::size_t>(count - first));
    for (std::size_t l = 0; l < n; ++l) {
      const Vec3 &p = vertex[from(first + static_cast<int>(l))].w, &q = vertex[to(first + static_cast<int>(l))].w;
      for (int k = 0; k < 3; ++k) batch_.from[k][l] = p[k], batch_.to[k][l] = q[k];
    }
    planes_(n, rounding_ * rounding_, r[0], r[1], r[2], batch_);
    for (std::size_t l = 0; l < n; ++l)
      new_face(from(first + static_cast<int>(l)), to(first + static_cast<int>(l)), apex,
               {batch_.normal[0][l], batch_.normal[1][l], batch_.normal[2][l]}, batch_.offset[l]);
  }
}

void Polytope::drop(int face) {
  const int place = room_.face[face].place;
  if (place < 0) return;
  --candidates_;
  room_.candidate[place] = room_.candidate[candidates_];
  room_.candidate_offset[place] = room_.candidate_offset[candidates_];
  room_.face[room_.candidate[place]].place = place;
}

void Polytope::close_tetrahedron() {
  const Vec3 n = (vertex[1].w - vertex[0].w).cross(vertex[2].w - vertex[0].w);
  if (n.dot(vertex[3].w - vertex[0].w) > 0) std::swap(vertex[1], vertex[2]);
  // Now 3 lies below the plane of 0, 1, 2.
  fan(
      3, 3, [](int i) { return (i + 1) % 3; }, [](int i) { return i; });
  fan(
      2, 1, [](int) { return 0; }, [](int) { return 1; });
  for (int i = 0; i < 3; ++i) {
    link(i, 0, 3, i);
    link(i, 1, (i + 2) % 3, 2);
  }
}

int Polytope::nearest_face() const {
  const auto count = static_cast<std::size_t>(candidates_);
  const std::size_t least = least_(room_.candidate_offset, count, limit_);
  return least == count ? -1 : room_.candidate[least];
}

Polytope::Added Polytope::add(int face) {
  if (vertices + 1 >= room_.max_vertices) return Added::full;
  const Vec3& w = vertex[vertices].w;
  // Depth first, edge after edge in the faces' sense: the horizon comes out in order. Faces in the new point's plane
  // are seen too, so that no new face is a sliver along an old edge.
  Face* const faces = room_.face;
  int* const pending = room_.pending;
  int stack = 0, edges = 0;
  const auto enter = [&](int f, int from) {
    faces[f].seen = true;
    drop(f);
    for (const int i : {(from + 2) % 3, (from + 1) % 3}) pending[stack++] = 4 * faces[f].next[i] + faces[f].back[i];
  };
  enter(face, 0);
  pending[stack++] = 4 * faces[face].next[0] + faces[face].back[0];
  while (stack > 0) {
    const int f = pending[--stack] / 4, i = pending[stack] % 4;
    if (faces[f].seen) continue;
    if (faces[f].normal.dot(w) > faces[f].offset - rounding_) {
      enter(f, i);
    } else {
      if (edges == 2 * room_.max_vertices) return Added::full;
      room_.horizon[edges++] = {f, i};
    }
  }
  if (edges < 3) return Added::torn;
  if (faces_ + edges > room_.max_faces) return Added::full;
  const auto from = [&](int k) {  // along the new face's sense
    const HorizonEdge& e = room_.horizon[k];
    return faces[e.face].v[(e.edge + 1) % 3];
  };
  for (int k = 0; k < edges; ++k) {
    const HorizonEdge& e = room_.horizon[k];
    if (faces[e.face].v[e.edge] != from(k + 1 < edges ? k + 1 : 0)) return Added::torn;
  }
  const int first = faces_;
  fan(vertices, edges, from, [&](int k) { return faces[room_.horizon[k].face].v[room_.horizon[k].edge]; });
  for (int k = 0; k < edges; ++k) {
    link(first + k, 0, room_.horizon[k].face, room_.horizon[k].edge);
    if (k > 0) link(first + k - 1, 1, first + k, 2);
  }
  link(first + edges - 1, 1, first, 2);
  ++vertices;
  return Added::yes;
}

/// The origin's projection on a face: the weights of its vertices, clamped to the face.
void set_points(const MinkowskiPoint& a, const MinkowskiPoint& b, const MinkowskiPoint& c, EpaResult& r) {
  const Vec3 q = r.upper * r.normal;
  const Vec3 n = (b.w - a.w).cross(c.w - a.w);
  double wa = n.dot((b.w - q).cross(c.w - q)), wb = n.dot((c.w - q).cross(a.w - q)),
         wc = n.dot((a.w - q).cross(b.w - q));
  wa = std::max(wa, 0.0), wb = std::max(wb, 0.0), wc = std::max(wc, 0.0);
  double sum = wa + wb + wc;
  if (!(sum > 0)) wa = sum = 1;
  r.point_a = (wa * a.a + wb * b.a + wc * c.a) / sum;
  r.point_b = r.point_a - (wa * a.w + wb * b.w + wc * c.w) / sum;
}

/// False where the room was too small; the result then is the best so far.
bool expand_in(const Room& room, const MinkowskiDifference& d, const Simplex& start, double tolerance, EpaResult& r) {
  r = {};
  Polytope p(d, room);
  if (p.span(start) < 3) {
    r.normal = p.flat_normal;
    const MinkowskiPoint up = d.support(r.normal), down = d.support(-r.normal);
    const double h = r.normal.dot(up.w), opposite = -r.normal.dot(down.w);
    const bool flip = opposite < h;
    if (flip) r.normal = -r.normal;
    r.upper = r.lower = flip ? opposite : h;
    for (int i = 0; i < start.count; ++i) {
      r.point_a += start.weight[i] * start.p[i].a;
      r.point_b += start.weight[i] * (start.p[i].a - start.p[i].w);
    }
    return true;
  }
  p.close_tetrahedron();
  r.upper = infinity;
  const bool polytopes = d.polytopes();
  int best[3] = {0, 1, 2};
  auto added = Polytope::Added::yes;
  for (;;) {
    const int nearest = p.nearest_face();
    if (nearest < 0) {  // no face is nearer than the depth found
      r.lower = r.upper < infinity ? r.upper : 0;
      break;
    }
    const Face& f = p.face(nearest);
    r.lower = f.offset;
    if (r.lower >= r.upper - tolerance) break;
    p.vertex[p.vertices] = d.support(f.normal);
    const MinkowskiPoint& w = p.vertex[p.vertices];
    const double h = f.normal.dot(w.w);
    if (h < r.upper) {
      r.upper = h;
      r.normal = f.normal;
      std::copy(f.v, f.v + 3, best);
      p.limit(h);
    }
    if (h - r.lower <= std::max(tolerance, p.rounding())) break;
    if (polytopes) {
      bool own = false;
      for (const int v : f.v) own = own || (p.vertex[v].vertex_a == w.vertex_a && p.vertex[v].vertex_b == w.vertex_b);
      if (own) break;
    }
    added = p.add(nearest);
    if (added != Polytope::Added::yes) break;
  }
  if (r.upper == infinity) {  // nothing but slivers: the widest plane there is
    r.normal = any_perpendicular(p.vertex[1].w - p.vertex[0].w);
    r.upper = r.normal.dot(d.support(r.normal).w);
    r.lower = 0;
  }
  const MinkowskiPoint &a = p.vertex[best[0]], &b = p.vertex[best[1]], &c = p.vertex[best[2]];
  if (polytopes) {
    // The plane again, from the shapes' own edges.
    const Vec3 n = d.edge(a, c).cross(d.edge(b, c));
    const double length = n.norm();
    if (length > 0) {
      const Vec3 m = n / length;
      if ((m - r.normal).squaredNorm() > 64 * epsilon * epsilon) {
        const double h = m.dot(d.support(m).w);
        if (h <= r.upper + p.rounding()) r.upper = h, r.normal = m;
      }
    }
  }
  set_points(a, b, c, r);
  return added != Polytope::Added::full;
}

}  // namespace

bool is_solid(const MinkowskiDifference& d, const Simplex& s) {
  if (s.count != 4) return false;
  const Vec3 a = s.p[1].w - s.p[0].w, b = s.p[2].w - s.p[0].w, c = s.p[3].w - s.p[0].w;
  const Vec3 n = a.cross(b);
  const double thick = 1e-6 * (d.scale() + reach_of(s));
  return a.squaredNorm() > thick * thick && n.squaredNorm() > thick * thick * a.squaredNorm() &&
         std::abs(n.dot(c)) > thick * n.norm();
}

EpaResult expand(const MinkowskiDifference& d, const Simplex& start, double tolerance) {
  EpaResult r;
  Workspace<128> small;
  if (expand_in(Room(small), d, start, tolerance, r)) return r;
  const auto large = std::make_unique_for_overwrite<Workspace<4096>>();
  expand_in(Room(*large), d, start, tolerance, r);
  return r;
}

}  // namespace tandem
