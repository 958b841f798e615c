#include "epa.h"

#include <limits>

namespace tandem {
namespace {

constexpr int max_vertices = 160;
constexpr int max_faces = 2 * max_vertices;  // a closed triangulation has 2 v - 4
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double epsilon = std::numeric_limits<double>::epsilon();

struct Face {
  int v[3];
  int next[3];  ///< the face across the edge v[i] -> v[i + 1]; -1: the slot is free
  Vec3 normal;  ///< unit, outward
};

class Polytope {
 public:
  explicit Polytope(const MinkowskiDifference& d) : d_(d) {}

  int vertices = 0;
  MinkowskiPoint vertex[max_vertices];

  /// Four points that span a volume, from the start's and supports; returns the dimension reached (3: all is well).
  int span(const Simplex& start);
  void close_tetrahedron();
  /// The face whose plane is nearest the origin along its outward normal.
  int nearest_face() const;
  /// Adds vertex `added`, seen by `face`. False if the horizon is not one loop: rounding has the last word.
  bool add(int face, int added);
  void retire(int face) { offset_[face] = infinity; }

  const Face& face(int i) const { return face_[i]; }
  double offset(int i) const { return offset_[i]; }
  double rounding() const { return rounding_; }
  Vec3 flat_normal;  ///< after span() < 3: a normal of the flat, line or point

 private:
  int new_face(int a, int b, int c);
  void free_face(int i);

