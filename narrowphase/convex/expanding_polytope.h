// The polytope of points of A - B that the expanding polytope algorithm grows: faces with half-edges, and the list of
// those that may be nearest the origin.
#pragma once
#include <algorithm>
#include <array>

#include "convex/simplex.h"
#include "shapes/triangle_height.h"
#include "tolerances.h"

namespace tandem::epa {

/// A half-edge of a face: four times the number of the face, plus the edge's number in it.
constexpr int half_edge(int face, int edge) { return face << 2 | edge; }

struct alignas(64) Face {
  enum : int { none = -1, seen = -2 };
  int v[4];         ///< vertices, the first repeated
  int across[3];    ///< for the edge v[i] -> v[i + 1] the half-edge in the adjacent face
  int place;        ///< position in the list of candidates; `none`; `seen` by an added point: removed
  double plane[4];  ///< unit outward normal (zero for a sliver) and offset

  Vec3 normal() const { return {plane[0], plane[1], plane[2]}; }
  double offset() const { return plane[3]; }
  double along(const Vec3& p) const { return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2]; }
};

struct HorizonEdge {
  int across;  ///< half-edge in the face that stays
  int from;    ///< the vertex where it begins, in the orientation of the new face
};

/// Memory for a polytope with a given number of vertices. Faces are numbered in order of creation and never reused.
template <int Vertices>
struct Workspace {
  static constexpr int max_vertices = Vertices, max_faces = 7 * Vertices;
  MinkowskiPoint vertex[max_vertices];
  Face face[max_faces];
  double candidate_offset[max_faces];
  int candidate[max_faces];
  HorizonEdge horizon[2 * max_vertices + 1];  // the first repeated
  int pending[3 * max_faces];
};

/// The memory of a workspace of any size.
struct PolytopeMemory {
  template <int Vertices>
  explicit PolytopeMemory(Workspace<Vertices>& w)
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
  Polytope(const MinkowskiDifference& d, const PolytopeMemory& memory)
      : vertex(memory.vertex), d_(d), memory_(memory) {}

  int vertices = 0;
  MinkowskiPoint* vertex;
  Vec3 base_normal;  ///< after span(): a normal of the plane, line or point of the first three vertices

  /// Finds four points that span a volume, from the start's and from supports; returns the dimension reached (3:
  /// success).
  int span(const Simplex& start);
  void close_tetrahedron();
  /// The face whose plane is nearest the origin along its outward normal, among those below the limit; -1: none.
  int nearest_face() const;
  /// Sets an upper bound: faces whose offset is not below it can no longer be the nearest.
  void limit(double upper) { limit_ = std::min(limit_, upper); }

  enum class Added { yes, full, torn };  ///< torn: the horizon is not a single loop, because of rounding
  /// Adds the last vertex, number `vertices`, which lies beyond `face`.
  Added add(int face);
  /// Adds it if it lies outside the polytope.
  Added include();

  const Face& face(int i) const { return memory_.face[i]; }
  double rounding() const { return rounding_; }

 private:
  /// Makes face number i with the vertices a, b, c and the plane l of the batch.
  void new_face(int i, int a, int b, int c, std::size_t l);
  /// Makes the triangles between the apex and the first `count` edges of the horizon, a loop.
  void fan(int apex, int count);
  void drop(int face);

  const MinkowskiDifference& d_;
  PolytopeMemory memory_;
  double rounding_ = 0;
  double limit_ = infinity;
  int faces_ = 0;
  int candidates_ = 0;
  PlaneKernel planes_ = plane_kernel();
  LeastKernel least_ = least_kernel();
  PlaneBatch batch_;
};

/// Selects the most distant points, by a given measure, among the start's and among supports along axes.
class Farthest {
 public:
  Farthest(const MinkowskiDifference& d, const Simplex& start) : d_(d), start_(start), at_(start.p[0]) {}

  template <class Distance>
  void of_start(const Distance& distance) {
    best_ = 0;
    for (int i = 1; i < start_.count; ++i) consider(distance(start_.p[i].w), start_.p[i]);
  }
  template <class Distance>
  void along(const Vec3& axis, const Distance& distance) {
    for (const double sign : {1.0, -1.0}) {
      const MinkowskiPoint p = d_.support(sign * axis);
      consider(distance(p.w), p);
    }
  }
  double distance() const { return best_; }
  const MinkowskiPoint& point() const { return at_; }

 private:
  void consider(double distance, const MinkowskiPoint& p) {
    if (distance > best_) best_ = distance, at_ = p;
  }

  const MinkowskiDifference& d_;
  const Simplex& start_;
  double best_ = 0;
  MinkowskiPoint at_;
};

inline int Polytope::span(const Simplex& start) {
  // The most distant among the start's points and supports along the axes are a sound seed if the start is thin.
  vertices = 0;
  const double reach = farthest_from_origin(start);
  rounding_ = 8 * epsilon * (d_.scale() + reach);
  if (is_solid(d_, start)) {
    for (; vertices < 4; ++vertices) vertex[vertices] = start.p[vertices];
    base_normal = (vertex[1].w - vertex[0].w).cross(vertex[2].w - vertex[0].w);
    return 3;
  }
  vertex[vertices++] = start.p[0];
  // The start's points are used unless they lie this close.
  const double thin = tolerance::thin_start * (d_.scale() + reach);

  Farthest next(d_, start);
  const auto from_point = [&](const Vec3& w) { return (w - vertex[0].w).norm(); };
  next.of_start(from_point);
  if (next.distance() <= thin)
    for (int k = 0; k < 3; ++k) next.along(Vec3::Unit(k), from_point);
  if (next.distance() <= rounding_) {
    base_normal = Vec3::UnitX();
    return 0;
  }
  vertex[vertices++] = next.point();

  const Vec3 line = (vertex[1].w - vertex[0].w).normalized();
  const auto from_line = [&](const Vec3& w) { return line.cross(w - vertex[0].w).norm(); };
  next.of_start(from_line);
  if (next.distance() <= thin) {
    const Vec3 e1 = any_perpendicular(line), e2 = line.cross(e1);
    next.along(e1, from_line);
    next.along(e2, from_line);
  }
  if (next.distance() <= rounding_) {
    base_normal = any_perpendicular(line);
    return 1;
  }
  vertex[vertices++] = next.point();

  base_normal = unit(normal_of(vertex[1].w - vertex[0].w, vertex[2].w - vertex[1].w, vertex[0].w - vertex[2].w));
  const auto from_plane = [&](const Vec3& w) { return std::abs(base_normal.dot(w - vertex[0].w)); };
  next.of_start(from_plane);
  if (next.distance() <= thin) next.along(base_normal, from_plane);
  if (next.distance() <= rounding_) return 2;
  vertex[vertices++] = next.point();
  return 3;
}

inline void Polytope::new_face(int i, int a, int b, int c, std::size_t l) {
  Face& f = memory_.face[i];
  f.v[0] = f.v[3] = a, f.v[1] = b, f.v[2] = c;
  for (int k = 0; k < 3; ++k) f.plane[k] = batch_.normal[k][l];
  const double offset = f.plane[3] = batch_.offset[l];
  const bool candidate = offset < limit_;
  const int place = candidates_;
  memory_.candidate[place] = i;
  memory_.candidate_offset[place] = offset;
  f.place = candidate ? place : Face::none;
  candidates_ = place + (candidate ? 1 : 0);
}