  const MinkowskiDifference& d_;
  double rounding_ = 0;
  int faces_ = 0;  ///< slots in use or free below this
  int free_ = -1;
  double offset_[max_faces];
  Face face_[max_faces];
};

int Polytope::span(const Simplex& start) {
  // The most distant of the start's points and of supports along the axes are a sound seed where the start is thin.
  vertices = 0;
  double reach = 0;
  for (int i = 0; i < start.count; ++i) reach = std::max(reach, start.p[i].w.norm());
  rounding_ = 8 * epsilon * (d_.scale() + reach);
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

int Polytope::new_face(int a, int b, int c) {
  int i = free_;
  if (i >= 0) {
    free_ = face_[i].v[0];
  } else {
    if (faces_ == max_faces) return -1;
    i = faces_++;
  }
  Face& f = face_[i];
  f.v[0] = a, f.v[1] = b, f.v[2] = c;
  const Vec3 &p = vertex[a].w, &q = vertex[b].w, &r = vertex[c].w;
  const Vec3 pq = q - p, qr = r - q, rp = p - r;
  const double pq2 = pq.squaredNorm(), qr2 = qr.squaredNorm(), rp2 = rp.squaredNorm();
  const double longest = std::max({pq2, qr2, rp2});
  const Vec3 n = longest == qr2 ? Vec3(rp.cross(pq)) : longest == rp2 ? Vec3(pq.cross(qr)) : Vec3(qr.cross(rp));
  const double length = n.norm();
  if (length > rounding_ * std::sqrt(longest)) {
    f.normal = n / length;
    offset_[i] = f.normal.dot(p.squaredNorm() <= q.squaredNorm() ? p : q);
  } else {
    f.normal.setZero();  // a sliver has no plane: it is never nearest and never seen
    offset_[i] = infinity;
  }
  return i;
}

void Polytope::free_face(int i) {
  offset_[i] = infinity;
  face_[i].next[0] = -1;
  face_[i].v[0] = free_;
  free_ = i;
}

void Polytope::close_tetrahedron() {
  const Vec3 n = (vertex[1].w - vertex[0].w).cross(vertex[2].w - vertex[0].w);
  if (n.dot(vertex[3].w - vertex[0].w) > 0) std::swap(vertex[1], vertex[2]);
  // Now 3 lies below the plane of 0, 1, 2.
  new_face(0, 1, 2);
  new_face(0, 3, 1);
  new_face(1, 3, 2);
  new_face(2, 3, 0);
  constexpr int next[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  for (int i = 0; i < 4; ++i) std::copy(next[i], next[i] + 3, face_[i].next);
}

int Polytope::nearest_face() const {
  int best = 0;
  for (int i = 1; i < faces_; ++i)
    if (offset_[i] < offset_[best]) best = i;
  return offset_[best] < infinity ? best : -1;
}

bool Polytope::add(int face, int added) {
  const Vec3& w = vertex[added].w;
  int seen[max_faces];
  int seen_count = 0;
  bool is_seen[max_faces];
  std::fill(is_seen, is_seen + faces_, false);
  seen[seen_count++] = face;
  is_seen[face] = true;
  // Faces in the new point's plane are seen too, so that no new face is a sliver along an old edge.
  for (int k = 0; k < seen_count; ++k)
    for (const int other : face_[seen[k]].next) {
      if (is_seen[other]) continue;
      const Face& f = face_[other];
      if (f.normal.dot(w - vertex[f.v[0]].w) > -rounding_ && f.normal != Vec3::Zero()) {
        is_seen[other] = true;
        seen[seen_count++] = other;
      }
    }
  struct Edge {
    int from, to, outer;
  } horizon[max_faces];
  int edges = 0;
  for (int k = 0; k < seen_count; ++k)
    for (int i = 0; i < 3; ++i) {
      const Face& f = face_[seen[k]];
      if (!is_seen[f.next[i]]) {
        if (edges == max_faces) return false;
        horizon[edges++] = {f.v[i], f.v[(i + 1) % 3], f.next[i]};
      }
    }
  if (edges < 3) return false;
  // One loop: follow it, each vertex once.
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
  if (faces_ + edges - seen_count > max_faces) return false;

  for (int k = 0; k < seen_count; ++k) free_face(seen[k]);
  int first = -1, last = -1;
  for (int k = 0; k < edges; ++k) {
    const auto [from, to, outer] = horizon[k];
    const int i = new_face(from, to, added);
    if (i < 0) return false;
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

}  // namespace

EpaResult expand(const MinkowskiDifference& d, const Simplex& start, double tolerance) {
  EpaResult r;
  Polytope p(d);
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
    return r;
  }
  p.close_tetrahedron();
  r.upper = infinity;
  int best_face[3] = {0, 1, 2};
  for (;;) {
    const int nearest = p.nearest_face();
    if (nearest < 0) break;
    r.lower = p.offset(nearest);
    if (r.lower >= r.upper - tolerance) break;
    const Face f = p.face(nearest);
    const MinkowskiPoint w = d.support(f.normal);
    const double h = f.normal.dot(w.w);
    if (h < r.upper) {
      r.upper = h;
      r.normal = f.normal;
      std::copy(f.v, f.v + 3, best_face);
    }
    if (h - r.lower <= std::max(tolerance, p.rounding())) break;
    if (p.vertices == max_vertices) break;
    p.vertex[p.vertices] = w;
    if (!p.add(nearest, p.vertices)) break;
    ++p.vertices;
  }
  if (r.upper == infinity) {  // nothing but slivers: the widest plane there is
    r.normal = any_perpendicular(p.vertex[1].w - p.vertex[0].w);
    r.upper = r.normal.dot(d.support(r.normal).w);
    r.lower = 0;
  }
  // Witness points: the origin's projection on the best face, in its vertices.
  const MinkowskiPoint &a = p.vertex[best_face[0]], &b = p.vertex[best_face[1]], &c = p.vertex[best_face[2]];
  const Vec3 q = r.upper * r.normal;
  const Vec3 n = (b.w - a.w).cross(c.w - a.w);
  double wa = n.dot((b.w - q).cross(c.w - q)), wb = n.dot((c.w - q).cross(a.w - q)),
         wc = n.dot((a.w - q).cross(b.w - q));
  wa = std::max(wa, 0.0), wb = std::max(wb, 0.0), wc = std::max(wc, 0.0);
  double sum = wa + wb + wc;
  if (!(sum > 0)) wa = sum = 1;
  r.point_a = (wa * a.a + wb * b.a + wc * c.a) / sum;
  r.point_b = r.point_a - (wa * a.w + wb * b.w + wc * c.w) / sum;
  return r;
}

}  // namespace tandem