inline void Polytope::fan(int apex, int count) {
  const Vec3& r = vertex[apex].w;
  HorizonEdge* const edge = memory_.horizon;
  Face* const faces = memory_.face;
  edge[count] = edge[0];
  const int first = faces_;
  for (int done = 0; done < count;) {
    const int n = std::min(static_cast<int>(PlaneBatch::most), count - done);
    for (int l = 0; l <= n; ++l) {
      const double* const p = vertex[edge[done + l].from].w.data();
      batch_.loop[0][l] = p[0], batch_.loop[1][l] = p[1], batch_.loop[2][l] = p[2];
    }
    planes_(static_cast<std::size_t>(n), rounding_ * rounding_, r[0], r[1], r[2], batch_);
    for (int l = 0; l < n; ++l, ++done) {
      const int i = first + done;
      new_face(i, edge[done].from, edge[done + 1].from, apex, static_cast<std::size_t>(l));
      Face& f = faces[i];
      const int across = edge[done].across;
      f.across[0] = across;
      f.across[1] = half_edge(i + 1, 2);
      f.across[2] = half_edge(i - 1, 1);
      faces[across >> 2].across[across & 3] = half_edge(i, 0);
    }
  }
  faces_ += count;
  faces[first].across[2] = half_edge(faces_ - 1, 1);
  faces[faces_ - 1].across[1] = half_edge(first, 2);
}

inline void Polytope::drop(int face) {
  const int place = memory_.face[face].place;
  if (place < 0) return;
  --candidates_;
  memory_.candidate[place] = memory_.candidate[candidates_];
  memory_.candidate_offset[place] = memory_.candidate_offset[candidates_];
  memory_.face[memory_.candidate[place]].place = place;
}

inline void Polytope::close_tetrahedron() {
  if (base_normal.dot(vertex[3].w - vertex[0].w) > 0) std::swap(vertex[1], vertex[2]);
  // Now vertex 3 lies below the plane of 0, 1, 2.
  for (int l = 0; l < 2; ++l)
    for (int k = 0; k < 3; ++k) batch_.loop[k][l] = vertex[l].w[k];
  const Vec3& c = vertex[2].w;
  planes_(1, rounding_ * rounding_, c[0], c[1], c[2], batch_);
  new_face(faces_++, 0, 1, 2, 0);
  memory_.horizon[0] = {half_edge(0, 0), 1};
  memory_.horizon[1] = {half_edge(0, 2), 0};
  memory_.horizon[2] = {half_edge(0, 1), 2};
  fan(3, 3);
}

inline int Polytope::nearest_face() const {
  const auto count = static_cast<std::size_t>(candidates_);
  const std::size_t least = least_(memory_.candidate_offset, count, limit_);
  return least == count ? -1 : memory_.candidate[least];
}

inline Polytope::Added Polytope::add(int face) {
  if (vertices + 1 >= memory_.max_vertices) return Added::full;
  const Vec3& w = vertex[vertices].w;
  // Depth-first search over the faces that the point sees, edge by edge in the faces' orientation, so that the horizon
  // comes out in order. Faces in the new point's plane count as seen, so that no new face is a sliver along an old
  // edge.
  Face* const faces = memory_.face;
  int* const pending = memory_.pending;
  int stack = 0, edges = 0, end = -1;
  bool loop = true;
  const auto enter = [&](int f, int from) {
    constexpr int others[3][2] = {{2, 1}, {0, 2}, {1, 0}};
    drop(f);
    faces[f].place = Face::seen;
    for (const int i : others[from]) pending[stack++] = faces[f].across[i];
  };
  enter(face, 0);
  pending[stack++] = faces[face].across[0];
  while (stack > 0) {
    const int at = pending[--stack], f = at >> 2, i = at & 3;
    if (faces[f].place == Face::seen) continue;
    if (faces[f].along(w) > faces[f].offset() - rounding_) {
      enter(f, i);
    } else {
      if (edges == 2 * memory_.max_vertices) return Added::full;
      const int from = faces[f].v[i + 1];
      loop = loop && (edges == 0 || from == end);
      end = faces[f].v[i];
      memory_.horizon[edges++] = {at, from};
    }
  }
  if (edges < 3 || !loop || end != memory_.horizon[0].from) return Added::torn;
  if (faces_ + edges > memory_.max_faces) return Added::full;
  fan(vertices, edges);
  ++vertices;
  return Added::yes;
}

inline Polytope::Added Polytope::include() {
  const Vec3& w = vertex[vertices].w;
  for (int f = 0; f < faces_; ++f)
    if (memory_.face[f].place != Face::seen && memory_.face[f].along(w) > memory_.face[f].offset() + rounding_)
      return add(f);
  return Added::yes;
}

}  // namespace tandem::epa
